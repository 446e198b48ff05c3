#include "inhabit/reconstruct/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "inhabit/math/random.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/synth/person.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

/// Mean over the frames that both have.
double mean_apart(const Tensor& a, const Tensor& b) {
  const int64_t n = std::min(a.size(0), b.size(0));
  return (a.slice(0, 0, n) - b.slice(0, 0, n)).norm(2, {-1}).mean().item<double>();
}

Vector3d middle_of(const std::vector<Mesh>& meshes) {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (const Mesh& mesh : meshes) {
    const auto v = mesh.vertices.accessor<float, 2>();
    for (int64_t i = 0; i < v.size(0); ++i) {
      const Vector3d p(v[i][0], v[i][1], v[i][2]);
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  }
  return 0.5 * (low + high);
}

/// The least rotation, of 90 and 180 degrees, after which an object looks the same; 360 where none does.
double symmetry_of(const std::vector<Mesh>& meshes) {
  Scene scene;
  scene.meshes = meshes;
  std::mt19937_64 random(1);
  const Tensor points = sample_points(scene, 400, random);
  const auto p = points.accessor<float, 2>();
  const Vector3d middle = middle_of(meshes);
  const SceneQuery query(scene);
  const double size = (points - points.mean(0)).norm(2, {1}).max().item<double>();
  for (const double degrees : {90.0, 180.0}) {
    std::vector<Vector3d> rotated;
    for (int64_t i = 0; i < points.size(0); ++i)
      rotated.emplace_back(middle + Eigen::AngleAxisd(degrees * M_PI / 180, Vector3d::UnitY()) *
                                        (Vector3d(p[i][0], p[i][1], p[i][2]) - middle));
    if (query.closest(point_rows(rotated)).distances.mean().item<double>() < 0.01 * size) return degrees;
  }
  return 360;
}

Errors::Object object_errors(const PlacedObject& placed, const TrueObject& truth, const std::vector<Mesh>& own) {
  Errors::Object out;
  out.name = placed.name;
  const Vector3d middle = middle_of(own);
  out.place = (placed.placement.place(middle) - truth.placement.place(middle)).norm();
  const double apart = (placed.placement.yaw - truth.placement.yaw) * 180 / M_PI;
  out.yaw = std::abs(std::remainder(apart, symmetry_of(own)));
  out.scale = placed.placement.scale / truth.placement.scale - 1;
  return out;
}

}  // namespace

Errors errors_of(const Rendered& rendered, const Result& result) {
  Errors out;
  out.scale = result.depth.scale.scale / rendered.errors.scale - 1;
  const Eigen::Isometry3d to_camera = rendered.inputs.camera.to_world[0].inverse();
  const Tensor path = rendered.truth.root_path();
  for (int64_t t = 0; t < path.size(0); ++t) {
    const double z =
        (to_camera * Vector3d(path[t][0].item<double>(), path[t][1].item<double>(), path[t][2].item<double>())).z();
    const double raw = (z - rendered.errors.offset) / rendered.errors.scale;
    out.depth +=
        std::abs(result.depth.scale.scale * raw + result.depth.scale.offset - z) / static_cast<double>(path.size(0));
  }
  out.root_before = mean_apart(result.before.root_path(), path);
  const Tensor keys = torch::tensor(result.moved_keys);
  out.root_keys = mean_apart(result.keys_moved.root_path().index_select(0, keys), path.index_select(0, keys));
  out.root_after = mean_apart(result.motion.root_path(), path);
  out.joints_before = mean_apart(result.before.joints, rendered.truth.joints);
  out.joints_after = mean_apart(result.motion.joints, rendered.truth.joints);
  out.skating_before = foot_skating(result.before).fraction();
  out.skating_after = foot_skating(result.motion).fraction();
  out.jerk_before = dynamics(result.before).jerk;
  out.jerk_after = dynamics(result.motion).jerk;
  out.jerk_true = dynamics(rendered.truth).jerk;
  for (size_t i = 0; i < result.objects.size(); ++i)
    out.objects.push_back(object_errors(result.objects[i], rendered.objects[i], rendered.inputs.objects[i].meshes));
  return out;
}

Rendered rendered_room(const Evaluation& evaluation, int64_t index) {
  std::mt19937_64 room_random(item_seed(evaluation.seed, 2 * static_cast<uint64_t>(index)));
  std::mt19937_64 random(item_seed(evaluation.seed, 2 * static_cast<uint64_t>(index) + 1));
  const Room room = make_room(room_random);
  LifeOptions life;
  life.seconds = evaluation.seconds;
  Rendered out = render_life(room, live(room, builtin_body(), random, life), evaluation.render,
                             item_seed(evaluation.seed, 1000 + static_cast<uint64_t>(index)));
  if (!evaluation.objects) out.inputs.objects.clear(), out.objects.clear();
  return out;
}

namespace {

constexpr std::array kNumbers = {&Errors::scale,        &Errors::depth,          &Errors::root_before,
                                 &Errors::root_keys,    &Errors::root_after,     &Errors::joints_before,
                                 &Errors::joints_after, &Errors::skating_before, &Errors::skating_after,
                                 &Errors::jerk_before,  &Errors::jerk_after,     &Errors::jerk_true};
constexpr int64_t kMostObjects = 64, kLongestName = 64;

/// With the rooms that other parts measured; false where some are still to come.
bool complete(const MeasuredParts& parts, std::vector<Errors>& rooms) {
  if (parts.shard().is_all()) return true;
  const auto count = static_cast<int64_t>(rooms.size());
  std::map<std::string, torch::Tensor> all = {
      {"numbers", torch::zeros({count, static_cast<int64_t>(kNumbers.size())}, torch::kDouble)},
      {"objects", torch::full({count, kMostObjects, 3}, std::nan(""), torch::kDouble)},
      {"names", torch::zeros({count, kMostObjects, kLongestName}, torch::kUInt8)}};
  std::vector<int64_t> room(rooms.size());
  std::iota(room.begin(), room.end(), 0);
  for (const int64_t i : room) {
    const Errors& of = rooms[static_cast<size_t>(i)];
    for (size_t k = 0; k < kNumbers.size(); ++k) all["numbers"][i][static_cast<int64_t>(k)] = of.*kNumbers[k];
    for (size_t k = 0; k < of.objects.size() && static_cast<int64_t>(k) < kMostObjects; ++k) {
      const auto row = static_cast<int64_t>(k);
      const Errors::Object& object = of.objects[k];
      all["objects"][i][row].copy_(torch::tensor({object.place, object.yaw, object.scale}, torch::kDouble));
      std::copy_n(object.name.begin(), std::min<size_t>(object.name.size(), kLongestName - 1),
                  all["names"][i][row].data_ptr<uint8_t>());
    }
  }
  if (!parts.complete(room, all)) return false;
  for (const int64_t i : room) {
    Errors& of = rooms[static_cast<size_t>(i)];
    for (size_t k = 0; k < kNumbers.size(); ++k)
      of.*kNumbers[k] = all["numbers"][i][static_cast<int64_t>(k)].item<double>();
    of.objects.clear();
    for (int64_t row = 0; row < kMostObjects; ++row) {
      const double* object = all["objects"][i][row].data_ptr<double>();
      if (std::isnan(object[0])) break;
      const std::string name(reinterpret_cast<const char*>(all["names"][i][row].data_ptr<uint8_t>()));
      of.objects.push_back({name, object[0], object[1], object[2]});
    }
  }
  return true;
}

}  // namespace

std::vector<Errors> evaluate(const inbetween::SceneInbetweener& inbetweener, const Evaluation& evaluation) {
  std::vector<Errors> out(static_cast<size_t>(evaluation.rooms));
  int64_t done = 0, mine = 0;
  for (int64_t i = 0; i < evaluation.rooms; ++i) mine += evaluation.parts.shard().has(i) ? 1 : 0;
  for (int64_t i = 0; i < evaluation.rooms; ++i) {
    if (!evaluation.parts.shard().has(i)) continue;
    const Rendered rendered = rendered_room(evaluation, i);
    if (i == 0 && !evaluation.keep.empty()) write_rendered(rendered, evaluation.keep);
    out[static_cast<size_t>(i)] = errors_of(rendered, run(rendered.inputs, inbetweener, evaluation.options));
    if (evaluation.progress) evaluation.progress(++done, mine);
  }
  if (!complete(evaluation.parts, out)) out.clear();
  return out;
}

ScoreTable table_of(const std::vector<Errors>& rooms) {
  ScoreTable out;
  out.labels = {"room"};
  out.columns = {{"depth", "scale (%)", "depth_scale/error_percent", 2},
                 {"depth", "at person (mm)", "depth_scale/at_person_mm", 1},
                 {"root (mm)", "estimate", "root_mm/estimate", 1},
                 {"root (mm)", "keys moved", "root_mm/keys_moved", 1},
                 {"root (mm)", "result", "root_mm/result", 1},
                 {"joints (mm)", "estimate", "joints_mm/estimate", 1},
                 {"joints (mm)", "result", "joints_mm/result", 1},
                 {"skating", "estimate", "skating/estimate", 3},
                 {"skating", "result", "skating/result", 3},
                 {"jerk (m/s3)", "estimate", "jerk/estimate", 1},
                 {"jerk (m/s3)", "result", "jerk/result", 1},
                 {"jerk (m/s3)", "truth", "jerk/truth", 1}};
  std::vector<std::vector<double>> columns(out.columns.size());
  std::vector<Errors::Object> objects;
  for (size_t i = 0; i < rooms.size(); ++i) {
    const Errors& e = rooms[i];
    const std::vector<double> row = {100 * std::abs(e.scale), 1e3 * e.depth,      1e3 * e.root_before,
                                     1e3 * e.root_keys,       1e3 * e.root_after, 1e3 * e.joints_before,
                                     1e3 * e.joints_after,    e.skating_before,   e.skating_after,
                                     e.jerk_before,           e.jerk_after,       e.jerk_true};
    out.rows.push_back({{std::to_string(i)}, {}});
    for (size_t c = 0; c < row.size(); ++c) {
      out.rows.back().cells.push_back({row[c], 0});
      columns[c].push_back(row[c]);
    }
    objects.insert(objects.end(), e.objects.begin(), e.objects.end());
  }
  out.rows.push_back({{"mean"}, {}});
  for (const std::vector<double>& column : columns) out.rows.back().cells.push_back(estimate(column));
  int64_t good = 0;
  for (const Errors::Object& o : objects) {
    char line[160];
    std::snprintf(line, sizeof line, "%s: %.1f mm, %.2f degrees, scale %+.2f %%", o.name.c_str(), 1e3 * o.place, o.yaw,
                  100 * o.scale);
    out.notes.emplace_back(line);
    good += o.place < 0.05 && o.yaw < 3 ? 1 : 0;
  }
  if (!objects.empty())
    out.notes.push_back(std::to_string(good) + " of " + std::to_string(objects.size()) +
                        " objects within 5 cm and 3 degrees");
  return out;
}

}  // namespace inhabit::reconstruct
