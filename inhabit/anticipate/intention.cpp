#include "inhabit/anticipate/intention.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "inhabit/anticipate/released_labels.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

struct Run {
  int64_t cluster, first, last;
};

std::vector<Run> runs_of(const std::vector<int64_t>& clusters) {
  std::vector<Run> runs;
  for (size_t i = 0; i < clusters.size(); ++i) {
    const auto frame = static_cast<int64_t>(i);
    if (runs.empty() || runs.back().cluster != clusters[i])
      runs.push_back({clusters[i], frame, frame + 1});
    else
      runs.back().last = frame + 1;
  }
  return runs;
}

std::vector<int64_t> to_vector(const Tensor& ids) {
  const Tensor plain = ids.contiguous();
  return {plain.data_ptr<int64_t>(), plain.data_ptr<int64_t>() + plain.numel()};
}

}  // namespace

Tensor kmeans(const Tensor& points, int64_t k, uint64_t seed, int64_t iterations) {
  const torch::NoGradGuard no_gradients;
  const int64_t count = points.size(0);
  if (count < k) throw Error("clustering: " + std::to_string(count) + " poses for " + std::to_string(k) + " clusters");
  std::mt19937_64 random(seed);
  const auto distances = [&](const Tensor& centres) {  // (N, k) squared
    return (points.square().sum(1, true) - 2 * points.mm(centres.t()) + centres.square().sum(1)).clamp_min(0);
  };
  std::vector<Tensor> chosen = {points[static_cast<int64_t>(random() % static_cast<uint64_t>(count))]};
  Tensor nearest = distances(chosen[0].unsqueeze(0)).squeeze(1);
  while (static_cast<int64_t>(chosen.size()) < k) {
    const Tensor sums = nearest.to(torch::kFloat64).cumsum(0);
    const double at = uniform(random, 0, 1) * sums[count - 1].item<double>();
    const int64_t pick = std::min<int64_t>(count - 1, (sums <= at).sum().item<int64_t>());
    chosen.push_back(points[pick]);
    nearest = torch::minimum(nearest, distances(chosen.back().unsqueeze(0)).squeeze(1));
  }
  Tensor centres = torch::stack(chosen), members;
  for (int64_t i = 0; i < iterations; ++i) {
    const Tensor now = distances(centres).argmin(1);
    if (members.defined() && now.equal(members)) break;
    members = now;
    const Tensor counts = torch::bincount(members, {}, k).to(points.dtype()).unsqueeze(1);
    const Tensor sums = torch::zeros_like(centres).index_add(0, members, points);
    centres = torch::where(counts > 0, sums / counts.clamp_min(1), centres);  // a cluster left empty stays
  }
  const Tensor order = torch::bincount(distances(centres).argmin(1), {}, k).argsort(/*stable=*/true, 0, true);
  return centres.index_select(0, order);
}

Tensor nearest_centre(const Tensor& points, const Tensor& centres) {
  return (centres.square().sum(1) - 2 * points.mm(centres.t())).argmin(1);
}

std::vector<LabelSegment> find_cycles(const std::vector<int64_t>& clusters, const CycleOptions& options) {
  const std::vector<Run> runs = runs_of(clusters);
  const auto count = static_cast<int64_t>(runs.size());
  const auto run = [&](int64_t i) -> const Run& { return runs[static_cast<size_t>(i)]; };
  std::vector<LabelSegment> out;
  for (int64_t i = 0; i < count;) {
    LabelSegment best{run(i).first, run(i).last, 1};
    int64_t end = i + 1;
    for (int64_t period = 2; period <= options.longest && i + period * options.repeats <= count; ++period) {
      if (run(i + period).first - run(i).first > options.longest_frames) break;
      int64_t j = i + period;
      while (j < count && run(j).cluster == run(j - period).cluster) ++j;
      if (j - i < period * options.repeats) continue;
      if (run(j - 1).last <= best.last) continue;
      best = {run(i).first, run(j - 1).last, period};
      end = j;
    }
    out.push_back(best);
    i = end;
  }
  return out;
}

Tensor describe_segment(const Tensor& poses) { return torch::cat({poses.mean(0), 2 * poses.std(0, false)}); }

IntentionClusters cluster_intentions(const std::vector<Tensor>& sequences, int64_t labels, int64_t clusters, bool naive,
                                     uint64_t seed) {
  if (sequences.empty()) throw Error("clustering: no motion");
  IntentionClusters out;
  out.poses = kmeans(torch::cat(sequences), naive ? labels : clusters, seed);
  if (naive) return out;
  std::vector<Tensor> found;
  for (const Tensor& poses : sequences)
    for (const auto& [first, last, period] : find_cycles(to_vector(nearest_centre(poses, out.poses)), out.cycles))
      // A segment counts as often as it has frames.
      found.push_back(describe_segment(poses.slice(0, first, last)).expand({last - first, -1}));
  out.labels = kmeans(torch::cat(found), labels, seed + 1);
  return out;
}

Tensor intention_labels(const Tensor& poses, const IntentionClusters& clusters) {
  if (clusters.codes.defined()) return released_labels(poses, clusters);
  const Tensor frames = nearest_centre(poses, clusters.poses);
  if (!clusters.labels.defined()) return frames;
  Tensor out = torch::empty_like(frames);
  for (const auto& [first, last, period] : find_cycles(to_vector(frames), clusters.cycles)) {
    const Tensor segment = describe_segment(poses.slice(0, first, last)).unsqueeze(0);
    out.slice(0, first, last).fill_(nearest_centre(segment, clusters.labels).item<int64_t>());
  }
  return out;
}

}  // namespace inhabit::anticipate
