#include "inhabit/interact/evaluate_starts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/interact/seat_map.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/free_space.h"
#include "inhabit/scene/objects.h"

namespace inhabit::interact {
namespace {

constexpr double kLowered = 0.92, kThrough = 0.05;
constexpr double kResting = -0.05, kSeatWidth = 0.25;  // metres in the seat's axes: people sit down from there
constexpr double kClear = 0.25;                        // metres from furniture at the start
constexpr double kSeatedPelvis = 0.15;                 // metres over the seat's surface
constexpr int kDraws = 10'000;                         // of a start

/// Frames until the pelvis is lowered for the first time.
int64_t approach_end(const Clip& motion) {
  const torch::Tensor height = motion.joints.select(1, 0).select(1, 1).to(torch::kFloat64).contiguous();
  const double* h = height.data_ptr<double>();
  int64_t t = 0;
  while (t < motion.frames() && h[t] > kLowered * h[0]) ++t;
  return t;
}

/// Whether the pelvis is over the chair as seen from above anywhere but before the place where it comes to rest.
bool over_chair(const Clip& motion, const Chair& chair) {
  const TopView view = view_from_above(chair.mesh);
  const Eigen::Isometry3d own = chair.frame.inverse();
  const torch::Tensor root = motion.joints.select(1, 0).to(torch::kFloat64).contiguous();
  const auto at = root.accessor<double, 2>();
  for (int64_t t = 0; t < motion.frames(); ++t) {
    const Eigen::Vector3d place = own * Eigen::Vector3d(at[t][0], at[t][1], at[t][2]);
    if (place.z() > kResting && std::abs(place.x()) < kSeatWidth) continue;
    const Eigen::Vector2d cell = (Eigen::Vector2d(at[t][0], at[t][2]) - view.origin) / view.cell;
    const long x = std::lround(cell.x()), z = std::lround(cell.y());
    if (x >= 0 && z >= 0 && x < view.nx && z < view.nz &&
        view.height[view.at(static_cast<int>(x), static_cast<int>(z))] >= 0)
      return true;
  }
  return false;
}

/// A trial's person, stood 1 to 3 m from the chair at an angle of [from, to] from its front, on free floor.
Eigen::Vector2d place_start(const FreeSpace& floor, double from, double to, std::mt19937_64& random, Trial& trial) {
  Eigen::Vector2d place;
  int drawn = 0;
  do {
    if (++drawn > kDraws) throw Error(trial.name, "has no free floor around the chair to start from");
    place = on_ground(trial.chair.seat()) +
            uniform(random, 1, 3) * ahead_of(trial.chair.heading() + uniform(random, from, to));
  } while (floor.at(place) < kClear);
  trial.start = standing_clip(place, uniform(random, -M_PI, M_PI), trial.start.betas);
  return place;
}

}  // namespace

std::vector<Trial> behind_chairs(const std::vector<Trial>& trials, int64_t runs, uint64_t seed) {
  std::vector<Trial> out;
  for (int64_t i = 0; i < runs && !trials.empty(); ++i) {
    Trial trial = trials[static_cast<size_t>(i) % trials.size()];
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(i)));
    place_start(free_space(obstacles_of(trial.scene)), 2 * M_PI / 3, 4 * M_PI / 3, random, trial);
    out.push_back(std::move(trial));
  }
  return out;
}

std::vector<Trial> around_chair(const Scene& scene, const Chair& chair, int64_t runs, uint64_t seed) {
  const double ground = chair.frame.translation().y();
  const FreeSpace floor = free_space(obstacles_of(raised(scene, -ground)));
  std::vector<Trial> out;
  for (int64_t i = 0; i < runs; ++i) {
    Trial trial{chair.name, scene, chair, {}, {}, {}, kSeatedPelvis, scene.name};
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(i)));
    trial.chair = nearest_place(chair, place_start(floor, -M_PI, M_PI, random, trial));
    trial.start.joints = trial.start.joints + torch::tensor({0.F, static_cast<float>(ground), 0.F});
    trial.start.trans = trial.start.trans + torch::tensor({0.F, static_cast<float>(ground), 0.F});
    out.push_back(std::move(trial));
  }
  return out;
}

std::vector<StartSet> around_chairs(const Scene& scene, const std::string& path, int64_t runs, uint64_t seed) {
  std::vector<StartSet> out;
  for (const Chair& chair : find_chairs(scene)) out.push_back({chair.name, around_chair(scene, chair, runs, seed)});
  if (out.empty()) throw Error(path, "holds nothing to sit on");
  return out;
}

std::vector<StartScores> evaluate_starts(const std::vector<StartSet>& sets, const std::vector<InteractMethod>& methods,
                                         uint64_t seed, const Progress& progress, const MeasuredParts& parts) {
  const torch::NoGradGuard no_gradients;
  std::vector<StartScores> out;
  if (sets.empty()) return out;
  const auto count = static_cast<int64_t>(sets[0].starts.size()), each = static_cast<int64_t>(methods.size());
  std::vector<int64_t> all(sets[0].starts.size()), mine;
  std::iota(all.begin(), all.end(), 0);
  std::copy_if(all.begin(), all.end(), std::back_inserter(mine), [&](int64_t i) { return parts.shard().has(i); });
  // Of each start, set and method whether they sit, whether they went through the chair, and how deep.
  std::map<std::string, torch::Tensor> measured = {
      {"starts", torch::zeros({count, static_cast<int64_t>(sets.size()), each, 3}, torch::kDouble)}};
  auto of = measured["starts"].accessor<double, 4>();
  int64_t done = 0;
  for (size_t s = 0; s < sets.size(); ++s)
    for (int64_t m = 0; m < each; ++m)
      for (const int64_t i : mine) {
        const Trial& trial = sets[s].starts.at(static_cast<size_t>(i));
        const Clip motion = methods[static_cast<size_t>(m)].run(trial, item_seed(seed, static_cast<uint64_t>(i)));
        const Clip approach = slice(motion, 0, std::max<int64_t>(1, approach_end(motion)));
        const double depth = CollisionMeter(builtin_body(), trial.scene).measure(approach).penetration();
        auto row = of[i][static_cast<int64_t>(s)][m];
        row[0] = seated_from(motion, trial) ? 1 : 0;
        row[1] = depth > kThrough || over_chair(approach, trial.chair) ? 1 : 0;
        row[2] = depth;
        if (progress) progress(++done, each * static_cast<int64_t>(mine.size() * sets.size()));
      }
  if (!parts.complete(all, measured)) return out;
  for (size_t s = 0; s < sets.size(); ++s)
    for (int64_t m = 0; m < each; ++m) {
      std::vector<double> seated, through, around, depth;
      for (const int64_t i : all) {
        const auto row = of[i][static_cast<int64_t>(s)][m];
        seated.push_back(row[0]);
        through.push_back(row[1]);
        around.push_back(row[0] * (1 - row[1]));
        depth.push_back(row[2]);
      }
      out.push_back({sets[s].name, methods[static_cast<size_t>(m)].name, estimate(seated), estimate(through),
                     estimate(around), estimate(depth)});
    }
  return out;
}

ScoreTable score_table(const std::vector<StartScores>& rows) {
  ScoreTable out;
  out.labels = {"starts", "method"};
  out.columns = {{"", "seated (%)", "seated_percent", 1},
                 {"", "through (%)", "through_percent", 1},
                 {"", "around (%)", "around_percent", 1},
                 {"", "depth (cm)", "penetration_cm", 1}};
  for (const StartScores& s : rows) {
    ScoreTable::Row row{{s.starts, s.method}, {}};
    for (const Estimate& e : {s.seated, s.through, s.around, s.depth})
      row.cells.push_back({100 * e.mean, 100 * e.interval});
    out.rows.push_back(row);
  }
  return out;
}

}  // namespace inhabit::interact
