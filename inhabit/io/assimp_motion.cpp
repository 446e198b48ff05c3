#include "inhabit/io/assimp_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "inhabit/error.h"
#include "inhabit/io/cbor_numbers.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/in_child.h"
#include "inhabit/io/node_tracks.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using nlohmann::json;

std::string tracks_in_child(const std::string& path, bool sampled) {
  return in_child(path, [&] {
    json out = json::array();
    for (const NodeTracks& t : node_tracks(path, sampled))
      out.push_back({{"names", t.names},
                     {"parents", t.parents},
                     {"rest", bytes_of(t.rest)},
                     {"joints", bytes_of(t.joints)},
                     {"rotations", bytes_of(t.rotations)},
                     {"rate", t.rate},
                     {"animation", t.animation},
                     {"alike", t.alike}});
    const std::vector<uint8_t> bytes = json::to_cbor(out);
    return std::string(bytes.begin(), bytes.end());
  });
}

std::vector<Quaterniond> quaternions_of(const std::vector<double>& numbers) {
  std::vector<Quaterniond> out;
  for (size_t k = 0; k + 3 < numbers.size(); k += 4)
    out.emplace_back(numbers[k + 3], numbers[k], numbers[k + 1], numbers[k + 2]);
  return out;
}

/// Where each joint comes from: as the file has them, or in the standard order where they are the standard ones, so
/// that what inhabit wrote is known again.
std::vector<size_t> order_of(const std::vector<std::string>& names) {
  const std::vector<std::string>& standard = standard_joint_names();
  std::vector<size_t> out(names.size());
  std::iota(out.begin(), out.end(), size_t{0});
  if (names.size() != standard.size()) return out;
  std::vector<size_t> known;
  for (const std::string& name : standard)
    if (const auto found = std::find(names.begin(), names.end(), name); found != names.end())
      known.push_back(static_cast<size_t>(found - names.begin()));
  return known.size() == names.size() ? known : out;
}

SourceMotion motion_of(const json& tracks, const std::string& path, std::optional<double> metres_per_unit,
                       bool metres) {
  SourceMotion out;
  Skeleton& skeleton = out.clip.skeleton;
  const auto names = tracks["names"].get<std::vector<std::string>>();
  const auto parents = tracks["parents"].get<std::vector<int>>();
  const std::vector<size_t> order = order_of(names);
  std::vector<int> place_of(names.size());
  for (size_t j = 0; j < order.size(); ++j) place_of[order[j]] = static_cast<int>(j);
  for (const size_t from : order) {
    skeleton.names.push_back(names[from]);
    skeleton.parents.push_back(parents[from] < 0 ? -1 : place_of[static_cast<size_t>(parents[from])]);
  }
  skeleton.offsets = torch::zeros({static_cast<int64_t>(names.size()), 3}, torch::kFloat64);
  skeleton.validate(path);
  out.clip.rate = tracks["rate"].get<double>();
  const std::vector<Quaterniond> rest = quaternions_of(numbers_of<double>(tracks["rest"])),
                                 rotations = quaternions_of(numbers_of<double>(tracks["rotations"]));
  const std::vector<double> joints = numbers_of<double>(tracks["joints"]);
  const size_t count = names.size(), frames = rotations.size() / count;

  // Rotations from rest; places relative to parents, in their frames.
  PoseTrack track;
  track.joints = static_cast<int>(count);
  track.local.resize(frames * count);
  std::vector<Vector3d> places(frames * count, Vector3d::Zero()), roots;
  for (size_t t = 0; t < frames; ++t)
    for (size_t j = 0; j < count; ++j) {
      const size_t at = t * count + j;
      const auto place = [&](size_t k) { return Eigen::Map<const Vector3d>(&joints[(t * count + order[k]) * 3]); };
      const auto rotation = [&](size_t k) {
        return Quaterniond(rotations[t * count + order[k]] * rest[order[k]].conjugate());
      };
      if (j == 0) {
        track.local[at] = rotation(0);
        roots.emplace_back(place(0));
        continue;
      }
      const auto p = static_cast<size_t>(skeleton.parents[j]);
      const Quaterniond above = rotation(p);
      track.local[at] = (above.conjugate() * rotation(j)).normalized();
      places[at] = above.conjugate() * (place(j) - place(p));
    }
  auto rows = skeleton.offsets.accessor<double, 2>();
  std::vector<double> values(frames);
  for (size_t j = 1; j < count; ++j)
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t t = 0; t < frames; ++t) values[t] = places[t * count + j][axis];
      rows[static_cast<int64_t>(j)][axis] = median(values);
    }
  if (metres_per_unit) {
    out.metres_per_unit = *metres_per_unit;
    out.unit = "units of the given scale";
  } else if (!metres) {
    const LengthUnit unit = guess_length_unit(longest_reach(skeleton, body_joint(skeleton)), path);
    out.metres_per_unit = unit.metres;
    out.unit = unit.name;
    out.notes.push_back("lengths taken for " + unit.name + " from the size of the person");
  }
  const double scale = out.metres_per_unit;
  skeleton.offsets = (skeleton.offsets * scale).to(torch::kFloat32);
  for (const Vector3d& root : roots) track.trans.push_back(root * scale);
  set_pose(out.clip, track);
  torch::Tensor translations = torch::empty({static_cast<int64_t>(frames), static_cast<int64_t>(count), 3});
  float* to = translations.data_ptr<float>();
  for (const Vector3d& place : places)
    for (int axis = 0; axis < 3; ++axis) *to++ = static_cast<float>(place[axis] * scale);
  set_translations(out.clip, translations);
  validate(out.clip, path);
  return out;
}

}  // namespace

std::vector<SourceMotion> read_node_motions(const std::string& path, std::optional<double> metres_per_unit) {
  const std::string extension = extension_of(path);
  const bool gltf = extension == "glb" || extension == "gltf";
  const json all = json::from_cbor(tracks_in_child(path, true));
  if (all.empty()) throw Error(path, "holds no skeleton of a person that an animation moves");
  std::vector<SourceMotion> out;
  for (const json& tracks : all) {
    out.push_back(motion_of(tracks, path, metres_per_unit, gltf));
    out.back().y_up = gltf;
  }
  if (const auto alike = all[0]["alike"].get<int64_t>(); alike > 0)
    out.front().notes.push_back(std::to_string(alike) + " more, whose joints have the same names, cannot be read");
  if (all.size() > 1)
    out.front().notes.push_back("one of " + std::to_string(all.size()) + " motions in the file, the animation '" +
                                all[0]["animation"].get<std::string>() + "'");
  return out;
}

bool holds_node_motion(const std::string& path) { return !json::from_cbor(tracks_in_child(path, false)).empty(); }

}  // namespace inhabit
