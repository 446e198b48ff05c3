#include "inhabit/io/node_tracks.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/fbx_repair.h"
#include "inhabit/math/quantile.h"

namespace inhabit {
namespace {

using Eigen::Affine3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr size_t kLeastJoints = 8;        // of a person
constexpr double kDense = 10;             // keys a second that are sampled motion, not poses set by hand
constexpr double kMostJointFrames = 1e7;  // 65 joints for an hour and a half: half a gigabyte
constexpr int kDeepestTrack = 2000;       // nodes below each other

Affine3d affine(const aiMatrix4x4& m) {
  Affine3d out;
  out.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return out;
}

/// The rotation of a transform that may scale and mirror: mirrored ones agree among themselves.
Quaterniond rotation_of(const Affine3d& transform) {
  Eigen::Matrix3d m = transform.linear();
  for (int k = 0; k < 3; ++k) {
    const double length = m.col(k).norm();
    if (!(length > 1e-12)) return Quaterniond::Identity();
    m.col(k) /= length;
  }
  if (m.determinant() < 0) m.col(0) = -m.col(0);
  return Quaterniond(m).normalized();
}

/// A node of the file, parents first.
struct Node {
  const aiNode* node = nullptr;
  int parent = -1;
  bool joint = false;
};

void collect(const aiNode* node, int parent, int depth, std::vector<Node>& out, const std::string& path) {
  if (depth > kDeepestTrack) throw Error(path, "its nodes lie too deep below each other");
  const int at = static_cast<int>(out.size());
  out.push_back({node, parent});
  for (unsigned k = 0; k < node->mNumChildren; ++k) collect(node->mChildren[k], at, depth + 1, out, path);
}

bool moves(const aiNodeAnim& channel) {
  for (unsigned k = 1; k < channel.mNumPositionKeys; ++k)
    if ((channel.mPositionKeys[k].mValue - channel.mPositionKeys[0].mValue).Length() > 1e-6F) return true;
  for (unsigned k = 1; k < channel.mNumRotationKeys; ++k)
    if (!channel.mRotationKeys[k].mValue.Equal(channel.mRotationKeys[0].mValue, 1e-6F)) return true;
  return false;
}

struct BoundSkin {
  std::map<std::string, Quaterniond> rest;  // bone -> global rotation that the skin was bound in
};

BoundSkin skin_of(const aiScene& scene, const std::vector<Node>& nodes) {
  std::vector<Affine3d> global(nodes.size());
  for (size_t k = 0; k < nodes.size(); ++k) {
    const Affine3d local = affine(nodes[k].node->mTransformation);
    global[k] = nodes[k].parent < 0 ? local : global[static_cast<size_t>(nodes[k].parent)] * local;
  }
  BoundSkin out;
  for (size_t k = 0; k < nodes.size(); ++k)
    for (unsigned m = 0; m < nodes[k].node->mNumMeshes; ++m) {
      const aiMesh& mesh = *scene.mMeshes[nodes[k].node->mMeshes[m]];
      for (unsigned b = 0; b < mesh.mNumBones; ++b) {
        const Affine3d bound = affine(mesh.mBones[b]->mOffsetMatrix);  // mesh to bone
        if (!(std::abs(bound.linear().determinant()) > 1e-30)) continue;
        out.rest.emplace(mesh.mBones[b]->mName.C_Str(), rotation_of(global[k] * bound.inverse()));
      }
    }
  return out;
}

/// Marks the joints: bones of a skin, animated nodes without a mesh, all between two of them, and what hangs below.
void mark_joints(const aiScene& scene, const BoundSkin& skin, std::vector<Node>& nodes) {
  std::set<std::string> moving, others;
  for (unsigned a = 0; a < scene.mNumAnimations; ++a)
    for (unsigned c = 0; c < scene.mAnimations[a]->mNumChannels; ++c)
      if (const aiNodeAnim& channel = *scene.mAnimations[a]->mChannels[c]; moves(channel))
        moving.insert(channel.mNodeName.C_Str());
  for (unsigned k = 0; k < scene.mNumCameras; ++k) others.insert(scene.mCameras[k]->mName.C_Str());
  for (unsigned k = 0; k < scene.mNumLights; ++k) others.insert(scene.mLights[k]->mName.C_Str());
  const auto is_one = [&](const Node& n) {
    const std::string name = n.node->mName.C_Str();
    return skin.rest.count(name) != 0 ||
           (moving.count(name) != 0 && n.node->mNumMeshes == 0 && others.count(name) == 0);
  };
  for (const Node& n : nodes) {
    if (!is_one(n)) continue;
    std::vector<int> between;
    for (int up = static_cast<int>(&n - nodes.data()); up >= 0; up = nodes[static_cast<size_t>(up)].parent) {
      between.push_back(up);
      if (!is_one(nodes[static_cast<size_t>(up)])) continue;
      for (const int k : between) nodes[static_cast<size_t>(k)].joint = true;
      between.clear();
    }
  }
  for (Node& n : nodes)
    if (n.parent >= 0 && nodes[static_cast<size_t>(n.parent)].joint && n.node->mNumMeshes == 0 &&
        others.count(n.node->mName.C_Str()) == 0)
      n.joint = true;
}

using Channels = std::map<std::string, const aiNodeAnim*>;

Channels channels_of(const aiAnimation& animation) {
  Channels out;
  for (unsigned c = 0; c < animation.mNumChannels; ++c)
    out.emplace(animation.mChannels[c]->mNodeName.C_Str(), animation.mChannels[c]);
  return out;
}

/// Where `time` lies in keys sorted by time: the key before it, and how far on to the next.
template <typename Key>
std::pair<unsigned, double> place(const Key* keys, unsigned count, double time) {
  const Key* after = std::upper_bound(keys, keys + count, time, [](double t, const Key& k) { return t < k.mTime; });
  if (after == keys) return {0, 0};
  if (after == keys + count) return {count - 1, 0};
  const double gap = after->mTime - (after - 1)->mTime;
  return {static_cast<unsigned>(after - keys) - 1, gap > 0 ? (time - (after - 1)->mTime) / gap : 0};
}

Vector3d vector_at(const aiVectorKey* keys, unsigned count, double time, const Vector3d& otherwise) {
  if (count == 0) return otherwise;
  const auto [at, part] = place(keys, count, time);
  const auto value = [&](unsigned k) { return Vector3d(keys[k].mValue.x, keys[k].mValue.y, keys[k].mValue.z); };
  return part > 0 ? Vector3d(value(at) + part * (value(at + 1) - value(at))) : value(at);
}

Quaterniond quaternion_at(const aiQuatKey* keys, unsigned count, double time, const Quaterniond& otherwise) {
  if (count == 0) return otherwise;
  const auto [at, part] = place(keys, count, time);
  const auto value = [&](unsigned k) {
    const aiQuaternion& q = keys[k].mValue;
    return Quaterniond(q.w, q.x, q.y, q.z).normalized();
  };
  return part > 0 ? value(at).slerp(part, value(at + 1)) : value(at);
}

/// A node's own transform, and what moves it.
struct Local {
  Affine3d still;
  const aiNodeAnim* channel = nullptr;
  Vector3d place, scale;
  Quaterniond rotation;

  Local(const aiNode& node, const Channels& channels) : still(affine(node.mTransformation)) {
    const auto found = channels.find(node.mName.C_Str());
    if (found == channels.end()) return;
    channel = found->second;
    place = still.translation();
    rotation = rotation_of(still);
    scale = still.linear().colwise().norm();
  }
  Affine3d at(double time) const {
    if (channel == nullptr) return still;
    const Vector3d p = vector_at(channel->mPositionKeys, channel->mNumPositionKeys, time, place);
    const Quaterniond q = quaternion_at(channel->mRotationKeys, channel->mNumRotationKeys, time, rotation);
    const Vector3d s = vector_at(channel->mScalingKeys, channel->mNumScalingKeys, time, scale);
    return Eigen::Translation3d(p) * q * Eigen::Scaling(s);
  }
};

/// When an animation moves a person, in its ticks, and at how many frames a second that is to be read.
struct Span {
  double first = 0, last = 0, ticks = 1, rate = 30;
  int64_t frames() const { return std::llround((last - first) / ticks * rate) + 1; }
};

std::optional<Span> span_of(const aiAnimation& animation, const Channels& channels, const std::vector<Node>& nodes,
                            const std::vector<int>& joints, const std::string& path) {
  Span out;
  bool any = false, moved = false;
  size_t keyed = 0;  // joints with rotations
  std::vector<double> densest;
  const auto times_of = [](const auto* keys, unsigned count) {
    std::vector<double> times;
    for (unsigned k = 0; k < count; ++k) times.push_back(keys[k].mTime);
    return times;
  };
  for (const int joint : joints) {
    const auto found = channels.find(nodes[static_cast<size_t>(joint)].node->mName.C_Str());
    if (found == channels.end()) continue;
    const aiNodeAnim& c = *found->second;
    moved = moved || moves(c);
    if (c.mNumRotationKeys > 0) ++keyed;
    for (std::vector<double> times :
         {times_of(c.mPositionKeys, c.mNumPositionKeys), times_of(c.mRotationKeys, c.mNumRotationKeys)}) {
      if (times.empty()) continue;
      for (size_t k = 0; k < times.size(); ++k)
        if (!std::isfinite(times[k]) || (k > 0 && times[k] < times[k - 1]))
          throw Error(path, "keys of an animation are out of order");
      out.first = any ? std::min(out.first, times.front()) : times.front();
      out.last = any ? std::max(out.last, times.back()) : times.back();
      any = true;
      if (times.size() > densest.size()) densest = std::move(times);
    }
  }
  // Somebody who holds a pose, in one frame or in many, is one whose joints it sets.
  if (!moved && keyed < kLeastJoints) return {};
  out.ticks =
      animation.mTicksPerSecond > 0 && std::isfinite(animation.mTicksPerSecond) ? animation.mTicksPerSecond : 25;
  std::vector<double> gaps;
  for (size_t k = 1; k < densest.size(); ++k)
    if (densest[k] > densest[k - 1]) gaps.push_back((densest[k] - densest[k - 1]) / out.ticks);
  double rate = out.ticks >= kDense && out.ticks <= 240 ? out.ticks : 0;
  if (!gaps.empty()) {
    double keys = 1 / median(gaps);
    if (std::abs(keys - std::round(keys)) < 3e-4 * keys) keys = std::round(keys);  // 29.97 is not 30
    // Curves of three axes whose keys lie at different times have gaps of all lengths once they are put together: they
    // say nothing, and the file's own rate stays.
    const auto even =
        std::count_if(gaps.begin(), gaps.end(), [&](double gap) { return std::abs(gap * keys - 1) < 0.05; });
    const bool sampled = 2 * static_cast<size_t>(even) >= gaps.size() || rate == 0;
    if (keys >= kDense && sampled) rate = std::max(rate, std::min(keys, 1000.0));
  }
  if (rate > 0) out.rate = rate;
  const double frames = (out.last - out.first) / out.ticks * out.rate;
  if (!(frames * static_cast<double>(joints.size()) < kMostJointFrames))
    throw Error(path, "its animation is too long to be read whole");
  return out;
}

void sample(const Span& span, const Channels& channels, const std::vector<Node>& nodes, const std::vector<int>& joints,
            NodeTracks& out, const std::string& path) {
  // The joints and all that they hang on, parents first.
  std::set<int> needed;
  for (const int joint : joints)
    for (int up = joint; up >= 0 && needed.insert(up).second;) up = nodes[static_cast<size_t>(up)].parent;
  std::vector<Local> locals;
  locals.reserve(needed.size());
  for (const int k : needed) locals.emplace_back(*nodes[static_cast<size_t>(k)].node, channels);
  std::vector<Affine3d> global(nodes.size());
  const int64_t frames = span.frames();
  out.joints.reserve(static_cast<size_t>(frames) * joints.size() * 3);
  out.rotations.reserve(static_cast<size_t>(frames) * joints.size() * 4);
  for (int64_t t = 0; t < frames; ++t) {
    const double time = span.first + static_cast<double>(t) / span.rate * span.ticks;
    auto local = locals.begin();
    for (const int k : needed) {
      const auto at = static_cast<size_t>(k);
      const Affine3d own = (local++)->at(time);
      global[at] = nodes[at].parent < 0 ? own : global[static_cast<size_t>(nodes[at].parent)] * own;
    }
    for (const int joint : joints) {
      const Affine3d& at = global[static_cast<size_t>(joint)];
      const Quaterniond q = rotation_of(at);
      if (!at.matrix().allFinite()) throw Error(path, "a joint is not at a finite place");
      out.joints.insert(out.joints.end(), at.translation().data(), at.translation().data() + 3);
      out.rotations.insert(out.rotations.end(), q.coeffs().data(), q.coeffs().data() + 4);
    }
  }
}

/// Names, parents and rest of the joints.
NodeTracks joints_of(const std::vector<Node>& nodes, const std::vector<int>& joints, const BoundSkin& skin) {
  NodeTracks out;
  std::map<int, int> place;
  std::map<std::string, int> times;
  std::vector<Quaterniond> rest;
  for (const int joint : joints) {
    const Node& n = nodes[static_cast<size_t>(joint)];
    place[joint] = static_cast<int>(out.names.size());
    const auto above = place.find(n.parent);
    out.parents.push_back(above == place.end() ? -1 : above->second);
    std::string name = n.node->mName.C_Str();
    const int before = times[name]++;
    out.names.push_back(before > 0 ? name + "." + std::to_string(before) : name);
    const auto bound = skin.rest.find(name);
    if (bound != skin.rest.end()) {
      rest.push_back(bound->second);
    } else if (above != place.end()) {
      rest.push_back(
          (rest[static_cast<size_t>(above->second)] * rotation_of(affine(n.node->mTransformation))).normalized());
    } else {
      Affine3d global = affine(n.node->mTransformation);
      for (int up = n.parent; up >= 0; up = nodes[static_cast<size_t>(up)].parent)
        global = affine(nodes[static_cast<size_t>(up)].node->mTransformation) * global;
      rest.push_back(rotation_of(global));
    }
    out.rest.insert(out.rest.end(), rest.back().coeffs().data(), rest.back().coeffs().data() + 4);
  }
  return out;
}

}  // namespace

std::vector<NodeTracks> node_tracks(const std::string& path, bool sampled) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
  std::string fbx;
  if (extension_of(path) == "fbx") fbx = repaired_fbx(read_whole_file(path), path);
  const aiScene* scene =
      fbx.empty() ? importer.ReadFile(path, aiProcess_ValidateDataStructure)
                  : importer.ReadFileFromMemory(fbx.data(), fbx.size(), aiProcess_ValidateDataStructure, "fbx");
  if (scene == nullptr || scene->mRootNode == nullptr)
    throw Error(path, std::string("cannot be read: ") + importer.GetErrorString());
  std::vector<Node> nodes;
  collect(scene->mRootNode, -1, 0, nodes, path);
  const BoundSkin skin = skin_of(*scene, nodes);
  mark_joints(*scene, skin, nodes);

  std::vector<std::vector<int>> people;
  std::map<int, size_t> person_of;
  for (int k = 0; k < static_cast<int>(nodes.size()); ++k) {
    const Node& n = nodes[static_cast<size_t>(k)];
    if (!n.joint) continue;
    const auto above = person_of.find(n.parent);
    if (above == person_of.end()) people.emplace_back();
    const size_t person = above == person_of.end() ? people.size() - 1 : above->second;
    person_of[k] = person;
    people[person].push_back(k);
  }
  std::stable_sort(people.begin(), people.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<NodeTracks> out;
  std::set<std::string> taken;
  for (const std::vector<int>& joints : people) {
    if (joints.size() < kLeastJoints) break;
    const auto name_of = [&](int joint) { return std::string(nodes[static_cast<size_t>(joint)].node->mName.C_Str()); };
    if (std::any_of(joints.begin(), joints.end(), [&](int joint) { return taken.count(name_of(joint)) != 0; })) {
      if (!out.empty()) ++out.front().alike;
      continue;
    }
    for (const int joint : joints) taken.insert(name_of(joint));
    std::vector<std::pair<Span, const aiAnimation*>> moved;
    for (unsigned a = 0; a < scene->mNumAnimations; ++a)
      if (const auto span = span_of(*scene->mAnimations[a], channels_of(*scene->mAnimations[a]), nodes, joints, path))
        moved.emplace_back(*span, scene->mAnimations[a]);
    std::stable_sort(moved.begin(), moved.end(),
                     [](const auto& a, const auto& b) { return a.first.frames() > b.first.frames(); });
    for (const auto& [span, animation] : moved) {
      out.push_back(joints_of(nodes, joints, skin));
      out.back().rate = span.rate;
      out.back().animation = animation->mName.C_Str();
      if (sampled) sample(span, channels_of(*animation), nodes, joints, out.back(), path);
    }
  }
  return out;
}

}  // namespace inhabit
