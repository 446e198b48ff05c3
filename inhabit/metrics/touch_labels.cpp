#include "inhabit/metrics/touch_labels.h"

#include <algorithm>

#include "inhabit/metrics/penetration.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit {
namespace {

constexpr double kTouching = 0.03, kResting = 0.3;  // metres, m/s
constexpr double kHandReach = 0.2;                  // metres from the wrist to what the hand touches
constexpr int64_t kCapsuleFrames = 256;             // measured at once: samples of a whole recording would fill memory

/// The scene without what hands do not touch.
Scene without_floor(const Scene& scene) {
  Scene solids = scene;
  const auto floor = [](const Mesh& mesh) { return is_floor(mesh.name); };
  if (std::none_of(scene.meshes.begin(), scene.meshes.end(), floor)) return without_ground(solids);
  std::erase_if(solids.meshes, floor);
  return solids;
}

bool holds_surface(const Scene& scene) {
  return (scene.points.defined() && scene.points.size(0) > 0) ||
         std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& m) { return m.faces.size(0) > 0; });
}

}  // namespace

torch::Tensor joint_speeds(const Clip& clip) {
  if (clip.frames() < 2) return torch::zeros({clip.frames(), clip.skeleton.size()});
  const torch::Tensor v = torch::diff(clip.joints, 1, 0).norm(2, 2) * clip.rate;
  return torch::cat({v, v.slice(0, -1)}, 0);
}

TouchLabels::TouchLabels(const Scene& scene, const BodyModel& body)
    : body_(&body), scene_(std::make_unique<SceneQuery>(scene)) {
  if (const Scene solids = without_floor(scene); holds_surface(solids)) solids_ = std::make_unique<SceneQuery>(solids);
}

TouchLabels::~TouchLabels() = default;

void TouchLabels::label(Clip& clip) const {
  const int64_t T = clip.frames();
  torch::Tensor deepest = torch::full({T, kStandardJoints}, -1e9);
  for (int64_t first = 0; first < T; first += kCapsuleFrames) {
    const int64_t last = std::min(T, first + kCapsuleFrames);
    const torch::Tensor depth = capsule_depths(slice(clip, first, last), *body_, *scene_);
    const torch::Tensor rows = deepest.slice(0, first, last);
    for (size_t c = 0; c < body_->capsules.size(); ++c) {
      const int j = body_->capsules[c].joint;
      if (j < kStandardJoints)
        rows.select(1, j).copy_(torch::maximum(rows.select(1, j), depth.select(1, static_cast<int64_t>(c))));
    }
  }
  clip.contact = ((deepest > -kTouching) & (joint_speeds(clip) < kResting)).to(torch::kFloat);
  clip.hand_targets = torch::zeros({T, 2, 4});
  for (const int side : {0, 1}) {
    const torch::Tensor hand = clip.contact.select(1, 20 + side);
    if (!solids_) {
      hand.zero_();
      continue;
    }
    const ClosestPoints near = solids_->closest(clip.joints.select(1, 20 + side).contiguous());
    const torch::Tensor on = hand * near.distances.lt(kHandReach).to(torch::kFloat);
    hand.copy_(on);
    clip.hand_targets.select(1, side).slice(1, 0, 3).copy_(near.points * on.unsqueeze(1));
    clip.hand_targets.select(1, side).select(1, 3).copy_(on);
  }
}

const std::vector<std::string>& told_actions() {
  static const std::vector<std::string> names = {"stand", "walk", "run", "sit"};
  return names;
}

void label_actions(Clip& clip) {
  // Speeds over half a second, so that a step is no stop.
  const int64_t T = clip.frames();
  const torch::Tensor ground = clip.joints.select(1, 0).index_select(1, torch::tensor({0, 2}));
  const int64_t half = std::min<int64_t>(8, (T - 1) / 2);
  clip.action_names = told_actions();
  clip.action = torch::zeros({T}, torch::kInt64);
  const torch::Tensor seated = clip.contact.slice(1, 0, 3).gt(0.5).any(1);
  for (int64_t t = 0; t < T; ++t) {
    const int64_t a = std::max<int64_t>(0, t - half), b = std::min(T - 1, t + half);
    const double v = b > a ? (ground[b] - ground[a]).norm().item<double>() * clip.rate / static_cast<double>(b - a) : 0;
    clip.action[t] = seated[t].item<bool>() ? 3 : v > 2.0 ? 2 : v > 0.35 ? 1 : 0;
  }
}

}  // namespace inhabit
