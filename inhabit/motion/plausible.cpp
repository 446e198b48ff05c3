#include "inhabit/motion/plausible.h"

#include <spdlog/fmt/fmt.h>

#include <optional>

#include "inhabit/error.h"
#include "inhabit/motion/landmarks.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr double kShortLeg = 0.2, kLongLeg = 1.5;  // metres from hip to ankle along the bones
constexpr double kUpright = 0.3;                   // of the trunk, along the vertical
constexpr double kFastest = 12;                    // metres a second: the best sprinters

std::optional<Landmarks> landmarks_of(const Skeleton& skeleton) {
  try {
    return find_landmarks(skeleton, "skeleton");
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<std::string> implausible(const Clip& clip) {
  std::vector<std::string> out;
  const auto at = [&](int joint) { return clip.joints.select(1, joint); };
  if (const auto marks = landmarks_of(clip.skeleton)) {
    const double leg =
        ((at(marks->hip[0]) - at(marks->knee[0])).norm(2, 1) + (at(marks->knee[0]) - at(marks->ankle[0])).norm(2, 1))
            .median()
            .item<double>();
    if (leg < kShortLeg || leg > kLongLeg)
      out.push_back(
          fmt::format("implausible: the legs are {:.3g} m long; --scale says how many metres a unit has", leg));
    const Tensor trunk = at(marks->head) - at(marks->pelvis);
    const Tensor up = trunk.select(1, 1) / trunk.norm(2, 1).clamp_min(1e-9);
    const double lying = (up < kUpright).to(torch::kFloat32).mean().item<double>();
    if (lying > 0.95)
      out.push_back(fmt::format("implausible: the person {} throughout; --up says which axis of the file is up",
                                up.median().item<double>() < -kUpright ? "stands on their head" : "lies"));
  }
  if (clip.frames() < 2) return out;
  const Tensor ground = clip.root_path().index_select(1, torch::tensor({0, 2}));
  const double speed =
      (torch::diff(ground, 1, 0).norm(2, 1) * clip.rate).quantile(0.9).item<double>();  // a tenth is faster
  if (speed > kFastest)
    out.push_back(fmt::format(
        "implausible: the person moves at {:.3g} m/s; --scale and --input-rate say how large and fast it is", speed));
  return out;
}

}  // namespace inhabit
