#include "inhabit/interact/evaluate.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "inhabit/body/body_model.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/interact/features.h"
#include "inhabit/interact/labels.h"
#include "inhabit/interact/recording.h"
#include "inhabit/interact/sample.h"
#include "inhabit/interact/seated.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

constexpr double kSeatHeight = 0.05, kSeatPlace = 0.15;  // metres: how near a pelvis must rest
constexpr int64_t kApdFrames = 1500;
constexpr std::array<double, 4> kPrecision = {0.03, 0.05, 0.07, 0.09};

/// The first contact of each hand while the person gets seated.
HandContacts first_contacts(const Labels& labels) {
  HandContacts out;
  const Tensor targets = labels.hand_target.to(torch::kFloat64).contiguous();
  const auto at = targets.accessor<double, 3>();
  for (int64_t side = 0; side < 2; ++side)
    for (int64_t t = 0; t < targets.size(0); ++t)
      if (at[t][side][3] > 0.5) {
        out[static_cast<size_t>(side)] = Vector3d(at[t][side][0], at[t][side][1], at[t][side][2]);
        break;
      }
  return out;
}

/// (T, 22 x 12) positions, axes and velocities of the joints as seen from the root of each frame.
Tensor pose_features(const Recording& recording) {
  Tensor out = torch::empty({recording.size(), kJoints * 12});
  for (int64_t t = 0; t < recording.size(); ++t)
    build_joints(state_at(recording, t), out.data_ptr<float>() + t * kJoints * 12);
  return out;
}

/// Eq. 5 over rows.
double pairwise_distance(const std::vector<Tensor>& rows) {
  if (rows.empty()) return std::nan("");
  Tensor all = torch::cat(rows);
  if (all.size(0) < 2) return std::nan("");
  all = all.index_select(0, torch::tensor(spread_indices(all.size(0), kApdFrames)));
  const auto n = static_cast<double>(all.size(0));
  return torch::cdist(all, all).to(torch::kFloat64).sum().item<double>() / (n * (n - 1));
}

/// Metres from the palm to a point, the least over a clip.
double closest_approach(const Recording& recording, int side, const Vector3d& point) {
  double least = HUGE_VAL;
  for (const auto& frame : recording.frames)
    least = std::min(least, (frame.sample.hand[static_cast<size_t>(side)].cast<double>() - point).norm());
  return least;
}

/// What is measured of one motion; NaN where there is no such number.
struct Run {
  enum Number { kLeft, kRight, kSeated, kFrames, kSkating, kJerk, kDepth, kNumbers };
  std::array<double, kNumbers> numbers{};  ///< metres to the contacts, seconds, frames, sums over frames, metres
  Tensor approach, sit;                    ///< (frames, 22 x 12) poses while walking and while sitting
};

Run measured(const Trial& trial, const Clip& motion, const std::string& method) {
  Run out;
  const Recording recording = record(motion, label(motion, std::nullopt), method);
  for (int side = 0; side < 2; ++side) {
    const auto& contact = trial.contacts[static_cast<size_t>(side)];
    out.numbers.at(static_cast<size_t>(side)) = contact ? closest_approach(recording, side, *contact) : std::nan("");
  }
  const std::optional<int64_t> seated = seated_from(motion, trial);
  const auto frames = static_cast<double>(motion.frames());
  out.numbers[Run::kSeated] = seated ? static_cast<double>(*seated) / motion.rate : std::nan("");
  out.numbers[Run::kFrames] = frames;
  out.numbers[Run::kSkating] = frames * foot_skating(motion).fraction();
  out.numbers[Run::kJerk] = frames * dynamics(motion).jerk;
  out.numbers[Run::kDepth] = CollisionMeter(builtin_body(), trial.scene).measure(motion).penetration();
  const Tensor features = pose_features(recording);
  out.approach = features.index({frames_of_action(motion, "walk")});
  out.sit = features.index({frames_of_action(motion, "sit")});
  return out;
}

Scores scores_of(const std::string& method, const std::vector<Run>& runs) {
  std::vector<double> errors, success, seconds, depth;
  std::array<std::vector<double>, 4> near;
  std::vector<Tensor> approach, sit;
  double skating = 0, jerk = 0, frames = 0;
  for (const Run& run : runs) {
    const auto& n = run.numbers;
    for (const double error : {n[Run::kLeft], n[Run::kRight]}) {
      if (std::isnan(error)) continue;
      errors.push_back(error);
      for (size_t k = 0; k < 4; ++k) near[k].push_back(error < kPrecision[k] ? 1 : 0);
    }
    success.push_back(std::isnan(n[Run::kSeated]) ? 0 : 1);
    if (!std::isnan(n[Run::kSeated])) seconds.push_back(n[Run::kSeated]);
    skating += n[Run::kSkating];
    jerk += n[Run::kJerk];
    frames += n[Run::kFrames];
    depth.push_back(n[Run::kDepth]);
    approach.push_back(run.approach);
    sit.push_back(run.sit);
  }
  Scores out{method,
             estimate(errors),
             {},
             estimate(success),
             estimate(seconds),
             skating / frames,
             jerk / frames,
             estimate(depth),
             pairwise_distance(approach),
             pairwise_distance(sit)};
  for (size_t k = 0; k < 4; ++k) out.precision[k] = estimate(near[k]);
  return out;
}

/// With the runs of trials that other parts measured, of each method; false where some are still to come.
bool complete(const MeasuredParts& parts, int64_t most_frames, std::vector<std::vector<Run>>& of_methods) {
  if (parts.shard().is_all() || of_methods.empty()) return true;
  const auto methods = static_cast<int64_t>(of_methods.size()), count = static_cast<int64_t>(of_methods[0].size());
  std::vector<int64_t> trials(of_methods[0].size());
  std::iota(trials.begin(), trials.end(), 0);
  std::map<std::string, Tensor> all = {{"numbers", torch::zeros({count, methods, Run::kNumbers}, torch::kDouble)},
                                       {"frames", torch::zeros({count, methods, 2}, torch::kInt64)},
                                       {"poses", torch::zeros({count, methods, most_frames, kJoints * 12})}};
  const auto each = [&](const auto& work) {
    for (const int64_t i : trials)
      for (int64_t m = 0; m < methods; ++m)
        work(i, of_methods[static_cast<size_t>(m)][static_cast<size_t>(i)], all["numbers"][i][m].data_ptr<double>(),
             all["frames"][i][m], all["poses"][i][m]);
  };
  each([&](int64_t i, Run& run, double* numbers, const Tensor& frames, const Tensor& poses) {
    if (!parts.shard().has(i)) return;
    std::copy(run.numbers.begin(), run.numbers.end(), numbers);
    const int64_t walking = run.approach.size(0), sitting = run.sit.size(0);  // frames are one or the other
    frames.copy_(torch::tensor({walking, sitting}));
    poses.narrow(0, 0, walking).copy_(run.approach);
    poses.narrow(0, walking, sitting).copy_(run.sit);
  });
  if (!parts.complete(trials, all)) return false;
  each([&](int64_t, Run& run, const double* numbers, const Tensor& frames, const Tensor& poses) {
    std::copy_n(numbers, run.numbers.size(), run.numbers.begin());
    const auto walking = frames[0].item<int64_t>(), sitting = frames[1].item<int64_t>();
    run.approach = poses.narrow(0, 0, walking).clone();
    run.sit = poses.narrow(0, walking, sitting).clone();
  });
  return true;
}

/// Idle, walk or sit of every frame, as generated motion has them.
void set_actions(const Labels& labels, Clip& clip) {
  clip.action_names = kActionNames;
  clip.action = labels.action.argmax(1);
}

/// Nothing where nobody sits.
std::optional<Trial> trial_of(const Dataset& set, const std::string& folder, const DatasetClip& entry, double seconds) {
  if (entry.scene.empty()) return std::nullopt;
  const Clip clip = load_clip(set, entry);
  Scene scene = load_scene(set, entry.scene);
  const std::optional<Chair> chair = chair_of(clip, scene);
  if (!chair) return std::nullopt;
  const Labels labels = label(clip, chair);
  Trial trial{folder + "/" + entry.file, std::move(scene), *chair, slice(clip, 0, 1), first_contacts(labels), clip, 0,
              folder + "/" + entry.scene};
  trial.rest = stays_of(clip).front().rest.y() - chair->seat().y();
  set_actions(labels, trial.truth);
  trial.truth = slice(trial.truth, 0, std::min(clip.frames(), static_cast<int64_t>(seconds * clip.rate)));
  return trial;
}

/// Somebody who stays as they are.
Clip waiting(const Clip& start, double seconds) {
  const auto frames = static_cast<int64_t>(std::lround(seconds * start.rate));
  Clip out = frames_at(start, std::vector<int64_t>(static_cast<size_t>(frames), 0));
  out.action_names = kActionNames;
  out.action = torch::zeros({frames}, torch::kInt64);
  return out;
}

}  // namespace

std::optional<int64_t> seated_from(const Clip& clip, const Trial& trial) {
  const Tensor root = clip.joints.select(1, 0).to(torch::kFloat64).contiguous();
  const auto at = root.accessor<double, 2>();
  int64_t first = clip.frames();
  for (int64_t t = clip.frames() - 1; t >= 0; --t) {
    const Vector3d off = trial.chair.off({at[t][0], at[t][1], at[t][2]});
    if (std::abs(off.y() - trial.rest) > kSeatHeight || std::hypot(off.x(), off.z()) > kSeatPlace) break;
    first = t;
  }
  if (clip.frames() - first < static_cast<int64_t>(clip.rate)) return std::nullopt;
  return first;
}

std::vector<Trial> trials_of(const std::vector<std::string>& folders, const std::string& split, int64_t count,
                             double seconds) {
  std::vector<Trial> all;
  for (const std::string& folder : folders) {
    const Dataset set = open_dataset(folder);
    const std::vector<DatasetClip> entries = set.split(split);
    const auto size = static_cast<int64_t>(entries.size());
    int64_t next = 0;  // no clip is taken twice
    for (const int64_t i : spread_indices(size, count)) {
      std::optional<Trial> trial;
      for (next = std::max(next, i); next < size && !trial; ++next)
        trial = trial_of(set, folder, entries[static_cast<size_t>(next)], seconds);
      if (trial) all.push_back(std::move(*trial));
    }
  }
  return all;
}

InteractMethod model_method(const std::string& name, std::shared_ptr<const ChairInteractor> interactor, double seconds,
                            const Use& use) {
  return {name + (use.raw ? "" : ", fitted") + (use.straight ? ", no route planned" : ""),
          [name, interactor = std::move(interactor), seconds, use](const Trial& trial, uint64_t seed) {
            Options options;
            options.contacts = {trial.contacts};
            options.seconds = seconds;
            options.seed = seed;
            options.force = true;
            options.raw = use.raw;
            options.straight = use.straight;
            options.standard = true;
            options.name = trial.name;
            try {
              return interactor->run_on(trial.start, trial.scene, trial.chair, options).motion;
            } catch (const Error& e) {  // nobody could set out: no route, or none from there
              spdlog::warn("{}: {}", name, e.what());
              return waiting(trial.start, seconds);
            }
          }};
}

std::vector<InteractMethod> methods_of(const std::vector<std::pair<std::string, Networks>>& files, double seconds,
                                       const std::vector<Use>& uses) {
  std::vector<InteractMethod> out;
  std::set<Predictor> named;
  for (const auto& [file, networks] : files) {
    const size_t before = out.size();
    for (const Predictor predictor : kPredictors) {
      if (!holds(networks, predictor)) continue;
      const std::string name = title_of(predictor) + (named.insert(predictor).second ? "" : " (" + file + ")");
      const auto interactor = std::make_shared<const ChairInteractor>(networks, predictor);
      for (const Use& use : uses) out.push_back(model_method(name, interactor, seconds, use));
    }
    if (out.size() == before) throw Error(file, "holds nothing that moves people");
  }
  return out;
}

Table evaluate(const std::vector<Trial>& trials, const std::vector<InteractMethod>& methods, uint64_t seed,
               const Progress& progress, const MeasuredParts& parts) {
  const torch::NoGradGuard no_gradients;
  Table out;
  out.trials = static_cast<int64_t>(trials.size());
  for (const Trial& trial : trials)
    for (const auto& contact : trial.contacts) out.contacts += contact ? 1 : 0;
  int64_t mine = 0, done = 0, most_frames = 0;
  for (int64_t i = 0; i < out.trials; ++i) mine += parts.shard().has(i) ? 1 : 0;
  for (const Trial& trial : trials) most_frames = std::max(most_frames, trial.truth.frames());
  std::vector<Run> data;
  data.reserve(trials.size());
  for (const Trial& trial : trials) data.push_back(measured(trial, trial.truth, "data"));
  out.rows.push_back(scores_of("data", data));
  std::vector<std::vector<Run>> of_methods(methods.size());
  for (size_t m = 0; m < methods.size(); ++m) {
    std::vector<Run>& runs = of_methods[m];
    runs.resize(trials.size());
    for (size_t i = 0; i < trials.size(); ++i) {
      if (!parts.shard().has(static_cast<int64_t>(i))) continue;
      const Clip motion = methods[m].run(trials[i], item_seed(seed, i));
      most_frames = std::max(most_frames, motion.frames());
      runs[i] = measured(trials[i], motion, methods[m].name);
      if (progress) progress(++done, mine * static_cast<int64_t>(methods.size()));
    }
    if (!parts.shard().is_all()) continue;
    out.rows.push_back(scores_of(methods[m].name, runs));
    runs.clear();
  }
  if (parts.shard().is_all()) return out;
  if (!complete(parts, most_frames, of_methods)) {
    out.rows.clear();
    return out;
  }
  for (size_t m = 0; m < methods.size(); ++m) out.rows.push_back(scores_of(methods[m].name, of_methods[m]));
  return out;
}

ScoreTable score_table(const Table& table) {
  ScoreTable out;
  out.labels = {"method"};
  out.columns = {{"", "contact (cm)", "contact_error_cm", 2},
                 {"AP (%)", "3 cm", "ap/3cm", 1},
                 {"AP (%)", "5 cm", "ap/5cm", 1},
                 {"AP (%)", "7 cm", "ap/7cm", 1},
                 {"AP (%)", "9 cm", "ap/9cm", 1},
                 {"", "seated (%)", "seated_percent", 1},
                 {"", "after (s)", "seconds_to_sit", 1},
                 {"", "skating (%)", "skating_percent", 1},
                 {"", "jerk (m/s^3)", "jerk", 0},
                 {"", "depth (cm)", "penetration_cm", 1},
                 {"APD", "approach", "apd/approach", 2},
                 {"APD", "sit", "apd/sit", 2}};
  const auto times = [](const Estimate& e, double factor) { return Estimate{e.mean * factor, e.interval * factor}; };
  for (const Scores& s : table.rows) {
    ScoreTable::Row row{{s.method}, {times(s.contact_error, 100)}};
    for (const Estimate& p : s.precision) row.cells.push_back(times(p, 100));
    for (const Estimate& e :
         {times(s.success, 100), s.seconds_to_sit, Estimate{100 * s.skating, 0}, Estimate{s.jerk, 0},
          times(s.penetration, 100), Estimate{s.apd_approach, 0}, Estimate{s.apd_sit, 0}})
      row.cells.push_back(e);
    out.rows.push_back(row);
  }
  out.notes = {fmt::format("{} runs, {} contacts", table.trials, table.contacts)};
  return out;
}

std::string table_text(const Table& table) { return text_of(score_table(table), true); }

nlohmann::ordered_json table_json(const Table& table) {
  return {{"runs", table.trials}, {"contacts", table.contacts}, {"rows", rows_json(score_table(table), true)}};
}

}  // namespace inhabit::interact
