#include "inhabit/inbetween/detour.h"

#include <spdlog/fmt/fmt.h>

#include <map>
#include <memory>
#include <mutex>
#include <numeric>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/bootstrap.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/nn/one_blas_thread.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr int64_t kDraws = 1000;  // of the bootstrap

bool succeeds(const Clip& clip, const FillTask& task, const CollisionMeter& meter, const DetourEvaluation& options) {
  if (meter.colliding_frames(clip, {options.tolerance, options.tolerance}).any().item<bool>()) return false;
  const Tensor keys = torch::tensor(task.keys);
  const Tensor missed = clip.joints.index_select(0, keys) - task.window.conditioning.joints.index_select(0, keys);
  return missed.norm(2, {2}).mean({1}).max().item<double>() <= options.key_error;
}

/// The mean of values of pairs of rooms.
Estimate over_pairs(const std::vector<double>& values, const Tensor& counts) {
  double sum = 0;
  for (const double value : values) sum += value;
  const Tensor all = torch::tensor(values, torch::kDouble);
  return {sum / static_cast<double>(values.size()),
          half_interval(resampled_ratios(all, torch::ones_like(all), counts))};
}

void require_pairs(const std::vector<BlockedRoom>& rooms) {
  if (rooms.empty() || rooms.size() % 2 != 0) throw Error("blocked rooms", "are not in pairs");
}

}  // namespace

std::vector<DetourScores> evaluate_detour(const std::vector<BlockedRoom>& rooms, const std::vector<Method>& methods,
                                          const DetourEvaluation& options) {
  require_pairs(rooms);
  if (options.seeds < 1) throw Error("seeds", "must be at least 1");
  const nn::OneBlasThread one_blas_thread;
  std::vector<DetourScores> out;
  int64_t all = 0, done = 0;
  for (const Method& method : methods) {
    out.push_back({method.name, method.random ? options.seeds : 1, std::vector<double>(rooms.size())});
    for (size_t r = 0; r < rooms.size(); ++r)
      all += options.parts.shard().has(static_cast<int64_t>(r)) ? out.back().runs : 0;
  }
  std::mutex mutex;
  const auto measure_room = [&](int64_t index) {
    const torch::NoGradGuard no_gradients;
    if (!options.parts.shard().has(index)) return;
    const auto r = static_cast<size_t>(index);
    const BlockedRoom& room = rooms[r];
    const CollisionMeter meter(builtin_body(), room.scene);
    const Window window{room.name, room.ends, room.ends, std::make_shared<const Scene>(room.scene)};
    const std::vector<int64_t> keys = {0, room.ends.frames() - 1};
    for (size_t m = 0; m < methods.size(); ++m)
      for (int64_t run = 0; run < out[m].runs; ++run) {
        const FillTask task{window, keys};
        const Clip clip = methods[m].run(task, item_seed(item_seed(options.seed, static_cast<uint64_t>(run)), r));
        validate(clip, methods[m].name + " in " + room.name);
        const bool good = succeeds(clip, task, meter, options);
        const std::lock_guard<std::mutex> lock(mutex);
        if (good) out[m].succeeded[r] += 1 / static_cast<double>(out[m].runs);
        ++done;
        if (options.progress) options.progress(done, all);
      }
  };
  const auto count = static_cast<int64_t>(rooms.size());
  if (options.parallel) {
    nn::parallel_chunks(count, measure_room);
  } else {
    for (int64_t r = 0; r < count; ++r) measure_room(r);
  }
  std::vector<Tensor> columns;
  columns.reserve(out.size());
  std::vector<int64_t> room(rooms.size());
  std::iota(room.begin(), room.end(), 0);
  for (const DetourScores& scores : out) columns.push_back(torch::tensor(scores.succeeded, torch::kDouble));
  std::map<std::string, Tensor> measured = {{"succeeded", columns.empty() ? Tensor() : torch::stack(columns, 1)}};
  if (columns.empty()) return out;
  if (!options.parts.complete(room, measured)) return {};
  for (size_t m = 0; m < out.size(); ++m)
    for (size_t r = 0; r < rooms.size(); ++r)
      out[m].succeeded[r] = measured["succeeded"][static_cast<int64_t>(r)][static_cast<int64_t>(m)].item<double>();
  return out;
}

ScoreTable score_table(const std::vector<DetourScores>& scores, const std::vector<BlockedRoom>& rooms,
                       const DetourEvaluation& options) {
  require_pairs(rooms);
  ScoreTable out;
  out.labels = {"method"};
  out.columns = {
      {"", "success", "success", 3}, {"", "rooms solved", "rooms_solved", 3}, {"", "both sides", "pairs_solved", 3}};
  for (const char* kind : kBlockedKinds)
    out.columns.push_back({"success by kind", kind, std::string("by_kind/") + kind, 2});
  const Tensor counts = bootstrap_counts(static_cast<int64_t>(rooms.size() / 2), kDraws, options.seed);
  for (const DetourScores& row : scores) {
    std::vector<double> success, solved, both;
    for (size_t r = 0; r + 1 < rooms.size(); r += 2) {
      const double a = row.succeeded[r], b = row.succeeded[r + 1];
      const bool first = DetourScores::solved(a), second = DetourScores::solved(b);
      success.push_back((a + b) / 2);
      solved.push_back((first ? 0.5 : 0) + (second ? 0.5 : 0));
      both.push_back(first && second ? 1 : 0);
    }
    out.rows.push_back(
        {{row.method}, {over_pairs(success, counts), over_pairs(solved, counts), over_pairs(both, counts)}});
    for (size_t kind = 0; kind < kBlockedKinds.size(); ++kind) {
      std::vector<double> of_kind;
      for (size_t r = 0; r < rooms.size(); ++r)
        if (rooms[r].kind == static_cast<int64_t>(kind)) of_kind.push_back(row.succeeded[r]);
      out.rows.back().cells.push_back({estimate(of_kind).mean, 0});
    }
  }
  out.notes = {
      fmt::format("{} rooms, half of them mirror images; success: no skin deeper than {:g} cm, keys within {:g} cm",
                  rooms.size(), options.tolerance * 100, options.key_error * 100),
      fmt::format("solved: at least 8 of 10 of {} seeds; both sides: a room and its mirror image; +- 95 % by "
                  "bootstrap over pairs",
                  options.seeds)};
  return out;
}

}  // namespace inhabit::inbetween
