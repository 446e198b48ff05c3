#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "inhabit/refine/problem.h"

namespace inhabit::refine {

/// Coefficients of the n-th difference in time.
std::vector<double> difference(int order);

/// What a smoothness term counts for one joint.
double joint_factor(const Smoothness& smoothness, int joint);

/// What the terms say about one joint's rotation (nearness, limits, differences in time): its part of the normal
/// equations. A joint's own, so that joints are done side by side and each frame's panel is written once.
struct RotationEquations {
  std::vector<std::array<Eigen::Matrix3d, 4>> blocks;  ///< (frames, apart): rows of the later frame
  std::vector<Eigen::Vector3d> gradient;               ///< (frames)
  double cost = 0;                                     ///< of these terms
};

/// Those of every joint at a trajectory. @param linear (joints) 0: the cost alone
void add_rotation_terms(const Problem& problem, const Trajectory& trajectory, const std::vector<char>& linear,
                        std::vector<RotationEquations>& out);

}  // namespace inhabit::refine
