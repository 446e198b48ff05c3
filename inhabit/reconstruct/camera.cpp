#include "inhabit/reconstruct/camera.h"

#include <cmath>
#include <set>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/config_fields.h"
#include "inhabit/io/json_text.h"

namespace inhabit::reconstruct {
namespace {

using nlohmann::json;

constexpr int64_t kMostPixels = 16384;  // along a side
constexpr double kFarthest = 1e5;       // metres from the origin

double number_at(const json& value, const std::string& key, const std::string& subject) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) throw Error(subject, "'" + key + "' is no number");
  return value.get<double>();
}

double required(const json& file, const std::string& key, const std::string& subject, double low, double high) {
  if (!file.contains(key)) throw Error(subject, "'" + key + "' is missing");
  const double value = number_at(file[key], key, subject);
  if (!(value >= low && value <= high)) throw Error(subject, "'" + key + "' is out of range");
  return value;
}

/// A rigid motion from a matrix of 3 or 4 rows.
Eigen::Isometry3d pose_from(const json& rows, const std::string& key, const std::string& subject) {
  if (!rows.is_array() || (rows.size() != 3 && rows.size() != 4))
    throw Error(subject, "'" + key + "' wants to be 3 or 4 rows of 4 numbers");
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (size_t r = 0; r < rows.size(); ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4)
      throw Error(subject, "'" + key + "' wants to be 3 or 4 rows of 4 numbers");
    for (size_t c = 0; c < 4; ++c)
      m(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = number_at(rows[r][c], key, subject);
  }
  const Eigen::Matrix3d rotation = m.topLeftCorner<3, 3>();
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3) ||
      rotation.determinant() < 0)
    throw Error(subject, "'" + key + "' is no rotation and shift: its axes are not of length 1 and square");
  if (!((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6))
    throw Error(subject, "the last row of '" + key + "' is not 0 0 0 1");
  if (m.col(3).head<3>().cwiseAbs().maxCoeff() > kFarthest) throw Error(subject, "'" + key + "' is out of range");
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  out.translation() = m.col(3).head<3>();
  return out;
}

std::vector<Eigen::Isometry3d> poses_from(const json& value, const std::string& key, const std::string& subject) {
  std::vector<Eigen::Isometry3d> out;
  const bool many =
      value.is_array() && !value.empty() && value[0].is_array() && !value[0].empty() && value[0][0].is_array();
  if (!many) return {pose_from(value, key, subject)};
  out.reserve(value.size());
  for (const json& one : value) out.push_back(pose_from(one, key, subject));
  return out;
}

json matrix_json(const Eigen::Isometry3d& pose) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r)
    rows.push_back({pose.matrix()(r, 0), pose.matrix()(r, 1), pose.matrix()(r, 2), pose.matrix()(r, 3)});
  return rows;
}

}  // namespace

Camera parse_camera(std::string_view text, const std::string& subject) {
  const json file = parse_json(text, subject);
  if (!file.is_object()) throw Error(subject, "is no JSON object");
  refuse_unknown(file,
                 {"fx", "fy", "cx", "cy", "width", "height", "camera_to_world", "world_to_camera", "gravity", "motion"},
                 subject);
  Camera out;
  const auto side = [&](const char* key) {
    const double value = required(file, key, subject, 2, kMostPixels);
    if (value != std::floor(value)) throw Error(subject, std::string("'") + key + "' is no whole number");
    return static_cast<int64_t>(value);
  };
  out.width = side("width");
  out.height = side("height");
  out.fx = required(file, "fx", subject, 1, 1e6);
  out.fy = required(file, "fy", subject, 1, 1e6);
  out.cx = required(file, "cx", subject, -1e6, 1e6);
  out.cy = required(file, "cy", subject, -1e6, 1e6);
  const bool to_world = file.contains("camera_to_world"), to_camera = file.contains("world_to_camera");
  if (to_world && to_camera) throw Error(subject, "has both 'camera_to_world' and 'world_to_camera'");
  out.to_world = {Eigen::Isometry3d::Identity()};
  if (to_world) out.to_world = poses_from(file["camera_to_world"], "camera_to_world", subject);
  if (to_camera) {
    out.to_world = poses_from(file["world_to_camera"], "world_to_camera", subject);
    for (Eigen::Isometry3d& pose : out.to_world) pose = pose.inverse();
  }
  // Down is -Y in a world; in a level camera's axes, +Y.
  Eigen::Vector3d down(0, to_world || to_camera ? -1 : 1, 0);
  if (file.contains("gravity")) {
    const json& g = file["gravity"];
    if (!g.is_array() || g.size() != 3) throw Error(subject, "'gravity' wants to be 3 numbers");
    for (int i = 0; i < 3; ++i) down[i] = number_at(g[static_cast<size_t>(i)], "gravity", subject);
    if (!(down.norm() > 1e-6 && down.norm() < 1e6)) throw Error(subject, "'gravity' has no direction");
  }
  out.upright = Eigen::Quaterniond::FromTwoVectors(down, -Eigen::Vector3d::UnitY());
  for (Eigen::Isometry3d& pose : out.to_world) pose = out.upright * pose;
  if (file.contains("motion")) {
    if (file["motion"] != "world" && file["motion"] != "camera")
      throw Error(subject, "'motion' is neither \"world\" nor \"camera\"");
    out.motion_in_camera = file["motion"] == "camera";
  }
  return out;
}

Camera read_camera(const std::string& path) { return parse_camera(read_whole_file(path, uint64_t{1} << 28), path); }

std::string camera_json(const Camera& camera) {
  json out = {{"fx", camera.fx},
              {"fy", camera.fy},
              {"cx", camera.cx},
              {"cy", camera.cy},
              {"width", camera.width},
              {"height", camera.height},
              {"motion", camera.motion_in_camera ? "camera" : "world"}};
  const Eigen::Quaterniond back = camera.upright.inverse();
  const Eigen::Vector3d down = back * Eigen::Vector3d(-Eigen::Vector3d::UnitY());
  out["gravity"] = {down.x(), down.y(), down.z()};
  if (camera.moves()) {
    out["camera_to_world"] = json::array();
    for (const Eigen::Isometry3d& pose : camera.to_world) out["camera_to_world"].push_back(matrix_json(back * pose));
  } else {
    out["camera_to_world"] = matrix_json(back * camera.to_world[0]);
  }
  return out.dump(1) + "\n";
}

}  // namespace inhabit::reconstruct
