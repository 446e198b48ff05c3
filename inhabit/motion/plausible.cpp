#include "inhabit/motion/plausible.h"

#include <spdlog/fmt/fmt.h>

#include <optional>

#include "inhabit/error.h"
#include "inhabit/motion/landmarks.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr const char* kDoubt = "implausible: ";
constexpr double kShortLeg = 0.2, kLongLeg = 1.5;  // metres from hip to ankle along the bones
constexpr double kSmallest = 0.66;                 // metres from ankle over pelvis to head; a child of 0.9 m: 0.71
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

std::vector<std::string> implausible(const Clip& clip, MotionSource source) {
  std::vector<std::string> out;
  const bool file = source == MotionSource::file;
  const char* const scale = file ? "--scale says how many metres a unit has" : "joints are taken for metres";
  const auto at = [&](int joint) { return clip.joints.select(1, joint); };
  if (const auto marks = landmarks_of(clip.skeleton)) {
    const double leg =
        ((at(marks->hip[0]) - at(marks->knee[0])).norm(2, 1) + (at(marks->knee[0]) - at(marks->ankle[0])).norm(2, 1))
            .median()
            .item<double>();
    const Tensor trunk = at(marks->head) - at(marks->pelvis);
    const double size = leg + trunk.norm(2, 1).median().item<double>();
    if (leg < kShortLeg || leg > kLongLeg)
      out.push_back(fmt::format("{}the legs are {:.3g} m long; {}", kDoubt, leg, scale));
    else if (size < kSmallest)
      out.push_back(fmt::format("{}the person has {:.2g} m from the ankles over the pelvis to the head; {}", kDoubt,
                                size, scale));
    const Tensor up = trunk.select(1, 1) / trunk.norm(2, 1).clamp_min(1e-9);
    const double lying = (up < kUpright).to(torch::kFloat32).mean().item<double>();
    if (lying > 0.95)
      out.push_back(fmt::format(
          "{}the person {} throughout; {}", kDoubt,
          up.median().item<double>() < -kUpright ? "stands on their head" : "lies",
          file ? "--up says which axis of the file is up" : "+Y is taken for up (z of `inhabit stream` with --up z)"));
  }
  if (clip.frames() < 2) return out;
  const Tensor ground = clip.root_path().index_select(1, torch::tensor({0, 2}));
  const double speed =
      (torch::diff(ground, 1, 0).norm(2, 1) * clip.rate).quantile(0.9).item<double>();  // a tenth is faster
  if (speed > kFastest)
    out.push_back(fmt::format("{}the person moves at {:.3g} m/s; {}", kDoubt, speed,
                              file ? "--scale and --input-rate say how large and fast it is"
                                   : "joints are taken for metres, times for seconds"));
  return out;
}

bool is_doubt(const std::string& note) { return note.find(kDoubt) != std::string::npos; }

}  // namespace inhabit
