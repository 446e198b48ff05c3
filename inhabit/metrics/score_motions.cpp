#include "inhabit/metrics/score_motions.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/forecast_error.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"
#include "inhabit/motion/local_pose.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// World joints (S, T, 22, 3), as long as the shortest, or `frames` where that is fewer.
Tensor futures_of(const std::vector<NamedMotion>& motions, int64_t frames = -1) {
  std::vector<Tensor> all;
  for (const NamedMotion& motion : motions) {
    all.push_back(motion.joints);
    if (frames < 0 || motion.joints.size(0) < frames) frames = motion.joints.size(0);
  }
  for (Tensor& each : all) each = each.slice(0, 0, frames);
  return torch::stack(all);
}

/// The same as poses without place and heading.
Tensor local_futures(const std::vector<NamedMotion>& motions) { return local_poses(futures_of(motions)); }

ErrorByFrame by_frame(const FuturesError& error) {
  return {error.each.mean(0), error.best, error.each.mean().item<double>(), error.best.mean().item<double>()};
}

}  // namespace

NdmsScore score_ndms(const std::vector<NamedMotion>& motions, const std::vector<NamedMotion>& reference,
                     const NdmsOptions& options) {
  std::vector<Tensor> known;
  known.reserve(reference.size());
  for (const NamedMotion& motion : reference)
    known.push_back(database_words(motion.joints, options.kappa, options.reference_stride, options.words));
  const Tensor words_known = torch::cat(known);
  if (words_known.size(0) == 0)
    throw Error(reference.front().name, "holds no motion word of " + std::to_string(options.kappa) + " frames");
  const WordIndex database(words_known);
  NdmsScore out;
  out.reference_words = words_known.size(0);
  // The first word that holds a forecast frame begins kappa - 1 frames before it.
  const int64_t first = std::max<int64_t>(0, options.observed - options.kappa + 1);
  const auto second = static_cast<int64_t>(std::lround(options.rate));
  for (const auto& [name, joints] : motions) {
    const Tensor words = words_of(joints, options.kappa, options.words).slice(0, first);
    if (joints.size(0) <= options.observed || words.size(0) == 0)
      throw Error(name, "has " + std::to_string(joints.size(0)) + " frames at " + std::to_string(second) +
                            " a second: no motion word of " + std::to_string(options.kappa) +
                            " frames is left to score");
    const auto [scores, coded] = word_scores(words, database, options.words);
    NdmsOfMotion of{name, scores.mean().item<double>(), coded.mean().item<double>(), scores.size(0), {}};
    for (int64_t at = 0; at < scores.size(0); at += second)
      of.by_second.push_back(scores.slice(0, at, at + second).mean().item<double>());
    out.ndms += scores.sum().item<double>();
    out.coded += coded.sum().item<double>();
    out.words += of.words;
    out.motions.push_back(std::move(of));
  }
  out.ndms /= static_cast<double>(out.words);
  out.coded /= static_cast<double>(out.words);
  return out;
}

double score_npss(const std::vector<NamedMotion>& motions, const std::vector<NamedMotion>& truth) {
  if (truth.size() != motions.size()) throw Error("truth", "one motion for each is needed");
  std::vector<NamedMotion> all = motions;
  all.insert(all.end(), truth.begin(), truth.end());
  const Tensor poses = local_futures(all).flatten(2);
  const auto count = static_cast<int64_t>(motions.size());
  try {
    return npss(poses.slice(0, count), poses.slice(0, 0, count));
  } catch (const Error& e) {
    throw Error(motions.front().name, e.what());
  }
}

Tensor score_apd(const std::vector<NamedMotion>& futures) {
  if (futures.size() < 2) throw Error("APD", "needs two futures or more");
  return average_pairwise_distance(local_futures(futures).flatten(2));
}

double score_sequence_apd(const std::vector<NamedMotion>& futures) {
  return sequence_pairwise_distance(local_futures(futures).flatten(2));
}

MotionError score_error(const std::vector<NamedMotion>& futures, const std::vector<NamedMotion>& truth) {
  if (truth.size() != 1)
    throw Error(truth.empty() ? "truth" : truth.front().name,
                "holds " + std::to_string(truth.size()) + " motions where one is wanted");
  const Tensor all = futures_of(futures, truth.front().joints.size(0)),
               came = truth.front().joints.slice(0, 0, all.size(1));
  return {by_frame(futures_error(local_poses(all), local_poses(came))),
          by_frame(with_best(path_error(all, came.unsqueeze(0), 0))),
          by_frame(with_best((all - came).norm(2, -1).mean(-1)))};
}

}  // namespace inhabit
