#include "inhabit/interact/fit_contacts.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/palm.h"
#include "inhabit/interact/labels.h"
#include "inhabit/interact/recording.h"
#include "inhabit/refine/refine_clip.h"

namespace inhabit::interact {
namespace {

constexpr double kMissed = 0.25;                // metres: a contact that is no longer tried
constexpr double kNear = 0.06, kNearer = 0.02;  // metres: near it, or as near as the palm comes with so much to spare
constexpr double kSits = 0.005;                 // metres: how near the pelvis stays to where it was
// Metres that flesh sinks in: half of the 2 cm that it may, as hands that go fast along edges are some millimetres
// deeper.
constexpr double kSinks = 0.01;

}  // namespace

torch::Tensor contact_distances(const Clip& motion) {
  const Recording recording = record(motion, label(motion, std::nullopt), "motion");
  const torch::Tensor targets = motion.hand_targets.to(torch::kFloat).contiguous();
  const auto at = targets.accessor<float, 3>();
  torch::Tensor out = torch::full({motion.frames(), 2}, std::nan(""));
  for (int64_t t = 0; t < motion.frames(); ++t)
    for (int64_t side = 0; side < 2; ++side)
      if (at[t][side][3] > 0.5F)
        out[t][side] = (recording.frames[static_cast<size_t>(t)].sample.hand[static_cast<size_t>(side)] -
                        Eigen::Vector3f(at[t][side][0], at[t][side][1], at[t][side][2]))
                           .norm();
  return out;
}

Clip fit_contacts(const Clip& motion, const Scene& scene) {
  const torch::Tensor distances = contact_distances(motion).contiguous(),
                      targets = motion.hand_targets.to(torch::kFloat64).contiguous();
  const auto distance = distances.accessor<float, 2>();
  const auto at = targets.accessor<double, 3>();
  refine::Options options;
  options.standard = true;
  options.generated = true;
  options.keep_frames = {0};  // the pose that the person was given in
  options.keep_joints = {0};  // they sit where they sat, as far as the seat lets them
  options.keep_within = kSits;
  options.skin_depth = kSinks;
  options.name = "motion";
  for (int64_t side = 0; side < 2; ++side)
    for (int64_t t = 0; t < motion.frames();) {
      const auto place = [&](int64_t k) { return Eigen::Vector3d(at[k][side][0], at[k][side][1], at[k][side][2]); };
      int64_t end = t + 1;
      if (at[t][side][3] > 0.5) {
        while (end < motion.frames() && at[end][side][3] > 0.5 && (place(end) - place(t)).norm() < 1e-4) ++end;
        double least = kMissed + 1;
        for (int64_t k = t; k < end; ++k) least = std::min<double>(least, distance[k][side]);
        int64_t first = t;
        while (first < end && distance[first][side] > std::max(kNear, least + kNearer)) ++first;
        if (least <= kMissed)
          options.given.push_back({20 + static_cast<int>(side), palm_offset(static_cast<int>(side)).cast<double>(),
                                   place(t), first, end - 1});
      }
      t = end;
    }
  Clip out = refine::refine(motion, scene, options).clip;
  out.hand_targets = motion.hand_targets;
  out.action_names = motion.action_names;
  out.action = motion.action;
  return out;
}

}  // namespace inhabit::interact
