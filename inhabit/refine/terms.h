#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/refine/block_band.h"
#include "inhabit/refine/problem.h"

namespace inhabit::refine {

/// Cost of a residual of squared length `squared` before its weight, and the factor of r rᵀ and of r in the equations.
struct Weighted {
  double cost;    ///< before its weight: squared / 2 where the loss does not flatten it
  double factor;  ///< 1 where the loss is squared, less where it flattens; of norm, 1 over the rounded length
};
Weighted weighted(const Loss& loss, double squared);

/// Frames that the terms of a problem tie together: how far apart at most, 0 to 3.
int coupling(const Problem& problem);

/// The unknowns of a frame. Rotations are updated on the right: R exp(delta). A joint that moves no point of any term
/// (head, wrists, all but the legs where nothing but feet is asked for) meets the others nowhere: it is solved beside
/// them, in a system of its own.
struct Unknowns {
  static constexpr int kMain = 0;  ///< the system of the root's translation and of joints that move points
  int root = -1;                   ///< column of the root's translation in the main system, or -1
  std::vector<std::array<int, 2>>
      rotations;             ///< (joints) system and column of its rotation; {-1, -1} where it is known
  std::vector<int> columns;  ///< of a frame, in each system
};
Unknowns unknowns_of(const Problem& problem);

/// The normal equations of every system at a trajectory: matrix and gradient of the cost.
struct NormalEquations {
  std::vector<BlockBand> matrices;         ///< one for each system: Gauss-Newton's second derivatives
  std::vector<Eigen::VectorXd> gradients;  ///< one for each system: (frames x columns), of the cost by every unknown
};

/// The cost of a trajectory, the sum of all terms.
double cost_of(const Problem& problem, const Trajectory& trajectory);

/// The same, and its Gauss-Newton equations. Residuals and losses are linearised at the trajectory; rows and columns of
/// fixed frames are those of the identity.
double linearise(const Problem& problem, const Unknowns& unknowns, const Trajectory& trajectory, NormalEquations& out);

/// Equations of the problem's size, all zeros, for linearise() to fill.
NormalEquations make_equations(const Problem& problem, const Unknowns& unknowns);

}  // namespace inhabit::refine
