#include "inhabit/io/scene_file.h"

#include <fmt/format.h>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/mesh.h"
#include "inhabit/io/point_cloud.h"

namespace inhabit {
namespace {

constexpr double kLowestRoom = 2;                                                // metres
constexpr double kSmallestScene = 0.2, kHighestScene = 30, kLongestScene = 300;  // metres, of what a unit makes
constexpr double kMostSize = 1e5;  // metres; a scene this large is a mistake of units or a damaged file

bool is_mesh(const std::string& extension) {
  for (const char* known : {"obj", "ply", "glb", "gltf", "fbx", "dae", "off", "stl"}) {
    if (extension == known) return true;
  }
  return false;
}

bool is_cloud(const std::string& extension) {
  for (const char* known : {"pcd", "xyz", "pts", "npz", "npy"}) {
    if (extension == known) return true;
  }
  return false;
}

/// Up to `count` points of a scene's surfaces and cloud, evenly over area; (N, 3) double.
torch::Tensor survey(const Scene& scene, int64_t count) {
  torch::Tensor out;
  if (scene.points.defined()) {
    const int64_t step = std::max<int64_t>(1, scene.points.size(0) / count);
    return scene.points.slice(0, 0, scene.points.size(0), step).to(torch::kFloat64);
  }
  const Mesh mesh = merged_mesh(scene);
  const torch::Tensor corners =
      mesh.vertices.to(torch::kFloat64).index_select(0, mesh.faces.reshape({-1})).view({-1, 3, 3});
  const torch::Tensor a = corners.select(1, 0), u = corners.select(1, 1) - a, v = corners.select(1, 2) - a;
  const torch::Tensor total = torch::cumsum(torch::cross(u, v, 1).norm(2, 1), 0);
  const double sum = total[-1].item<double>();
  if (!(sum > 0)) return mesh.vertices.to(torch::kFloat64);
  // A fixed low-discrepancy sequence: the same file is always judged the same way.
  const torch::Tensor i = torch::arange(count, torch::kFloat64);
  const torch::Tensor face =
      torch::searchsorted(total, (i + 0.5) * (sum / static_cast<double>(count))).clamp(0, total.size(0) - 1);
  torch::Tensor r = torch::frac(i * 0.7548776662466927), s = torch::frac(i * 0.5698402909980532);
  const torch::Tensor outside = r + s > 1;
  r = torch::where(outside, 1 - r, r).unsqueeze(1);
  s = torch::where(outside, 1 - s, s).unsqueeze(1);
  return a.index_select(0, face) + u.index_select(0, face) * r + v.index_select(0, face) * s;
}

/// How much a scene looks as if `axis` points up. A room has a layer of points (the floor) over its whole ground plan
/// at the lower end, often nothing like it at the upper end, and many points in few layers.
double upness(const torch::Tensor& points, int axis) {
  constexpr int cells = 12, layers = 50;
  const auto ordered = [&](int a) { return std::get<0>(points.select(1, a).contiguous().sort()); };
  const auto n = points.size(0);
  std::array<double, 3> low{}, high{};
  for (int a = 0; a < 3; ++a) {
    const torch::Tensor sorted = ordered(a);
    low[static_cast<size_t>(a)] = sorted[n / 200].item<double>();
    high[static_cast<size_t>(a)] = sorted[n - 1 - n / 200].item<double>();
  }
  const auto accessor = points.accessor<double, 2>();
  const auto place = [&](int64_t i, int a, int bins) {
    const auto k = static_cast<size_t>(a);
    const double size = std::max(high[k] - low[k], 1e-9);
    return static_cast<int>(std::clamp((accessor[i][a] - low[k]) / size * bins, 0.0, bins - 1.0));
  };
  std::array<std::array<bool, cells * cells>, 2> covered{};
  std::array<double, layers> layer{};
  for (int64_t i = 0; i < n; ++i) {
    const int height = place(i, axis, layers);
    layer[static_cast<size_t>(height)] += 1.0 / static_cast<double>(n);
    const size_t cell = static_cast<size_t>(place(i, (axis + 1) % 3, cells)) * cells +
                        static_cast<size_t>(place(i, (axis + 2) % 3, cells));
    if (height < 3) covered[0][cell] = true;
    if (height >= layers - 3) covered[1][cell] = true;
  }
  const auto part = [](const auto& cover) {
    return std::count(cover.begin(), cover.end(), true) / (1.0 * cover.size());
  };
  double layered = 0;
  for (const double fraction : layer) layered += fraction * fraction;
  const double floor = part(covered[0]), ceiling = part(covered[1]);
  const auto size = [&](int a) { return high[static_cast<size_t>(a)] - low[static_cast<size_t>(a)]; };
  const double flat = size(axis) < 0.15 * std::max({size(0), size(1), size(2)}) ? 1 : 0;
  return floor + 0.5 * (floor - ceiling) + layered + flat;
}

/// Metres per unit of a scene that is so high and long in its units, nothing where no unit fits. Halls are 30 m high, a
/// scene in centimetres that is less than 30 units high is no room.
std::optional<double> likely_unit(double height, double largest) {
  struct Unit {
    double metres, highest, longest;
  };
  for (const Unit& unit : {Unit{1, kHighestScene, kLongestScene}, Unit{0.01, 8, 60}, Unit{0.001, 8, 60}})
    if (height * unit.metres <= unit.highest && largest * unit.metres <= unit.longest) return unit.metres;
  return {};
}

/// @param axes what the file says of itself
void to_metres_y_up(Scene& scene, const std::string& extension, const MeshAxes& axes, const SceneReadOptions& options,
                    SceneReport& report, const std::string& subject) {
  const bool defined = extension == "glb" || extension == "gltf";
  std::vector<torch::Tensor> all;
  for (const Mesh& mesh : scene.meshes) all.push_back(mesh.vertices);
  if (scene.points.defined()) all.push_back(scene.points);
  torch::Tensor lower, upper;
  for (const torch::Tensor& tensor : all) {
    const torch::Tensor low = std::get<0>(tensor.min(0)), high = std::get<0>(tensor.max(0));
    lower = lower.defined() ? torch::minimum(lower, low) : low;
    upper = upper.defined() ? torch::maximum(upper, high) : high;
  }
  const torch::Tensor size = (upper - lower).to(torch::kFloat64);
  const double along_y = size[1].item<double>(), along_z = size[2].item<double>(), largest = size.max().item<double>();
  report.up = 'y';
  if (options.up != UpAxis::automatic) {
    report.up = options.up == UpAxis::z ? 'z' : 'y';
  } else if (axes.up != 0) {
    report.up = axes.up;
  } else if (!defined) {
    const double unit = options.scale.value_or(likely_unit(std::min(along_y, along_z), largest).value_or(1));
    // The back rest of a lone chair is flat and at one end as well as a floor is.
    const bool furniture = std::max(along_y, along_z) * unit < kLowestRoom;
    report.up = extension == "obj" ? 'y' : 'z';
    if (!furniture) {
      const torch::Tensor points = survey(scene, 20000);
      const double y = upness(points, 1), z = upness(points, 2);
      report.up_detected = std::abs(y - z) > 0.15;
      if (report.up_detected) report.up = y > z ? 'y' : 'z';
    }
  }
  if (options.scale) {
    report.scale = *options.scale;
    if (!std::isfinite(report.scale) || report.scale <= 0) throw Error(subject, "the scale must be a number over 0");
  } else if (!defined) {
    const double height = report.up == 'z' ? along_z : along_y;
    // Programs that write centimetres into every .fbx are told by rooms for mice.
    const bool said = axes.metres > 0 && largest * axes.metres >= kSmallestScene &&
                      height * axes.metres <= kHighestScene && largest * axes.metres <= kLongestScene;
    const std::optional<double> unit = likely_unit(height, largest);
    report.scale = said ? axes.metres : unit.value_or(1);
    report.scale_detected = !said && unit.has_value();
  }
  if (largest * report.scale > kMostSize) {
    throw Error(subject,
                fmt::format("is {:.3g} km across; give the scale of its units", largest * report.scale / 1000));
  }
  for (torch::Tensor& tensor : all) {
    tensor.mul_(report.scale);
    if (report.up == 'z')
      tensor.copy_(torch::stack({tensor.select(1, 0), tensor.select(1, 2), -tensor.select(1, 1)}, 1));
  }
  for (int axis = 0; axis < 3; ++axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const torch::Tensor& tensor : all) {
      low = std::min(low, tensor.select(1, axis).min().item<double>());
      high = std::max(high, tensor.select(1, axis).max().item<double>());
    }
    report.lower[static_cast<size_t>(axis)] = static_cast<float>(low);
    report.upper[static_cast<size_t>(axis)] = static_cast<float>(high);
  }
}

SceneFile assemble(std::vector<Mesh> meshes, torch::Tensor points, const std::string& extension,
                   const std::string& subject, const SceneReadOptions& options, const MeshAxes& axes = {}) {
  SceneFile out;
  out.scene.name = std::filesystem::path(subject).stem().string();
  for (Mesh& mesh : meshes) {
    if (mesh.faces.size(0) == 0) {  // a .ply of points, points in a .glb
      points = points.defined() ? torch::cat({points, mesh.vertices}) : mesh.vertices;
      continue;
    }
    out.report.degenerate += drop_degenerate_faces(mesh);
    if (mesh.faces.size(0) > 0) out.scene.meshes.push_back(std::move(mesh));
  }
  out.scene.points = std::move(points);
  if (out.scene.empty()) throw Error(subject, "none of its faces has an area");
  to_metres_y_up(out.scene, extension, axes, options, out.report, subject);
  out.report.meshes = static_cast<int64_t>(out.scene.meshes.size());
  for (const Mesh& mesh : out.scene.meshes) {
    out.report.vertices += mesh.vertices.size(0);
    out.report.triangles += mesh.faces.size(0);
  }
  if (out.scene.points.defined()) out.report.points = out.scene.points.size(0);
  return out;
}

}  // namespace

SceneFile read_scene_file(const std::string& path, const SceneReadOptions& options) {
  const std::string extension = extension_of(path);
  if (is_cloud(extension)) return assemble({}, read_point_cloud(path), extension, path, options);
  MeshAxes axes;
  if (is_mesh(extension)) {
    std::vector<Mesh> meshes = read_meshes(path, &axes);
    return assemble(std::move(meshes), {}, extension, path, options, axes);
  }
  throw Error(path, "is no scene format inhabit knows (.obj .ply .glb .gltf .fbx .dae .off .stl .pcd .xyz .npz .npy)");
}

SceneFile parse_scene(std::string_view bytes, const std::string& extension, const std::string& subject,
                      const SceneReadOptions& options) {
  if (is_cloud(extension))
    return assemble({}, parse_point_cloud(bytes, extension, subject), extension, subject, options);
  MeshAxes axes;
  std::vector<Mesh> meshes = parse_meshes(bytes, extension, subject, &axes);
  return assemble(std::move(meshes), {}, extension, subject, options, axes);
}

bool is_scene_extension(const std::string& extension) { return is_mesh(extension) || is_cloud(extension); }

std::string describe(const SceneReport& report) {
  std::string what;
  if (report.meshes > 0) what = fmt::format("{} meshes, {} triangles", report.meshes, report.triangles);
  if (report.points > 0) what += fmt::format("{}{} points", what.empty() ? "" : ", ", report.points);
  if (report.degenerate > 0) what += fmt::format(" ({} without area left out)", report.degenerate);
  const auto size = [&](size_t axis) {
    return static_cast<double>(report.upper[axis]) - static_cast<double>(report.lower[axis]);
  };
  return fmt::format("{}, {:.2f} x {:.2f} x {:.2f} m; up axis {}{}, {} m per unit{}", what, size(0), size(1), size(2),
                     report.up, report.up_detected ? " (detected)" : "", report.scale,
                     report.scale_detected ? " (detected)" : "");
}

}  // namespace inhabit
