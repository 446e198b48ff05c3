#include "inhabit/io/upright.h"

#include "inhabit/error.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/level.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr double kAlong = 0.7, kAcross = 0.3;  // parts of a mean direction

}  // namespace

std::optional<Eigen::Vector3d> mean_trunk(const Clip& clip) {
  Landmarks marks;
  try {
    marks = find_landmarks(clip.skeleton, "skeleton");
  } catch (const Error&) {
    return {};
  }
  const Tensor trunk = (clip.joints.select(1, marks.head) - clip.joints.select(1, marks.pelvis)).to(torch::kDouble);
  const Tensor mean = (trunk / trunk.norm(2, {1}, true).clamp_min(1e-9)).mean(0);
  return Eigen::Vector3d(mean[0].item<double>(), mean[1].item<double>(), mean[2].item<double>());
}

void check_told_up(const std::optional<Eigen::Vector3d>& trunk, UpAxis told, const std::string& subject, Notes* notes) {
  if (!trunk) return;
  if (told == UpAxis::z && trunk->y() > kAlong && trunk->z() < kAcross)
    throw Error(subject, "has +Y up, not +Z: the person's back points along it (--up names the axis of the input)");
  if (told == UpAxis::y && trunk->z() > kAlong && trunk->y() < kAcross && notes != nullptr)
    notes->emplace_back("+Y is taken for up as told, although the person's back points along +Z");
}

bool is_z_up(const Clip& clip, UpAxis told, const std::string& subject, Notes* notes) {
  const std::optional<Eigen::Vector3d> trunk = mean_trunk(clip);
  check_told_up(trunk, told, subject, notes);
  if (told != UpAxis::automatic) return told == UpAxis::z;
  if (!trunk || !(trunk->z() > kAlong && trunk->y() < kAcross)) return false;
  const double low_y = clip.joints.select(2, 1).min().item<double>(),
               low_z = clip.joints.select(2, 2).min().item<double>();
  if (std::abs(low_z) >= std::abs(low_y)) return false;
  if (notes != nullptr) notes->emplace_back("+Z is up in the file (detected): rotated to +Y");
  return true;
}

void rotate_upright(Clip& clip) {
  rotate_clip(clip, torch::tensor({1.F, 0.F, 0.F, 0.F, 0.F, 1.F, 0.F, -1.F, 0.F}).view({3, 3}));
}

void rotate_z_up(Clip& clip) {
  rotate_clip(clip, torch::tensor({1.F, 0.F, 0.F, 0.F, 0.F, -1.F, 0.F, 1.F, 0.F}).view({3, 3}));
}

}  // namespace inhabit
