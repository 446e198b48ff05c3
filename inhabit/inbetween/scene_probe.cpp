#include "inhabit/inbetween/scene_probe.h"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/nn/parallel_chunks.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/occupancy.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {

using Eigen::Vector3f;
using torch::Tensor;

namespace {

constexpr float kGridCell = 0.1F, kHalfDiagonal = 0.0867F;  // metres, of the grid's cells
constexpr float kGridBottom = -0.3F, kGridTop = 2.3F;       // metres over the floor that the grid covers
constexpr float kMostMetres = 30;                           // metres that a corner's distance is cut off at
constexpr float kSeen = 0.8F;                               // metres from which on an obstacle is seen
constexpr float kMostInside = 0.8F;                         // metres that closeness grows inside
constexpr std::array<float, 3> kFanHeights = {0.25F, 0.8F, 1.4F}, kFanRadii = {0.35F, 0.7F, 1.2F};
constexpr int kFanDirections = 8;
static_assert(kFanFeatures == 3 * (1 + 3 * kFanDirections));
constexpr std::array<std::array<int, 2>, kBodyPoints - kStandardJoints> kLimbs = {
    {{1, 4}, {2, 5}, {4, 7}, {5, 8}, {16, 18}, {17, 19}, {18, 20}, {19, 21}}};

float closeness(float distance) { return std::max(0.0F, 1 - std::max(distance, -kMostInside) / kSeen); }

/// Around the obstacles, as far as they are seen and people are high.
Eigen::AlignedBox3f box_of(const Scene& obstacles, float floor) {
  Eigen::AlignedBox3f box;
  std::vector<Tensor> clouds = {obstacles.points};
  for (const Mesh& mesh : obstacles.meshes)
    if (mesh.faces.numel() > 0) clouds.push_back(mesh.vertices);
  for (const Tensor& points : clouds) {
    if (!points.defined() || points.size(0) == 0) continue;
    for (const Tensor& corner : {std::get<0>(points.min(0)), std::get<0>(points.max(0))})
      box.extend(Vector3f(corner[0].item<float>(), corner[1].item<float>(), corner[2].item<float>()));
  }
  if (box.isEmpty()) return box;
  box.min() -= Vector3f::Constant(kSeen);
  box.max() += Vector3f::Constant(kSeen);
  box.min().y() = std::max(box.min().y(), floor + kGridBottom);
  box.max().y() = std::min(box.max().y(), floor + kGridTop);
  return box;
}

}  // namespace

/// Distances at corners in millimetres, z fastest.
struct SceneDistances::Grid {
  Vector3f origin;
  std::array<int, 3> size{};
  std::vector<int16_t> corners;

  Grid(const Scene& obstacles, const Eigen::AlignedBox3f& box) : origin(box.min()) {
    double count = 1;
    for (int axis = 0; axis < 3; ++axis) {
      size[static_cast<size_t>(axis)] = std::max(2, static_cast<int>(std::ceil(box.sizes()[axis] / kGridCell)) + 1);
      count *= size[static_cast<size_t>(axis)];
    }
    if (count > (1 << 27)) throw Error("scene '" + obstacles.name + "'", "is too large for a grid of distances");
    const SceneQuery query(obstacles);
    const auto line = [&](int axis) {
      return origin[axis] + kGridCell * torch::arange(size[static_cast<size_t>(axis)], torch::kFloat32);
    };
    const Tensor places = torch::stack(torch::meshgrid({line(0), line(1), line(2)}, "ij"), 3).view({-1, 3});
    Tensor distance = query.closest(places).distances;
    // A free cell's middle is outside; an occupied one's inside, unless a surface goes through the cell.
    const Vector3f middle = origin + kGridCell / 2 * Vector3f(size[0] - 1, size[1] - 1, size[2] - 1).eval();
    const Tensor occupied =
        occupancy_grid(query.solid(), middle.cast<double>(), 0, {size, static_cast<double>(kGridCell)}).view({-1}) > 0;
    Tensor inside = occupied & (distance > kHalfDiagonal);
    const Tensor unsure = (occupied & (distance <= kHalfDiagonal)).nonzero().squeeze(1);
    inside.index_put_({unsure}, query.inside(places.index_select(0, unsure)));
    distance = torch::where(inside, -distance, distance).clamp(-kMostMetres, kMostMetres) * 1000;
    const Tensor rounded = distance.round().to(torch::kInt16).contiguous();
    corners.assign(rounded.data_ptr<int16_t>(), rounded.data_ptr<int16_t>() + rounded.numel());
  }
};

SceneDistances::SceneDistances(const Scene& scene, double floor, const Eigen::AlignedBox3f& around)
    : floor_(static_cast<float>(floor)) {
  const torch::NoGradGuard no_gradients;
  Scene obstacles = obstacles_of(scene);
  obstacles.points = scene.points;
  obstacles = without_ground(std::move(obstacles), floor);
  Eigen::AlignedBox3f box = box_of(obstacles, floor_);
  if (!around.isEmpty()) box = box.intersection(around.translated(Vector3f(0, floor_, 0)));
  if (!box.isEmpty()) grid_ = std::make_shared<Grid>(obstacles, box);
}

float SceneDistances::distance(const Vector3f& point, Vector3f* gradient) const {
  if (gradient != nullptr) gradient->setZero();
  if (!grid_) return kFar;
  const Vector3f at = (Vector3f(side_ * point.x(), point.y() + floor_, point.z()) - grid_->origin) / kGridCell;
  std::array<int, 3> low{};
  Vector3f u;
  for (size_t axis = 0; axis < 3; ++axis) {
    const float a = at[static_cast<Eigen::Index>(axis)];
    if (!(a >= 0 && a <= static_cast<float>(grid_->size[axis] - 1))) return kFar;
    low[axis] = std::min(static_cast<int>(a), grid_->size[axis] - 2);
    u[static_cast<Eigen::Index>(axis)] = a - static_cast<float>(low[axis]);
  }
  const auto corner = [&](int x, int y, int z) {
    const size_t row =
        static_cast<size_t>(low[0] + x) * static_cast<size_t>(grid_->size[1]) + static_cast<size_t>(low[1] + y);
    return static_cast<float>(
        grid_->corners[row * static_cast<size_t>(grid_->size[2]) + static_cast<size_t>(low[2] + z)]);
  };
  // Along z, then y, then x; values and what they change by across the cell.
  std::array<float, 2> value{}, by_y{}, by_z{};
  for (int x = 0; x < 2; ++x) {
    const float a = corner(x, 0, 0), b = corner(x, 0, 1), c = corner(x, 1, 0), d = corner(x, 1, 1);
    const float near = a + u.z() * (b - a), far = c + u.z() * (d - c);
    const auto i = static_cast<size_t>(x);
    value[i] = near + u.y() * (far - near);
    by_y[i] = far - near;
    by_z[i] = (b - a) + u.y() * ((d - c) - (b - a));
  }
  constexpr float kMetres = 1e-3F;
  if (gradient != nullptr)
    *gradient = kMetres / kGridCell *
                Vector3f(side_ * (value[1] - value[0]), by_y[0] + u.x() * (by_y[1] - by_y[0]),
                         by_z[0] + u.x() * (by_z[1] - by_z[0]));
  return kMetres * (value[0] + u.x() * (value[1] - value[0]));
}

SceneDistances SceneDistances::mirrored() const {
  SceneDistances out = *this;
  out.side_ = -side_;
  return out;
}

Tensor scene_fan(const SceneDistances& scene, const Baseline& baseline) {
  const int frames = baseline.poses.frames();
  Tensor out = torch::empty({frames, kFanFeatures});
  float* to = out.data_ptr<float>();
  for (int t = 0; t < frames; ++t) {
    const Vector3f& root = baseline.poses.root(t);
    const float heading = baseline.heading[static_cast<size_t>(t)];
    for (const float height : kFanHeights) {
      *to++ = closeness(scene.distance({root.x(), height, root.z()}));
      for (const float radius : kFanRadii)
        for (int i = 0; i < kFanDirections; ++i) {
          const float towards = heading + static_cast<float>(i) * static_cast<float>(2 * M_PI / kFanDirections);
          *to++ = closeness(
              scene.distance({root.x() + radius * std::sin(towards), height, root.z() + radius * std::cos(towards)}));
        }
    }
  }
  return out;
}

Tensor root_column(const Tensor& root) {
  std::vector<Tensor> points;
  for (const float height : kFanHeights) {
    const Tensor x = root.select(-1, 0);
    points.push_back(torch::stack({x, torch::full_like(x, height), root.select(-1, 2)}, -1));
  }
  return torch::stack(points, -2);
}

Tensor body_points(const Tensor& joints) {
  std::vector<int64_t> from, to;
  for (const auto& limb : kLimbs) {
    from.push_back(limb[0]);
    to.push_back(limb[1]);
  }
  const auto at = [&](const std::vector<int64_t>& which) {
    return joints.index_select(-2, torch::tensor(which, joints.device()));
  };
  return torch::cat({joints, (at(from) + at(to)) / 2}, -2);
}

Tensor body_point_radii() {
  static const Tensor radii = torch::tensor({0.11F, 0.09F, 0.09F, 0.12F, 0.06F, 0.06F, 0.12F, 0.04F, 0.04F,  0.12F,
                                             0.03F, 0.03F, 0.06F, 0.08F, 0.08F, 0.1F,  0.06F, 0.06F, 0.045F, 0.045F,
                                             0.04F, 0.04F, 0.08F, 0.08F, 0.05F, 0.05F, 0.05F, 0.05F, 0.04F,  0.04F});
  return radii;
}

const std::array<LimbEnd, kLimbEnds>& limb_ends() {
  // At rest hands point sideways, palms down, thumbs ahead. Around the skin of a hand 1 to 5 cm are kept free (3.6 in
  // the median): the grid of distances rounds edges off, and hands are what collides.
  static const std::array<LimbEnd, kLimbEnds> ends = {{{20, {0.085F, -0.01F, 0}, 0.07F},
                                                       {21, {-0.085F, -0.01F, 0}, 0.07F},
                                                       {20, {0.165F, -0.02F, 0}, 0.065F},
                                                       {21, {-0.165F, -0.02F, 0}, 0.065F},
                                                       {20, {0.09F, -0.02F, 0.06F}, 0.06F},
                                                       {21, {-0.09F, -0.02F, 0.06F}, 0.06F},
                                                       {10, {0, 0, 0.06F}, 0.02F},
                                                       {11, {0, 0, 0.06F}, 0.02F}}};
  return ends;
}

Tensor guarded_radii() {
  std::vector<float> ends;
  for (const LimbEnd& end : limb_ends()) ends.push_back(end.radius);
  return torch::cat({body_point_radii(), torch::tensor(ends)});
}

ProbedPoints probe(const SceneDistances& scene, const Tensor& points) {
  const Tensor plain = points.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  std::vector<int64_t> sizes = plain.sizes().vec();
  ProbedPoints out{torch::empty(std::vector<int64_t>(sizes.begin(), sizes.end() - 1)), torch::empty(sizes)};
  const float* p = plain.data_ptr<float>();
  float *d = out.distance.data_ptr<float>(), *g = out.gradient.data_ptr<float>();
  for (int64_t i = 0; i < plain.numel() / 3; ++i) {
    Vector3f gradient;
    d[i] = scene.distance({p[3 * i], p[3 * i + 1], p[3 * i + 2]}, &gradient);
    for (int axis = 0; axis < 3; ++axis) g[3 * i + axis] = gradient[axis];
  }
  return out;
}

ProbedPoints probe(const std::vector<SceneDistances>& scenes, const Tensor& points) {
  const Tensor plain = points.detach().to(torch::kCPU, torch::kFloat32);  // once, not scene by scene
  std::vector<Tensor> distances(scenes.size()), gradients(scenes.size());
  nn::parallel_chunks(static_cast<int64_t>(scenes.size()), [&](int64_t b) {
    const auto i = static_cast<size_t>(b);
    ProbedPoints one = probe(scenes[i], plain[b]);
    distances[i] = std::move(one.distance);
    gradients[i] = std::move(one.gradient);
  });
  return {torch::stack(distances).to(points.device()), torch::stack(gradients).to(points.device())};
}

Tensor point_features(const ProbedPoints& probed, const Tensor& rotation) {
  const Tensor close = (1 - probed.distance.clamp_min(-kMostInside) / kSeen).clamp_min(0).unsqueeze(3);  // (B, T, P, 1)
  const Tensor uphill = torch::matmul(probed.gradient, rotation) * close;  // rows g^T R = (R^T g)^T
  return torch::cat({close, uphill}, 3).flatten(2);
}

}  // namespace inhabit::inbetween
