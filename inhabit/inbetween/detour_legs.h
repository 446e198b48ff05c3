#pragma once
#include <torch/types.h>

#include <vector>

#include "inhabit/inbetween/poses.h"

namespace inhabit::inbetween {

/// Where a baseline goes around obstacles, frame by frame: legs from key to key. A displacement of the root is told
/// along the detour and to its left, so that somebody who is half a metre ahead of the baseline has taken its bend,
/// too, and does not stand in what it goes around. Where a leg is straight, that is the displacement itself.
struct DetourLegs {
  std::vector<int> from;                      ///< (T) key frame at the beginning of each frame's leg
  std::vector<int> to;                        ///< (T) key frame at its end
  std::vector<float> pace;                    ///< (T) metres a frame along it; 0 in keys and where there is no detour
  std::vector<float> direction;               ///< (T) radians in which it leads, 0 being +Z, without jumps in a leg
  std::vector<float> yaw;                     ///< (T) radians that the body is rotated by with it
  bool none() const { return pace.empty(); }  ///< there is no detour
};

/// The legs of a baseline. @param poses its own. @param yaws (T) of yaws_along. @param keys frames that constrain the
/// root. @param detours (T, 2) metres
DetourLegs detour_legs(const Poses& poses, const std::vector<double>& yaws, const std::vector<int64_t>& keys,
                       const torch::Tensor& detours);

/// A root that was displaced.
struct DisplacedRoot {
  Eigen::Vector3f place;  ///< metres, world
  float yaw = 0;          ///< radians that the detour rotates the body by beyond what it does in the baseline's frame
};
/// Where a displacement leads. @param t frame. @param heading radians, the baseline's there. @param move metres,
/// heading frame
DisplacedRoot displaced(const DetourLegs& legs, const Poses& baseline, int64_t t, float heading,
                        const Eigen::Vector3f& move);

/// The displacement (metres, heading frame) that leads to `place`. Several may, where a detour bends: that is taken
/// which is `ahead` metres along the detour, or nearest to that. @param ahead set to what it is
Eigen::Vector3f displacement_to(const DetourLegs& legs, const Poses& baseline, int64_t t, float heading,
                                const Eigen::Vector3f& place, float& ahead);

/// The legs of B windows as tensors.
struct DetourFrames {
  // (B, T) each; undefined where no window has a detour.
  torch::Tensor from;       ///< frames, DetourLegs::from
  torch::Tensor to;         ///< frames, DetourLegs::to
  torch::Tensor pace;       ///< metres a frame, DetourLegs::pace
  torch::Tensor direction;  ///< radians, DetourLegs::direction
  torch::Tensor yaw;        ///< radians, DetourLegs::yaw
  torch::Tensor heading;    ///< radians, the baseline's

  DetourFrames to_device(torch::Device device) const;  ///< the same on another device
};
/// The tensors of B baselines of one length. @param legs of each. @param headings of each
DetourFrames detour_frames(const std::vector<const DetourLegs*>& legs,
                           const std::vector<const std::vector<float>*>& headings);

/// displaced() of B windows. Differentiable.
struct DisplacedRoots {
  torch::Tensor move;  ///< (B, T, 3) metres from the baseline's root, heading frame
  torch::Tensor yaw;   ///< (B, T) radians; undefined where no window has a detour
};
/// What the displacements of B windows lead to. @param root (B, T, 3) the baselines', world. @param move (B, T, 3)
/// metres, heading frame
DisplacedRoots displaced(const DetourFrames& frames, const torch::Tensor& root, const torch::Tensor& move);

}  // namespace inhabit::inbetween
