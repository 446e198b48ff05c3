#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/math/block_band.h"
#include "inhabit/refine/problem.h"
#include "inhabit/refine/rotation_terms.h"

namespace inhabit::refine {

/// Cost of a residual of squared length `squared` before its weight, and the factor of r rᵀ and of r in the equations.
struct Weighted {
  double cost;    ///< before its weight: squared / 2 where the loss does not flatten it
  double factor;  ///< 1 where the loss is squared, less where it flattens; of norm, 1 over the rounded length
};
/// What a loss makes of a residual.
/// @param squared squared length of the residual
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
  /// A row of a Jacobian is not 0 in few columns: those that move a point. Joints between two branchings of the
  /// skeleton are a limb. Columns of the main system that move its points, in order; the last limb has all.
  std::vector<std::vector<int>> limbs;
  std::vector<int> limb_of;  ///< (joints)

  /// The limb whose columns move a point.
  int limb_of_point(const Point& point) const {
    return point.size() == 1 ? limb_of[static_cast<size_t>(point[0].joint)] : static_cast<int>(limbs.size()) - 1;
  }
};
/// The unknowns of a problem: the rotations that Problem::rotates lets change, and the root's translation where
/// Problem::moves is set.
Unknowns unknowns_of(const Problem& problem);

/// What the terms say about the places of points that enter differences in time: half pᵀ W p in the small, W diagonal
/// for every pair of frames.
struct PlaceEquations {
  Eigen::MatrixXd gradient;                ///< (rows, frames), 3 rows a point
  std::array<Eigen::MatrixXd, 4> weights;  ///< (rows, frames) of each frame and the one so far after it

  /// Adds to the weights of a frame and the one `apart` after it, rows `row` to `row` + 2.
  void add(int64_t frame, int apart, int64_t row, const Eigen::Vector3d& weight) {
    weights[static_cast<size_t>(apart)].col(frame).segment<3>(row) += weight;
  }
};

/// Terms of a single frame on points: rows of a Jacobian and residuals, both times the root of the weight.
struct FrameRows {
  std::vector<double> values;     ///< (rows, columns) row by row
  std::vector<double> residuals;  ///< (rows)
  std::vector<int> limbs;         ///< (rows) of Unknowns
  double cost = 0;                ///< of these terms
};

/// The Gauss-Newton equations of every system at a trajectory: gradients, and what their matrices are made of.
/// fill_frame() writes a frame's blocks where they are eliminated, while they are in the cache.
struct NormalEquations {
  std::vector<Eigen::VectorXd> gradients;    ///< one for each system: (frames x columns), of the cost by every unknown
  PlaceEquations places;                     ///< of the points that are tied together in time
  std::vector<double> jacobians;             ///< (frames, rows, columns padded to panels) of these points
  std::vector<int> place_limbs;              ///< (rows) of Unknowns
  std::vector<FrameRows> own;                ///< (frames)
  std::vector<RotationEquations> rotations;  ///< (joints)
};

/// The cost of a trajectory, the sum of all terms.
double cost_of(const Problem& problem, const Trajectory& trajectory);

/// The same, and its equations. Residuals and losses are linearised at the trajectory; rows and columns of fixed frames
/// are those of the identity.
double linearise(const Problem& problem, const Unknowns& unknowns, const Trajectory& trajectory, NormalEquations& out);

/// Writes the blocks of a frame and those after it in a system's matrix. Safe to call for several frames at once.
void fill_frame(const Problem& problem, const Unknowns& unknowns, const NormalEquations& equations, int system,
                int64_t frame, BlockBand& matrix);

}  // namespace inhabit::refine
