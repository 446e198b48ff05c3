#include "inhabit/refine/refine_depth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "inhabit/body/joint_limits.h"
#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/refine/weights.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

// The objectives of both stages are the paper's over the square of this: metres, what the mean distance is known to.
constexpr double kDepthSigma = 0.01;
constexpr double kRootSmooth = 0.1;    // of Eq. 17, on differences between frames of 1 / 30 s
constexpr double kPoseSmooth = 0.003;  // of Eq. 20, on joint rotations in radians in place of latents
// |a - b|^2 of two 6-D rotations a small angle apart, over the angle's square: mean of all axes.
constexpr double kSixD = 4.0 / 3;
// The pose prior: standard deviation from the motion as it was, radians of joints and root, metres, and how far beyond
// the body's limits.
constexpr double kNearPose = 0.15, kNearRootRotation = 0.2, kNearRoot = 0.1, kDepthLimit = 6 * M_PI / 180;
constexpr double kDepthHuber = 0.05, kDepthReach = 0.3;  // metres: points farther off than that are not the body's
constexpr double kDepthFar = 0.5;                        // metres, median of a cloud: it is somewhere else
constexpr int64_t kDepthOverlap = 30;                    // frames of neighbouring windows
constexpr int64_t kSearchPoints = 4000;                  // of each cloud that vertices are pulled to
constexpr int kVertexStep = 5;                           // every so many vertices are pulled

/// Evenly taken rows.
std::vector<Vector3d> some_rows(const torch::Tensor& points, int64_t most) {
  const int64_t count = std::min(most, points.size(0));
  const auto p = points.accessor<float, 2>();
  std::vector<Vector3d> out;
  for (int64_t i = 0; i < count; ++i) {
    const int64_t row = i * points.size(0) / count;
    out.emplace_back(p[row][0], p[row][1], p[row][2]);
  }
  return out;
}

class DepthRefinement {
 public:
  DepthRefinement(const Clip& clip, const CloudSequence& clouds, const DepthOptions& options)
      : clip_(clip),
        clouds_(clouds),
        options_(options),
        body_(options.body != nullptr ? *options.body : builtin_body()) {
    skin_ = std::make_shared<const Skin>(skin_of(body_, shape_in(clip, body_)));
    bones_ = bones_of(clip.skeleton);
    start_ = trajectory_of(clip);
  }

  DepthResult run() {
    Trajectory found = start_;
    const int64_t frames = clip_.frames(), window = std::max<int64_t>(options_.window, 2 * kDepthOverlap);
    for (int64_t first = 0;; first += window - kDepthOverlap) {
      const int64_t last = frames - first <= window + kDepthOverlap ? frames : first + window;
      read_clouds(first, last);
      Problem problem = problem_of(found, first, last);
      root_stage(problem);
      problem.initial = solve(problem, {15, 1e-4}).trajectory;
      pose_stage(problem);
      const Trajectory solved = solve(problem, {20, 1e-4}).trajectory;
      std::copy(solved.begin(), solved.end(), found.begin() + first);
      // What the next window does not see again.
      measure(found, first, last == frames ? last : last - kDepthOverlap);
      if (last == frames) break;
    }
    DepthResult out;
    out.before = clip_;
    out.clip = clip_of(found, clip_);
    out.distance_before = median(before_);
    out.distance_after = median(after_);
    out.moved = (out.clip.joints - clip_.joints).norm(2, {2}).mean().item<double>();
    return out;
  }

 private:
  void read_clouds(int64_t first, int64_t last) {
    read_.erase(read_.begin(), read_.begin() + static_cast<std::ptrdiff_t>(first - first_read_));
    first_read_ = first;
    for (int64_t t = first + static_cast<int64_t>(read_.size()); t < last; ++t) {
      const torch::Tensor points = clouds_.read(t);
      DepthCloud cloud;
      cloud.points = some_rows(points, options_.points);
      require_near(cloud.points, t);
      if (options_.camera) {
        cloud.all = some_rows(points, kSearchPoints);
        torch::Tensor rows = torch::empty({static_cast<int64_t>(cloud.all.size()), 3});
        for (size_t i = 0; i < cloud.all.size(); ++i)
          Eigen::Map<Eigen::Vector3f>(rows.data_ptr<float>() + 3 * i) = cloud.all[i].cast<float>();
        cloud.all_points = std::make_shared<const CloudQuery>(rows);
      }
      read_.push_back(std::move(cloud));
    }
  }

  /// Throws where a cloud is not about as large as a person or not where the body is.
  void require_near(const std::vector<Vector3d>& points, int64_t t) {
    const std::string where = clouds_.name + ", frame " + std::to_string(t);
    Vector3d low = points[0], high = points[0];
    for (const Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const double extent = (high - low).maxCoeff();
    const std::vector<double> away = distances_to_skin(*skin_, start_[static_cast<size_t>(t)], bones_, points);
    const double middle = median(away);
    before_.push_back(middle);
    char text[160];
    if (middle > kDepthFar) {
      std::snprintf(text, sizeof text,
                    "its points are %.3g m from the body in the median, over an extent of %.3g m: "
                    "are they in other units or axes than the motion?",
                    middle, extent);
      throw Error(where, text);
    }
    if (points.size() >= 10 && extent < 0.02) {
      std::snprintf(text, sizeof text, "its points lie within %.2g m: are they in metres?", extent);
      throw Error(where, text);
    }
  }

  /// What both stages have: nearness, the clouds, the frames that the window before has settled.
  Problem problem_of(const Trajectory& found, int64_t first, int64_t last) const {
    Problem out;
    out.bones = bones_;
    out.rate = clip_.rate;
    out.start = {start_.begin() + first, start_.begin() + last};
    out.initial = {found.begin() + first, found.begin() + last};
    out.points = joint_points(kStandardJoints);
    out.fixed.assign(out.start.size(), 0);
    if (first > 0) std::fill(out.fixed.begin(), out.fixed.begin() + kDepthOverlap / 2, 1);
    auto depth = std::make_shared<DepthTerm>();
    depth->skin = skin_;
    depth->clouds = read_;
    see_vertices(out.initial, depth->clouds);
    depth->weight = 2 * weight_of(kDepthSigma);
    depth->loss = {Loss::Kind::huber, kDepthHuber};
    depth->reach = kDepthReach;
    out.depth = depth;
    out.stay_near.rotations.assign(out.start.size() * kStandardJoints, weight_of(kNearPose));
    for (size_t t = 0; t < out.start.size(); ++t)
      out.stay_near.rotations[t * kStandardJoints] = weight_of(kNearRootRotation);
    out.stay_near.root.assign(out.start.size(), weight_of(kNearRoot));
    out.limits = joint_limits(body_, kStandardJoints);
    out.limit_weight = weight_of(kDepthLimit);
    return out;
  }

  /// Which vertices are pulled to the cloud is told from where the search begins.
  void see_vertices(const Trajectory& trajectory, std::vector<DepthCloud>& clouds) const {
    if (!options_.camera) return;
    BonesPose bones;
    for (size_t t = 0; t < trajectory.size(); ++t) {
      pose_bones(bones_, trajectory[t].local, trajectory[t].trans, bones);
      clouds[t].seen = seen_vertices(*skin_, pose_skin(*skin_, trajectory[t], bones), *options_.camera, kVertexStep);
    }
  }

  /// Weight of the n-th difference between frames for `weight` of the paper's.
  double smoothness(double weight, int order) const {
    return 2 * options_.smooth * weight * weight_of(kDepthSigma) * std::pow(30.0, -2 * order);
  }

  /// Eq. 17: the root's translation and rotation.
  void root_stage(Problem& problem) const {
    problem.moves = true;
    problem.rotates.assign(kStandardJoints, 0);
    problem.rotates[0] = 1;
    std::vector<double> root(kStandardJoints, 0);
    root[0] = 1;
    problem.smoothness.clear();
    for (const int order : {1, 2}) {
      const double w = smoothness(kRootSmooth, order);
      problem.smoothness.push_back({order, w, kSixD * w, {}, false, root});
    }
  }

  /// Eq. 20: the pose, with the root where the first stage has put it.
  void pose_stage(Problem& problem) const {
    problem.moves = false;
    problem.rotates.assign(kStandardJoints, 1);
    problem.rotates[0] = 0;
    std::vector<double> pose(kStandardJoints, 1);
    pose[0] = 0;
    problem.smoothness.clear();
    for (const int order : {1, 2})
      problem.smoothness.push_back({order, 0, smoothness(kPoseSmooth, order), {}, false, pose});
  }

  void measure(const Trajectory& found, int64_t first, int64_t last) {
    for (auto t = static_cast<int64_t>(after_.size()); t < last; ++t) {
      after_.push_back(median(distances_to_skin(*skin_, found[static_cast<size_t>(t)], bones_,
                                                read_[static_cast<size_t>(t - first)].points)));
    }
  }

  const Clip& clip_;
  const CloudSequence& clouds_;
  const DepthOptions& options_;
  const BodyModel& body_;
  std::shared_ptr<const Skin> skin_;
  Bones bones_;
  Trajectory start_;
  std::vector<DepthCloud> read_;  ///< of frames from first_read_ on
  int64_t first_read_ = 0;
  std::vector<double> before_, after_;  ///< (frames) median distance from the points to the skin
};

}  // namespace

DepthResult refine_to_depth(const Clip& clip, const CloudSequence& clouds, const DepthOptions& options) {
  if (!(options.smooth >= 0 && options.smooth <= 1e6)) throw Error("smooth", "is not from 0 to a million");
  if (options.window < 1 || options.points < 1)
    throw Error("depth", "windows and clouds want to have something in them");
  if (options.camera && !options.camera->allFinite()) throw Error("camera", "is not finite");
  if (clouds.frames != clip.frames())
    throw Error(clouds.name, "holds " + std::to_string(clouds.frames) + " clouds, but " + options.name + " has " +
                                 std::to_string(clip.frames()) + " frames");
  const Clip standard = retarget(clip, options.name);
  DepthResult out = DepthRefinement(standard, clouds, options).run();
  if (!options.standard) {
    std::vector<int64_t> all(static_cast<size_t>(clip.frames()));
    std::iota(all.begin(), all.end(), 0);
    SourcePoses poses = poses_of(clip, out.before, all, all, all);
    poses.exact.assign(all.size(), false);
    out.on_source = on_source_skeleton(out.clip, poses, clip.frames());
  }
  return out;
}

}  // namespace inhabit::refine
