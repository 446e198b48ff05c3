#include "inhabit/metrics/immersion.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "inhabit/metrics/collision.h"
#include "inhabit/motion/resample.h"
#include "inhabit/scene/objects.h"

namespace inhabit {
namespace {

constexpr float kFlesh = 0.3F;           ///< metres from a joint that skin can be
constexpr int64_t kFramesOfStretch = 8;  ///< that are looked at

Eigen::AlignedBox3f box_of(const torch::Tensor& points) {
  const torch::Tensor low = std::get<0>(points.reshape({-1, 3}).min(0)),
                      high = std::get<0>(points.reshape({-1, 3}).max(0));
  const auto corner = [](const torch::Tensor& t) {
    return Eigen::Vector3f(t[0].item<float>(), t[1].item<float>(), t[2].item<float>());
  };
  return {corner(low), corner(high)};
}

}  // namespace

std::string Immersion::text() const {
  return depth > 0 ? fmt::format("{:.0f} mm in {}", depth * 1000, object) : std::string();
}

std::vector<Immersion> immersions_of(const BodyModel& body, const Scene& scene, const Clip& clip,
                                     const std::vector<int64_t>& frames) {
  std::vector<Immersion> out;
  out.reserve(frames.size());
  for (const int64_t frame : frames) out.push_back({frame, 0, ""});
  if (frames.empty()) return out;
  const Clip poses = at_frames(clip, std::vector<double>(frames.begin(), frames.end()));
  Eigen::AlignedBox3f person = box_of(poses.joints);
  person.min().array() -= kFlesh;
  person.max().array() += kFlesh;
  std::map<std::string, Scene> objects;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name) && mesh.vertices.numel() > 0 && person.intersects(box_of(mesh.vertices)))
      objects[object_of_mesh(mesh.name)].meshes.push_back(mesh);
  for (const auto& [name, object] : objects) {
    const torch::Tensor depth = CollisionMeter(body, object).measure(poses).depth;
    for (size_t k = 0; k < out.size(); ++k) {
      const auto own = depth[static_cast<int64_t>(k)].item<double>();
      if (own <= out[k].depth) continue;
      out[k].depth = own;
      out[k].object = name;
    }
  }
  return out;
}

std::vector<Immersion> immersions_of_stretches(const BodyModel& body, const Scene& scene, const Clip& clip,
                                               const torch::Tensor& collides) {
  std::vector<int64_t> frames, stretch_of;
  const torch::Tensor flags = collides.to(torch::kBool).contiguous();
  const bool* inside = flags.data_ptr<bool>();
  int64_t stretches = 0;
  for (int64_t first = 0, last = 0; first < flags.numel(); first = last) {
    last = first + 1;
    if (!inside[first]) continue;
    while (last < flags.numel() && inside[last]) ++last;
    const int64_t count = std::min(kFramesOfStretch, last - first);
    for (int64_t k = 0; k < count; ++k) {
      frames.push_back(first + (2 * k + 1) * (last - first) / (2 * count));
      stretch_of.push_back(stretches);
    }
    ++stretches;
  }
  std::vector<Immersion> out(static_cast<size_t>(stretches));
  const std::vector<Immersion> found = immersions_of(body, scene, clip, frames);
  for (size_t k = 0; k < found.size(); ++k) {
    Immersion& deepest = out[static_cast<size_t>(stretch_of[k])];
    if (deepest.object.empty() || found[k].depth > deepest.depth) deepest = found[k];
  }
  return out;
}

}  // namespace inhabit
