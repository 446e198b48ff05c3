#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "outputs.h"
#include "verbs.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Score {
  std::vector<std::string> motion, reference, truth;
  std::string json, words = "local";
  int64_t observed = 0, kappa = 8;
  double rate = 25;
};

/// Joints (T, 22, 3) of the standard skeleton at the score's rate, of every motion in the files.
struct Motion {
  std::string path;
  Tensor joints;
};
std::vector<Motion> standard_motions(const std::vector<std::string>& paths, double rate) {
  std::vector<Motion> out;
  for (const std::string& path : paths)
    for (const Clip& clip : read_clips(path)) out.push_back({path, resample(retarget(clip, path), rate, path).joints});
  return out;
}

void report(const Score& given, nlohmann::ordered_json facts) {
  if (!given.json.empty()) write_atomically(given.json, facts.dump(1) + "\n");
  for (const auto& [key, value] : facts.items())
    if (!value.is_array()) std::printf("%s: %s\n", key.c_str(), value.dump().c_str());
}

/// The words that NDMS compares: of poses that know neither place nor heading, as `eval anticipate` has them, or of the
/// motion as it is, where each word is moved by its first frame.
Tensor words_of(const Tensor& joints, const Score& given) {
  return pose_words(given.words == "world" ? joints : local_poses(joints), given.kappa);
}

void score_ndms(const Score& given) {
  std::vector<Tensor> known;
  for (const Motion& motion : standard_motions(given.reference, given.rate))
    known.push_back(words_of(motion.joints, given));
  const Tensor reference = torch::cat(known);
  if (reference.size(0) == 0)
    throw Error(given.reference.front(), "holds no motion word of " + std::to_string(given.kappa) + " frames");
  const WordIndex database(reference);
  nlohmann::ordered_json by_file = nlohmann::ordered_json::array();
  double sum = 0;
  int64_t count = 0;
  for (const auto& [path, joints] : standard_motions(given.motion, given.rate)) {
    // The first word that holds a forecast frame begins kappa-1 frames before it.
    const int64_t first = std::max<int64_t>(0, given.observed - given.kappa + 1);
    const Tensor words = words_of(joints, given).slice(0, first);
    if (joints.size(0) <= given.observed || words.size(0) == 0)
      throw Error(path, "has " + std::to_string(joints.size(0)) + " frames at " +
                            std::to_string(static_cast<int>(given.rate)) + " a second: no motion word of " +
                            std::to_string(given.kappa) + " frames is left to score");
    const Tensor scores = plausibility(words, database);
    std::vector<double> seconds;
    const auto second = static_cast<int64_t>(std::lround(given.rate));
    for (int64_t at = 0; at < scores.size(0); at += second)
      seconds.push_back(scores.slice(0, at, at + second).mean().item<double>());
    by_file.push_back(
        {{"file", path}, {"ndms", scores.mean().item<double>()}, {"words", scores.size(0)}, {"by_second", seconds}});
    sum += scores.sum().item<double>();
    count += scores.size(0);
  }
  report(given, {{"ndms", sum / static_cast<double>(count)},
                 {"words", count},
                 {"reference_words", reference.size(0)},
                 {"files", by_file}});
}

/// Futures (S, T, 22, 3) as poses that know neither place nor heading, as long as the shortest.
Tensor local_futures(const std::vector<std::string>& paths, double rate, int64_t frames = -1) {
  std::vector<Tensor> all;
  for (const auto& [path, joints] : standard_motions(paths, rate)) {
    all.push_back(local_poses(joints));
    if (frames < 0 || joints.size(0) < frames) frames = joints.size(0);
  }
  for (Tensor& each : all) each = each.slice(0, 0, frames);
  return torch::stack(all);
}

void score_npss(const Score& given) {
  if (given.truth.size() != given.motion.size()) throw Error("--truth", "one file for each of --motion is needed");
  double sum = 0;
  for (size_t i = 0; i < given.motion.size(); ++i) {
    const Tensor truth = local_futures({given.truth[i]}, given.rate),
                 forecast = local_futures({given.motion[i]}, given.rate);
    const int64_t frames = std::min(truth.size(1), forecast.size(1));
    try {
      sum += npss(truth.slice(1, 0, frames).flatten(2), forecast.slice(1, 0, frames).flatten(2));
    } catch (const Error& e) {
      throw Error(given.motion[i], e.what());
    }
  }
  report(given, {{"npss", sum / static_cast<double>(given.motion.size())}, {"sequences", given.motion.size()}});
}

nlohmann::ordered_json at_seconds(const Tensor& by_frame, double rate, double scale) {
  nlohmann::ordered_json out;
  for (const double horizon : {0.4, 0.8, 1.6, 2.0, 4.0, 10.0, 20.0, 30.0}) {
    const auto frame = static_cast<int64_t>(std::lround(horizon * rate)) - 1;
    if (frame < by_frame.size(0))
      out.push_back({{"seconds", horizon}, {"value", by_frame[frame].item<double>() * scale}});
  }
  return out;
}

void score_apd(const Score& given) {
  const Tensor futures = local_futures(given.motion, given.rate);
  if (futures.size(0) < 2) throw Error("--motion", "APD needs two futures or more");
  const Tensor apd = average_pairwise_distance(futures.flatten(2));
  report(given, {{"apd_m", apd.mean().item<double>()},
                 {"futures", futures.size(0)},
                 {"by_horizon", at_seconds(apd, given.rate, 1)}});
}

void score_error(const Score& given) {
  if (given.truth.size() != 1) throw Error("--truth", "one file is needed, the future that came true");
  const Tensor truth = local_futures(given.truth, given.rate);
  if (truth.size(0) != 1)
    throw Error(given.truth.front(), "holds " + std::to_string(truth.size(0)) + " motions where one is wanted");
  const Tensor futures = local_futures(given.motion, given.rate, truth.size(1));
  const auto [error, best] = futures_error(futures, truth[0].slice(0, 0, futures.size(1)));
  report(given, {{"pose_error_mm", error.mean().item<double>() * 1000},
                 {"best_of_n_mm", best.mean().item<double>() * 1000},
                 {"futures", futures.size(0)},
                 {"by_horizon_mm", at_seconds(error.mean(0), given.rate, 1000)},
                 {"best_by_horizon_mm", at_seconds(best, given.rate, 1000)}});
}

}  // namespace

void add_score(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("score", "Measure any motion: NDMS, NPSS, APD, joint error");
  verb->require_subcommand(1);
  auto given = std::make_shared<Score>();
  const auto add = [&](const char* name, const char* what, void (*run)(const Score&)) {
    CLI::App* score = verb->add_subcommand(name, what);
    score->add_option("--motion", given->motion, "Motion files to score")->required();
    score->add_option("--rate", given->rate, "Frames a second to score at")->check(frame_rate)->capture_default_str();
    score->add_option("--json", given->json, "Also write the numbers as JSON");
    score->callback([given, run] {
      if (!given->json.empty()) require_writable(given->json);
      run(*given);
    });
    return score;
  };
  CLI::App* ndms =
      add("ndms", "Normalised directional motion similarity with real motion of the same kind", score_ndms);
  ndms->add_option("--reference", given->reference, "Real motion files that words are looked up in")->required();
  ndms->add_option("--observed", given->observed, "Frames (at --rate) at the start of each motion that were observed")
      ->check(CLI::Range(0, 1000000));
  ndms->add_option("--kappa", given->kappa, "Frames of a motion word")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  ndms->add_option(
          "--words", given->words,
          "Poses that know neither place nor heading (local), or the motion, each word moved by its first frame")
      ->check(CLI::IsMember({"local", "world"}))
      ->capture_default_str();
  add("npss", "Normalised power spectrum similarity with what came true", score_npss)
      ->add_option("--truth", given->truth, "What came true, a file for each motion")
      ->required();
  add("apd", "Average pairwise distance of several futures of one observation", score_apd);
  add("error", "Joint error of futures, their mean and the best of them", score_error)
      ->add_option("--truth", given->truth, "The future that came true")
      ->required();
}
