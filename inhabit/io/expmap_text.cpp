#include "inhabit/io/expmap_text.h"

#include <Eigen/Geometry>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/text_lines.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

struct JointRow {
  const char* name;
  int parent;
  double offset[3];
};

// Offsets in ASF units (the released loader multiplies them by 70).
constexpr JointRow kCmu[] = {
    {"Hips", -1, {0, 0, 0}},
    {"LHipJoint", 0, {0, 0, 0}},
    {"LeftUpLeg", 1, {1.65674, -1.80282, 0.62477}},
    {"LeftLeg", 2, {2.5972, -7.13576, 0}},
    {"LeftFoot", 3, {2.49236, -6.8477, 0}},
    {"LeftToeBase", 4, {0.19704, -0.54136, 2.14581}},
    {"LeftToeEnd", 5, {0, 0, 1.11249}},
    {"RHipJoint", 0, {0, 0, 0}},
    {"RightUpLeg", 7, {-1.6107, -1.80282, 0.62476}},
    {"RightLeg", 8, {-2.59502, -7.12977, 0}},
    {"RightFoot", 9, {-2.4678, -6.78024, 0}},
    {"RightToeBase", 10, {-0.23024, -0.63258, 2.13368}},
    {"RightToeEnd", 11, {0, 0, 1.11569}},
    {"LowerBack", 0, {0, 0, 0}},
    {"Spine", 13, {0.01961, 2.0545, -0.14112}},
    {"Spine1", 14, {0.01021, 2.06436, -0.05921}},
    {"Neck", 15, {0, 0, 0}},
    {"Neck1", 16, {0.00713, 1.56711, 0.14968}},
    {"Head", 17, {0.03429, 1.56041, -0.10006}},
    {"HeadEnd", 18, {0.01305, 1.6256, -0.05265}},
    {"LeftShoulder", 15, {0, 0, 0}},
    {"LeftArm", 20, {3.54205, 0.90436, -0.17364}},
    {"LeftForeArm", 21, {4.86513, 0, 0}},
    {"LeftHand", 22, {3.35554, 0, 0}},
    {"LeftFingerBase", 23, {0, 0, 0}},
    {"LeftHandIndex1", 24, {0.66117, 0, 0}},
    {"LeftHandIndexEnd", 25, {0.53306, 0, 0}},
    {"LThumb", 23, {0, 0, 0}},
    {"LThumbEnd", 27, {0.5412, 0, 0.5412}},
    {"RightShoulder", 15, {0, 0, 0}},
    {"RightArm", 29, {-3.49802, 0.75994, -0.32616}},
    {"RightForeArm", 30, {-5.02649, 0, 0}},
    {"RightHand", 31, {-3.36431, 0, 0}},
    {"RightFingerBase", 32, {0, 0, 0}},
    {"RightHandIndex1", 33, {-0.73041, 0, 0}},
    {"RightHandIndexEnd", 34, {-0.58887, 0, 0}},
    {"RThumb", 32, {0, 0, 0}},
    {"RThumbEnd", 36, {-0.59786, 0, 0.59786}},
};

// Offsets in millimetres.
constexpr JointRow kH36m[] = {
    {"Hips", -1, {0, 0, 0}},
    {"RightUpLeg", 0, {-132.948591, 0, 0}},
    {"RightLeg", 1, {0, -442.894612, 0}},
    {"RightFoot", 2, {0, -454.206447, 0}},
    {"RightToeBase", 3, {0, 0, 162.767078}},
    {"RightToeEnd", 4, {0, 0, 74.999437}},
    {"LeftUpLeg", 0, {132.948826, 0, 0}},
    {"LeftLeg", 6, {0, -442.894413, 0}},
    {"LeftFoot", 7, {0, -454.20659, 0}},
    {"LeftToeBase", 8, {0, 0, 162.767426}},
    {"LeftToeEnd", 9, {0, 0, 74.999948}},
    {"Spine", 0, {0, 0.1, 0}},
    {"Spine1", 11, {0, 233.383263, 0}},
    {"Neck", 12, {0, 257.077681, 0}},
    {"Head", 13, {0, 121.134938, 0}},
    {"HeadEnd", 14, {0, 115.002227, 0}},
    {"LeftShoulder", 12, {0, 257.077681, 0}},
    {"LeftArm", 16, {0, 151.034226, 0}},
    {"LeftForeArm", 17, {0, 278.882773, 0}},
    {"LeftHand", 18, {0, 251.733451, 0}},
    {"LeftHandThumb", 19, {0, 0, 0}},
    {"LeftHandThumbEnd", 20, {0, 0, 99.999627}},
    {"LeftHandTip", 19, {0, 100.000188, 0}},
    {"LeftHandTipEnd", 22, {0, 0, 0}},
    {"RightShoulder", 12, {0, 257.077681, 0}},
    {"RightArm", 24, {0, 151.031437, 0}},
    {"RightForeArm", 25, {0, 278.892924, 0}},
    {"RightHand", 26, {0, 251.72868, 0}},
    {"RightHandThumb", 27, {0, 0, 0}},
    {"RightHandThumbEnd", 28, {0, 0, 99.999888}},
    {"RightHandTip", 27, {0, 137.499922, 0}},
    {"RightHandTipEnd", 30, {0, 0, 0}},
};

constexpr double kAsfUnit = 0.0254 / 0.45;  // metres
constexpr double kCmuLoaderScale = 70;      // loader units per ASF unit

template <size_t N>
Skeleton skeleton_of(const JointRow (&rows)[N], double scale) {
  Skeleton out;
  out.offsets = torch::empty({static_cast<int64_t>(N), 3});
  auto offsets = out.offsets.accessor<float, 2>();
  for (size_t j = 0; j < N; ++j) {
    out.names.emplace_back(rows[j].name);
    out.parents.push_back(rows[j].parent);
    for (int k = 0; k < 3; ++k) offsets[static_cast<int64_t>(j)][k] = static_cast<float>(rows[j].offset[k] * scale);
  }
  return out;
}

int64_t columns(ExpmapSkeleton kind) { return kind == ExpmapSkeleton::cmu ? 117 : 99; }

// Numbers of one line, separated by commas with blanks around them, or by blanks alone.
size_t read_row(const TextLines& lines, std::string_view line, std::vector<float>& out) {
  const size_t before = out.size();
  const bool commas = line.find(',') != std::string_view::npos;
  while (!line.empty()) {
    std::string_view cell;
    if (commas) {
      const size_t end = line.find(',');
      cell = line.substr(0, end);
      line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
      const std::string_view word = next_word(cell);
      if (!next_word(cell).empty())
        lines.fail("two numbers stand between two commas (are commas used as decimal points?)");
      cell = word;
    } else {
      cell = next_word(line);
    }
    const auto value = static_cast<float>(lines.real(cell));
    if (!std::isfinite(value)) lines.fail(in_quotes(cell) + " is too large");
    out.push_back(value);
    if (out.size() - before > 1000) lines.fail("more than 1000 columns");
  }
  return out.size() - before;
}

std::string rows_expected(size_t found) {
  std::string reason = std::to_string(found) + " columns; exponential-map text has 117 (CMU) or 99 (Human3.6M)";
  if (found == 2 * 117 || found == 2 * 99) reason += " (are commas used as decimal points?)";
  return reason;
}

}  // namespace

const Skeleton& expmap_skeleton(ExpmapSkeleton kind) {
  static const Skeleton cmu = skeleton_of(kCmu, kAsfUnit), h36m = skeleton_of(kH36m, 0.001);
  return kind == ExpmapSkeleton::cmu ? cmu : h36m;
}

torch::Tensor expmap_joint_positions(ExpmapSkeleton kind, const torch::Tensor& channels) {
  if (channels.dim() < 1 || channels.size(-1) != columns(kind))
    throw Error("exponential maps", "the last dimension must be " + std::to_string(columns(kind)));
  const Skeleton& skeleton = expmap_skeleton(kind);
  std::vector<int64_t> shape = channels.sizes().vec();
  shape.back() = skeleton.size() - 1;
  shape.push_back(3);
  const torch::Tensor turned = -channels.slice(-1, 6).reshape(shape);
  const torch::Tensor root = torch::zeros_like(turned.slice(-2, 0, 1));
  const torch::Tensor rotations = axis_angle_to_matrix(torch::cat({root, turned}, -2));
  const double unit = kind == ExpmapSkeleton::cmu ? kCmuLoaderScale / kAsfUnit : 1000.0;
  const torch::Tensor offsets = (skeleton.offsets.to(torch::kDouble) * unit).to(channels.options());
  return forward_kinematics(skeleton.parents, offsets, rotations, root.select(-2, 0)).positions;
}

torch::Tensor parse_expmap_channels(std::string_view text, const std::string& name) {
  TextLines lines(text, name);
  std::vector<float> values;
  size_t width = 0;
  for (std::string_view line; lines.next_filled(line);) {
    const size_t found = read_row(lines, line, values);
    if (width == 0) {
      if (found != 117 && found != 99) lines.fail(rows_expected(found));
      width = found;
      values.reserve(values.size() + text.size() / line.size() * width);
    }
    if (found != width) lines.fail(std::to_string(found) + " columns, the first line has " + std::to_string(width));
  }
  if (width == 0) throw Error(name, "holds no frames");
  return torch::from_blob(values.data(), {static_cast<int64_t>(values.size() / width), static_cast<int64_t>(width)})
      .clone();
}

torch::Tensor read_expmap_channels(const std::string& path) {
  return parse_expmap_channels(read_whole_file(path), path);
}

SourceMotion expmap_motion(const torch::Tensor& channels, const std::string& name) {
  if (channels.dim() != 2 || channels.size(0) == 0 || (channels.size(1) != 117 && channels.size(1) != 99))
    throw Error(name, "exponential maps must be (T, 117) or (T, 99) with at least one frame");
  const bool cmu = channels.size(1) == 117;
  SourceMotion out;
  out.clip.skeleton = expmap_skeleton(cmu ? ExpmapSkeleton::cmu : ExpmapSkeleton::h36m);
  out.clip.rate = cmu ? 120 : 50;
  out.metres_per_unit = cmu ? kAsfUnit : 0.001;
  out.unit = cmu ? "ASF units" : "millimetres";

  torch::Tensor rows = channels.to(torch::kCPU, torch::kDouble).contiguous();
  if (cmu && rows.size(0) > 1) {
    // The rest pose rotates hips, neck and upper arms by fixed amounts, but neither root, knees nor elbows.
    const auto straight = [&](int64_t row) {
      double turned = 0;
      for (const int64_t joint : {0, 3, 9, 14, 22, 31})
        turned = std::max(turned, rows[row].slice(0, 3 + 3 * joint, 6 + 3 * joint).abs().max().item<double>());
      return turned < 1e-6;
    };
    if (straight(0) && !straight(1)) {
      rows = rows.slice(0, 1).contiguous();
      out.notes.emplace_back("the first row is the rest pose and was left out");
    }
  }
  // No person moves 0.15 m in a fiftieth of a second: such Human3.6M files hold the root's place, not its steps.
  const bool absolute = cmu || rows.slice(1, 0, 3).norm(2, 1).median().item<double>() > 150;
  if (!cmu && absolute) out.notes.emplace_back("the root's columns were read as places, not as steps");
  out.slopes = !absolute;
  const double* value = rows.data_ptr<double>();
  PoseTrack track;
  track.joints = out.clip.skeleton.size();
  Eigen::Quaterniond root = Eigen::Quaterniond::Identity();
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int64_t t = 0; t < rows.size(0); ++t, value += rows.size(1)) {
    const Eigen::Vector3d move = Eigen::Map<const Eigen::Vector3d>(value) * out.metres_per_unit;
    for (int j = 0; j < track.joints; ++j)
      track.local.push_back(quaternion_of(-Eigen::Map<const Eigen::Vector3d>(value + 3 + 3 * j)));
    Eigen::Quaterniond& first = track.local[track.local.size() - static_cast<size_t>(track.joints)];
    place = absolute ? move : Eigen::Vector3d(place + root * move);
    root = absolute ? first : (root * first).normalized();
    first = root;
    track.trans.push_back(place);
  }
  set_pose(out.clip, track);
  validate(out.clip, name);
  return out;
}

SourceMotion read_expmap_text(const std::string& path) { return expmap_motion(read_expmap_channels(path), path); }

}  // namespace inhabit
