// Protects motion of .fbx files of MotionBuilder, Maya and Unity: joints are where the format's own equation has them,
// parent * Pre * Rotation * Post^-1, and where their makers mean it otherwise than assimp.
#include "inhabit/io/fbx_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <variant>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr int64_t kSecond = 46186158000;

/// A node of an .fbx file, as text and as bytes.
struct Fbx {
  using Property = std::variant<int32_t, int64_t, double, std::string, std::vector<int64_t>, std::vector<float>>;
  std::string name;
  std::vector<Property> properties;
  std::vector<Fbx> children;

  std::string text(const std::string& indent = "") const {
    std::string out = indent + name + ": ";
    for (size_t k = 0; k < properties.size(); ++k) {
      const Property& p = properties[k];
      out += k > 0 ? "," : "";
      if (const auto* s = std::get_if<std::string>(&p)) {
        const size_t cut = s->find('\0');  // "Hips\0\1Model" is "Model::Hips"
        out += "\"" + (cut == std::string::npos ? *s : s->substr(cut + 2) + "::" + s->substr(0, cut)) + "\"";
      } else if (const auto* whole = std::get_if<int64_t>(&p)) {
        out += std::to_string(*whole);
      } else if (const auto* small = std::get_if<int32_t>(&p)) {
        out += std::to_string(*small);
      } else if (const auto* real = std::get_if<double>(&p)) {
        out += std::to_string(*real);
      } else {
        std::string numbers;
        size_t count = 0;
        const auto list = [&](const auto& values) {
          count = values.size();
          for (const auto& value : values) numbers += (numbers.empty() ? "" : ",") + std::to_string(value);
        };
        if (const auto* times = std::get_if<std::vector<int64_t>>(&p)) list(*times);
        if (const auto* values = std::get_if<std::vector<float>>(&p)) list(*values);
        out += "*" + std::to_string(count) + " {\n" + indent + "\ta: " + numbers + "\n" + indent + "}";
      }
    }
    if (children.empty()) return out + "\n";
    out += " {\n";
    for (const Fbx& child : children) out += child.text(indent + "\t");
    return out + indent + "}\n";
  }

  /// @param wide of version 7.5 and newer. @param at where it begins in the file
  std::string bytes(bool wide, size_t at) const {
    const auto raw = [](auto value) { return std::string(reinterpret_cast<const char*>(&value), sizeof value); };
    const auto word = [&](size_t n) { return wide ? raw(static_cast<uint64_t>(n)) : raw(static_cast<uint32_t>(n)); };
    std::string values;
    for (const Property& p : properties) {
      if (const auto* s = std::get_if<std::string>(&p)) values += "S" + raw(static_cast<uint32_t>(s->size())) + *s;
      if (const auto* small = std::get_if<int32_t>(&p)) values += "I" + raw(*small);
      if (const auto* whole = std::get_if<int64_t>(&p)) values += "L" + raw(*whole);
      if (const auto* real = std::get_if<double>(&p)) values += "D" + raw(*real);
      const auto list = [&](char type, const auto& all) {
        std::string data;
        for (const auto& value : all) data += raw(value);
        values += type + raw(static_cast<uint32_t>(all.size())) + raw(uint32_t{0}) +
                  raw(static_cast<uint32_t>(data.size())) + data;
      };
      if (const auto* times = std::get_if<std::vector<int64_t>>(&p)) list('l', *times);
      if (const auto* floats = std::get_if<std::vector<float>>(&p)) list('f', *floats);
    }
    const size_t head = (wide ? 24 : 12) + 1 + name.size();
    std::string below;
    for (const Fbx& child : children) below += child.bytes(wide, at + head + values.size() + below.size());
    if (!children.empty()) below += std::string(wide ? 25 : 13, '\0');
    return word(at + head + values.size() + below.size()) + word(properties.size()) + word(values.size()) +
           static_cast<char>(name.size()) + name + values + below;
  }
};

Fbx property(const std::string& name, const std::string& type, std::vector<Fbx::Property> values) {
  std::vector<Fbx::Property> all = {name, type, std::string(), std::string()};
  all.insert(all.end(), values.begin(), values.end());
  return {"P", all, {}};
}
Fbx vector(const std::string& name, const Vector3d& v) { return property(name, "Vector3D", {v.x(), v.y(), v.z()}); }
std::string called(const std::string& name, const std::string& kind) { return name + std::string("\0\1", 2) + kind; }

/// What a joint says of itself besides its place.
struct FbxJoint {
  Vector3d pre = Vector3d::Zero(), post = Vector3d::Zero();  ///< degrees
  bool limits_only = false, spheric = false;
};

constexpr int kChain = 10, kKeys = 4;

/// What the joints of the chain are; the others have no rotations of their own.
FbxJoint joint_of(int j) {
  if (j == 2) return {{90, 0, 20}, Vector3d::Zero(), false, false};
  if (j == 3) return {{10, -30, 0}, {25, 40, -15}, false, false};
  if (j == 5) return {{0, 45, 0}, {0, 0, -90}, true, true};
  if (j == 6) return {Vector3d::Zero(), Vector3d::Zero(), false, true};
  return {};
}
Vector3d key_of(int j, int k) { return {7.0 * k - j, 11.0 * (k % 2) * j, 4.0 * k * k}; }  // degrees

/// A chain of joints 0.2 m long, whose take says that it lasts for the second key alone.
std::vector<Fbx> chain() {
  Fbx objects{"Objects", {}, {}}, connections{"Connections", {}, {}};
  const auto connect = [&](std::vector<Fbx::Property> p) { connections.children.push_back({"C", std::move(p), {}}); };
  const auto id = [](int64_t n) { return Fbx::Property(n); };
  std::vector<int64_t> times;
  for (int k = 0; k < kKeys; ++k) times.push_back(k * kSecond / 30);
  for (int j = 0; j < kChain; ++j) {
    const FbxJoint joint = joint_of(j);
    std::vector<Fbx> rows = {vector("Lcl Translation", {0, j == 0 ? 0 : 0.2, 0})};
    if (!joint.pre.isZero()) rows.push_back(vector("PreRotation", joint.pre));
    if (!joint.post.isZero()) rows.push_back(vector("PostRotation", joint.post));
    if (joint.limits_only) rows.push_back(property("RotationSpaceForLimitOnly", "bool", {int32_t{1}}));
    if (joint.spheric) rows.push_back(property("RotationOrder", "enum", {int32_t{6}}));
    objects.children.push_back({"Model",
                                {id(100 + j), called("J" + std::to_string(j), "Model"), std::string("LimbNode")},
                                {{"Version", {int32_t{232}}, {}}, {"Properties70", {}, rows}}});
    connect({std::string("OO"), id(100 + j), id(j == 0 ? 0 : 99 + j)});
    objects.children.push_back({"AnimationCurveNode",
                                {id(200 + j), called("R", "AnimCurveNode"), std::string()},
                                {{"Properties70", {}, {property("d|X", "Number", {0.0})}}}});
    connect({std::string("OO"), id(200 + j), id(2)});
    connect({std::string("OP"), id(200 + j), id(100 + j), std::string("Lcl Rotation")});
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<float> values;
      for (int k = 0; k < kKeys; ++k) values.push_back(static_cast<float>(key_of(j, k)[axis]));
      const int64_t curve = 300 + 3 * j + axis;
      objects.children.push_back(
          {"AnimationCurve",
           {id(curve), called("", "AnimCurve"), std::string()},
           {{"KeyVer", {int32_t{4008}}, {}}, {"KeyTime", {times}, {}}, {"KeyValueFloat", {values}, {}}}});
      connect({std::string("OP"), id(curve), id(200 + j), std::string("d|") + static_cast<char>('X' + axis)});
    }
  }
  objects.children.push_back(
      {"AnimationStack",
       {id(1), called("Take", "AnimStack"), std::string()},
       {{"Properties70",
         {},
         {property("LocalStart", "KTime", {kSecond / 30}), property("LocalStop", "KTime", {kSecond / 30})}}}});
  objects.children.push_back({"AnimationLayer",
                              {id(2), called("Base", "AnimLayer"), std::string()},
                              {{"Properties70", {}, {property("Weight", "Number", {100.0})}}}});
  connect({std::string("OO"), id(2), id(1)});
  return {
      {"GlobalSettings",
       {},
       {{"Version", {int32_t{1000}}, {}},
        {"Properties70", {}, {property("UpAxis", "int", {int32_t{1}}), property("TimeMode", "enum", {int32_t{6}})}}}},
      objects,
      connections};
}

std::string text_file(int version) {
  std::string out = "; FBX " + std::to_string(version / 1000) +
                    ".0 project file\nFBXHeaderExtension:  {\n\tFBXVersion: " + std::to_string(version) + "\n}\n";
  for (const Fbx& node : chain()) out += node.text();
  return out;
}
std::string binary_file(uint32_t version) {
  std::string out = std::string("Kaydara FBX Binary  \0\x1a\0", 23) +
                    std::string(reinterpret_cast<const char*>(&version), sizeof version);
  std::vector<Fbx> nodes = chain();
  nodes.insert(nodes.begin(), {"FBXHeaderExtension", {}, {{"FBXVersion", {static_cast<int32_t>(version)}, {}}}});
  for (const Fbx& node : nodes) out += node.bytes(version >= 7500, out.size());
  return out + std::string(version >= 7500 ? 25 : 13, '\0') + std::string(160, '\0');
}

Matrix3d turned(const Vector3d& degrees) {  // about x, then y, then z
  const Vector3d r = degrees * M_PI / 180;
  return (Eigen::AngleAxisd(r.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(r.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(r.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Metres between where joints come out of such a file and where the equation has them, at most.
double off_equation(const std::string& file) {
  const TempFolder folder;
  write_atomically(folder / "chain.fbx", file);
  ClipReadOptions as_it_is;
  as_it_is.up = UpAxis::y;
  as_it_is.scale = 1;
  const Clip clip = read_clip(folder / "chain.fbx", as_it_is);
  if (clip.frames() != kKeys || clip.skeleton.size() != kChain) return 1e9;
  double most = 0;
  for (int k = 0; k < kKeys; ++k) {
    Matrix3d above = Matrix3d::Identity();
    Vector3d at = Vector3d::Zero();
    for (int j = 0; j < kChain; ++j) {
      const FbxJoint joint = joint_of(j);
      if (j > 0) at += above * Vector3d(0, 0.2, 0);
      above = joint.limits_only
                  ? Matrix3d(above * turned(key_of(j, k)))
                  : Matrix3d(above * turned(joint.pre) * turned(key_of(j, k)) * turned(joint.post).transpose());
      for (int axis = 0; axis < 3; ++axis)
        most = std::max(most, std::abs(clip.joints[k][j][axis].item<double>() - at[axis]));
    }
  }
  return most;
}

TEST(FbxRepair, JointsAreWhereTheFormatsEquationHasThem) {
  EXPECT_LT(off_equation(text_file(7400)), 1e-5);
  EXPECT_LT(off_equation(binary_file(7400)), 1e-5);
  EXPECT_LT(off_equation(binary_file(7500)), 1e-5);
}

TEST(FbxRepair, LeavesAloneWhatItCannotFollow) {
  const std::string whole = binary_file(7500);
  for (size_t n = 1; n < whole.size(); n += 7) EXPECT_EQ(repaired_fbx(whole.substr(0, n), "x").size(), n);
  EXPECT_EQ(repaired_fbx("no such thing: at all", "x"), "no such thing: at all");
  std::string wild = whole;
  for (size_t n = 27; n < wild.size(); n += 3) wild[n] = static_cast<char>(0xFF);
  EXPECT_EQ(repaired_fbx(wild, "x").size(), wild.size());
  EXPECT_THAT(refusal_of([&] { repaired_fbx(binary_file(6100), "old.fbx"); }), HasSubstr("old.fbx: is FBX 6.1"));
  EXPECT_THAT(refusal_of([&] { repaired_fbx(text_file(6100), "old.fbx"); }), HasSubstr("FBX 2011"));
}

}  // namespace
}  // namespace inhabit
