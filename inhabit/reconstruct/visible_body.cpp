#include "inhabit/reconstruct/visible_body.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/quantile.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

constexpr int kStep = 5;                // every so many vertices
constexpr int kEdge = 1;                // pixels of a mask's edge that may be something else
constexpr int kMissed = 3;              // pixels that an estimated body may be beside the mask
constexpr int64_t kScaleSamples = 250;  // of a frame
constexpr int64_t kPlaceSamples = 400, kSearched = 1500;
constexpr int64_t kFloorSamples = 400;  // of a frame, before those above the horizon are left out
constexpr double kBelowHorizon = 0.1;   // slope of a ray that meets the floor
constexpr double kFarthestFloor = 12;   // metres
constexpr int64_t kFewestSamples = 20;

std::vector<Vector3d> depths_as_points(const std::vector<DepthSample>& samples, const Eigen::Isometry3d& to_world,
                                       int64_t most) {
  const auto all = static_cast<int64_t>(samples.size()), count = std::min(all, most);
  std::vector<DepthSample> some;
  some.reserve(static_cast<size_t>(count));
  for (int64_t i = 0; i < count; ++i) some.push_back(samples[static_cast<size_t>(i * all / count)]);
  return back_projected(some, to_world);
}

/// Pixels below the horizon that are not the person's.
void add_floor_pixels(const DepthMap& depth, const Tensor& mask, const Camera& camera, int64_t frame, double floor,
                      SeenBody& out) {
  const Eigen::Isometry3d& to_world = camera.pose(frame);
  const double under = to_world.translation().y() - floor;
  if (!(under > 0.2)) return;
  const Tensor rest = dilated(mask, kMissed).logical_not().logical_and(depth.sure);
  for (const DepthSample& sample : samples_of(depth.raw, rest, camera, kFloorSamples)) {
    const double down = -(to_world.linear() * sample.ray).y();
    if (down > kBelowHorizon && under / down < kFarthestFloor) out.floor.push_back({sample.depth, under / down});
  }
}

}  // namespace

BodyInFrames::BodyInFrames(const Clip& motion, const BodyModel& body)
    : skin(std::make_shared<const refine::Skin>(refine::skin_of(body, refine::shape_in(motion, body)))),
      bones(bones_of(motion.skeleton)),
      poses(refine::trajectory_of(motion)) {}

refine::PosedSkin BodyInFrames::posed(int64_t frame) const {
  const refine::FramePose& pose = poses[static_cast<size_t>(frame)];
  BonesPose placed;
  pose_bones(bones, pose.local, pose.trans, placed);
  return pose_skin(*skin, pose, placed);
}

std::vector<int> visible_vertices(const BodyInFrames& body, const refine::PosedSkin& posed, const Tensor& mask,
                                  const Camera& camera, int64_t frame, int step) {
  const Eigen::Isometry3d &to_world = camera.pose(frame), to_camera = to_world.inverse();
  const auto inside = mask.accessor<bool, 2>();
  std::vector<int> out;
  for (const int v : refine::seen_vertices(*body.skin, posed, to_world.translation(), step)) {
    const OnImage at = project(camera, to_camera, posed.vertices[static_cast<size_t>(v)]);
    if (at.inside() && inside[at.row][at.column]) out.push_back(v);
  }
  return out;
}

// Not floor_under() (motion/floor.h): a camera sees where the skin ends, which depends on the person's shape.
double feet_height(const BodyInFrames& body, int64_t step) {
  std::vector<double> lowest;
  for (int64_t t = 0; t < static_cast<int64_t>(body.poses.size()); t += step) {
    lowest.push_back(HUGE_VAL);
    for (const Vector3d& v : body.posed(t).vertices) lowest.back() = std::min(lowest.back(), v.y());
  }
  return median(std::move(lowest));
}

SeenBody seen_body(const BodyInFrames& body, const DepthMap& depth, const Tensor& mask, const Camera& camera,
                   int64_t frame, double floor) {
  SeenBody out;
  const Tensor person = eroded(mask, kEdge).logical_and(depth.sure);
  out.person = samples_of(depth.raw, person, camera, kScaleSamples);
  if (static_cast<int64_t>(out.person.size()) < kFewestSamples) return {};
  const refine::PosedSkin posed = body.posed(frame);
  const Eigen::Isometry3d to_camera = camera.pose(frame).inverse();
  const auto sure = person.accessor<bool, 2>();
  const auto raw = depth.raw.accessor<float, 2>();
  for (const int v : visible_vertices(body, posed, dilated(mask, kMissed), camera, frame, kStep)) {
    const Vector3d& place = posed.vertices[static_cast<size_t>(v)];
    const OnImage at = project(camera, to_camera, place);
    out.vertices.push_back(to_camera * place);
    out.raw.push_back(sure[at.row][at.column] ? raw[at.row][at.column] : NAN);
  }
  add_floor_pixels(depth, mask, camera, frame, floor, out);
  return out;
}

refine::DepthCloud seen_cloud(const BodyInFrames& body, const View& view, const Camera& camera) {
  refine::DepthCloud out;
  const Tensor person = eroded(view.person, kEdge).logical_and(view.depth.gt(0));
  const std::vector<DepthSample> samples = samples_of(view.depth, person, camera, kSearched);
  if (static_cast<int64_t>(samples.size()) < kFewestSamples) return out;
  const Eigen::Isometry3d& to_world = camera.pose(view.frame);
  out.points = depths_as_points(samples, to_world, kPlaceSamples);
  out.all = back_projected(samples, to_world);
  out.all_points = std::make_shared<const CloudQuery>(point_rows(out.all));
  out.seen = visible_vertices(body, body.posed(view.frame), dilated(view.person, kMissed), camera, view.frame, kStep);
  return out;
}

}  // namespace inhabit::reconstruct
