#pragma once
#include <torch/types.h>

#include <Eigen/Core>
#include <vector>

#include "inhabit/reconstruct/camera.h"

namespace inhabit::reconstruct {

/// Depth in metric scale: D = scale * raw + offset (supplement 8.1), metres along the camera's axis.
struct DepthScale {
  double scale = 1;   ///< metres a unit of the network
  double offset = 0;  ///< metres
};

/// One frame's depth as its network tells it.
struct DepthMap {
  torch::Tensor raw;   ///< (height, width) float, in the network's own unit
  torch::Tensor sure;  ///< (height, width) bool: known, and several maps of the frame agree
};

/// One map from K of the same frame (of images whose hue was changed): their mean, and where it can be relied on. A
/// depth of exactly 0 is unknown. Where K > 1 the standard deviation at a pixel must be at most `uncertainty` times
/// 1.4826 the median absolute deviation of the frame's depths from their median, which no scale or offset changes.
DepthMap combined(const torch::Tensor& maps, double uncertainty);

/// (height, width) float metres; 0 where it is not sure, not in front of the camera, or beside a jump: a neighbour
/// whose depth differs by more than `jump` of it, as at the edges of objects, where networks smear.
torch::Tensor metric_depth(const DepthMap& map, const DepthScale& scale, double jump);

/// Masks (height, width) bool smaller or larger by a square of `pixels` to every side.
torch::Tensor eroded(const torch::Tensor& mask, int pixels);
/// A mask (height, width) bool, larger by a square of `pixels` to every side.
torch::Tensor dilated(const torch::Tensor& mask, int pixels);

/// A pixel and its depth.
struct DepthSample {
  Eigen::Vector3d ray;  ///< in the camera's axes, z = 1
  double depth = 0;     ///< along the camera's axis, in the unit of the map that it is from
};

/// At most `most` of the pixels of `where` that are not 0, evenly taken.
std::vector<DepthSample> samples_of(const torch::Tensor& depth, const torch::Tensor& where, const Camera& camera,
                                    int64_t most);

/// Samples whose depth is metric as points in the world.
std::vector<Eigen::Vector3d> back_projected(const std::vector<DepthSample>& samples, const Eigen::Isometry3d& to_world);

/// A metric depth map, what it is a map of, and where its camera stands.
struct View {
  int64_t frame = 0;     ///< of the motion
  torch::Tensor depth;   ///< (height, width) metres, 0: unknown
  torch::Tensor person;  ///< (height, width) bool
};

/// Where points of the world are on an image.
struct OnImage {
  int64_t row = -1;                         ///< of the nearest pixel; -1: outside the image or not before the camera
  int64_t column = -1;                      ///< of the nearest pixel; -1: see row
  double z = 0;                             ///< metres along the camera's axis
  bool inside() const { return row >= 0; }  ///< there is such a pixel; something nearer may hide the point
};
/// Where a point (world, metres) is on an image. Points nearer than 5 cm before the camera are on no pixel.
/// @param to_camera world to the camera's axes (x right, y down, z ahead)
OnImage project(const Camera& camera, const Eigen::Isometry3d& to_camera, const Eigen::Vector3d& point);

}  // namespace inhabit::reconstruct
