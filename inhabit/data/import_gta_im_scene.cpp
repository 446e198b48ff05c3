#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "inhabit/data/import_gta_im.h"
#include "inhabit/error.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/png_mask.h"

namespace inhabit {
namespace {

constexpr int64_t kEveryFrame = 10;
constexpr double kDeepestDepth = 10, kUsualFarClip = 800;  // metres
constexpr double kFarthest = 10'000;                       // metres from the world's origin, which voxels can count
constexpr double kFrameVoxel = 0.01, kCloudVoxel = 0.02;
constexpr size_t kManyPoints = 4'000'000;  ///< more than these are thinned before more are added

struct GtaPoint {
  double x = 0, y = 0, z = 0;
};

/// The mean of the points in each voxel.
std::vector<GtaPoint> thinned(const std::vector<GtaPoint>& points, double size) {
  std::vector<std::pair<uint64_t, size_t>> cells(points.size());
  const auto cell = [size](double v) {  // 21 bits are 20 km
    return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / size)) + (1 << 20)) & 0x1FFFFF;
  };
  for (size_t i = 0; i < points.size(); ++i)
    cells[i] = {cell(points[i].x) << 42 | cell(points[i].y) << 21 | cell(points[i].z), i};
  std::sort(cells.begin(), cells.end());
  std::vector<GtaPoint> out;
  for (size_t i = 0; i < cells.size();) {
    GtaPoint sum;
    size_t last = i;
    for (; last < cells.size() && cells[last].first == cells[i].first; ++last) {
      const GtaPoint& p = points[cells[last].second];
      sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
    }
    const auto n = static_cast<double>(last - i);
    out.push_back({sum.x / n, sum.y / n, sum.z / n});
    i = last;
  }
  return out;
}

/// What a recording's frames are seen with.
struct GtaCamera {
  torch::Tensor joints_2d, intrinsics, world_to_camera;  ///< (F, 21, 2), (F, 3, 3), (F, 4, 4) of row vectors

  explicit GtaCamera(const std::string& path) {
    const Npz npz = read_npz(path, {"joints_2d", "intrinsics", "world2cam_trans"});
    joints_2d = npz.at("joints_2d", path).to(torch::kFloat64);
    intrinsics = npz.at("intrinsics", path).to(torch::kFloat64);
    world_to_camera = npz.at("world2cam_trans", path).to(torch::kFloat64);
    const int64_t F = intrinsics.size(0);
    const bool good = joints_2d.dim() == 3 && joints_2d.size(0) == F && joints_2d.size(1) > 0 &&
                      joints_2d.size(2) == 2 && intrinsics.sizes() == torch::IntArrayRef({F, 3, 3}) &&
                      world_to_camera.sizes() == torch::IntArrayRef({F, 4, 4});
    if (!good) throw Error(path, "its joints_2d, intrinsics and world2cam_trans differ in their frames");
  }
};

double clip_plane(const Pickle& info, const PickleValue& frame, const char* name, double otherwise) {
  return frame.find(name) == nullptr && otherwise > 0 ? otherwise : info.number_at(frame, name);
}

/// Points of one frame in the game's world, +Z up.
void add_frame(const std::string& stem, const GtaCamera& camera, int64_t f, double near, double far,
               std::vector<GtaPoint>& cloud) {
  const torch::Tensor depth = read_png(stem + ".png"), ids = read_png(stem + "_id.png");
  if (depth.sizes() != ids.sizes()) throw Error(stem + "_id.png", "has another size than the depth");
  const int64_t H = depth.size(0), W = depth.size(1);
  const auto d = depth.accessor<uint8_t, 3>(), id = ids.accessor<uint8_t, 3>();
  const auto at_head = [&](int64_t axis, int64_t most) {
    const double v = camera.joints_2d[f][0][axis].item<double>();
    return std::isfinite(v) ? static_cast<int64_t>(std::clamp(v, 0.0, static_cast<double>(most - 1))) : 0;
  };
  const int64_t hx = at_head(0, W), hy = at_head(1, H);
  torch::Tensor person = torch::zeros({H, W}, torch::kUInt8);
  auto own = person.accessor<uint8_t, 2>();
  for (int64_t y = 0; y < H; ++y)
    for (int64_t x = 0; x < W; ++x) {
      if (id[y][x][0] != id[hy][hx][0] || id[y][x][1] != id[hy][hx][1] || id[y][x][2] != id[hy][hx][2]) continue;
      for (int64_t v = std::max<int64_t>(0, y - 1); v < std::min(H, y + 2); ++v)
        for (int64_t u = std::max<int64_t>(0, x - 1); u < std::min(W, x + 2); ++u) own[v][u] = 1;
    }
  const double focal = camera.intrinsics[f][0][0].item<double>();
  if (!(focal >= 1)) throw Error(stem + ".png", "its camera has no focal length");
  const torch::Tensor to_camera = camera.world_to_camera[f];
  if (!(torch::linalg_det(to_camera).abs().item<double>() > 1e-6))
    throw Error(stem + ".png", "its camera stands nowhere");
  const torch::Tensor to_world = torch::linalg_inv(to_camera).contiguous();
  if (!(to_world.abs().max().item<double>() < kFarthest)) throw Error(stem + ".png", "its camera stands nowhere");
  const auto m = to_world.accessor<double, 2>();
  std::vector<GtaPoint> points;
  for (int64_t y = 0; y < H; ++y)
    for (int64_t x = 0; x < W; ++x) {
      // Red is the highest byte of what the game's depth buffer held.
      const int64_t raw = d[y][x][2] + 256 * d[y][x][1] + 65536 * d[y][x][0];
      if (raw == 0 || own[y][x] != 0) continue;
      const double z = near * far / (near + 50.0 / static_cast<double>(raw) * (far - near));
      if (!(z > 0 && z <= kDeepestDepth)) continue;
      const double px = (static_cast<double>(x) - static_cast<double>(W) / 2) * z / focal,
                   py = (static_cast<double>(y) - static_cast<double>(H) / 2) * z / focal;
      const auto axis = [&](int64_t c) { return px * m[0][c] + py * m[1][c] + z * m[2][c] + m[3][c]; };
      points.push_back({axis(0), axis(1), axis(2)});
    }
  const std::vector<GtaPoint> fewer = thinned(points, kFrameVoxel);
  cloud.insert(cloud.end(), fewer.begin(), fewer.end());
  if (cloud.size() > kManyPoints) cloud = thinned(cloud, kFrameVoxel);
}

}  // namespace

Scene gta_im_scene(const std::string& recording, int64_t first, int64_t last) {
  const GtaCamera camera(recording + "/info_frames.npz");
  const Pickle info = read_pickle(recording + "/info_frames.pickle");
  const auto& frames = info.root->items;
  std::vector<GtaPoint> cloud;
  for (int64_t f = first; f < std::min(last, camera.intrinsics.size(0)); f += kEveryFrame) {
    char number[24];
    std::snprintf(number, sizeof number, "%05lld", static_cast<long long>(f));
    const std::string stem = recording + "/" + number;
    if (!std::filesystem::exists(stem + ".png")) continue;
    if (f >= static_cast<int64_t>(frames.size())) throw Error(info.subject, "has fewer frames than info_frames.npz");
    const PickleValue& frame = *frames[static_cast<size_t>(f)];
    add_frame(stem, camera, f, clip_plane(info, frame, "cam_near_clip", 0),
              clip_plane(info, frame, "cam_far_clip", kUsualFarClip), cloud);
  }
  cloud = thinned(cloud, kCloudVoxel);
  if (cloud.empty()) throw Error(recording, "has no depth image of frames " + std::to_string(first) + " and on");
  Scene scene;
  scene.points = torch::empty({static_cast<int64_t>(cloud.size()), 3});
  auto p = scene.points.accessor<float, 2>();
  for (size_t i = 0; i < cloud.size(); ++i) {
    const auto row = static_cast<int64_t>(i);
    p[row][0] = static_cast<float>(cloud[i].x);
    p[row][1] = static_cast<float>(cloud[i].z);
    p[row][2] = static_cast<float>(-cloud[i].y);
  }
  return scene;
}

}  // namespace inhabit
