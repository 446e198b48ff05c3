#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"
#include "inhabit/io/npz.h"

// Where joints are according to a file, worked out from its text or arrays by the definition of its format and by
// nothing of the library's readers or kinematics. Lengths in the file's unit.

/// By name of the joint, a place for every frame.
using Places = std::map<std::string, std::vector<Eigen::Vector3d>>;

inline Places places_in_bvh(const std::string& text) {
  struct Joint {
    std::string name;
    int parent;
    Eigen::Vector3d offset;
    std::vector<std::string> channels;
  };
  std::istringstream in(text);
  std::vector<Joint> joints;
  std::vector<int> open;
  std::string word, line;
  while (in >> word && word != "MOTION") {
    if (word == "ROOT" || word == "JOINT" || word == "End") {
      std::getline(in, line);
      const size_t first = line.find_first_not_of(" \t"), last = line.find_last_not_of(" \t\r");
      std::string name = first == std::string::npos ? "" : line.substr(first, last - first + 1);
      if (word == "End") name = joints[static_cast<size_t>(open.back())].name + "_end";
      joints.push_back({name, open.empty() ? -1 : open.back(), Eigen::Vector3d::Zero(), {}});
      open.push_back(static_cast<int>(joints.size()) - 1);
    } else if (word == "OFFSET") {
      Eigen::Vector3d& o = joints[static_cast<size_t>(open.back())].offset;
      in >> o[0] >> o[1] >> o[2];
    } else if (word == "CHANNELS") {
      int count = 0;
      in >> count;
      joints[static_cast<size_t>(open.back())].channels.resize(static_cast<size_t>(count));
      for (std::string& channel : joints[static_cast<size_t>(open.back())].channels) in >> channel;
    } else if (word == "}") {
      open.pop_back();
    }
  }
  int frames = 0;
  double seconds = 0;
  in >> word >> frames >> word >> word >> seconds;
  Places out;
  for (int f = 0; f < frames; ++f) {
    std::vector<Eigen::Matrix4d> world(joints.size());
    for (size_t j = 0; j < joints.size(); ++j) {
      Eigen::Vector3d place = joints[j].offset;
      Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
      for (const std::string& channel : joints[j].channels) {
        double value = 0;
        in >> value;
        const int axis = channel[0] - 'X';
        if (channel.substr(1) == "position")
          place[axis] = value;
        else
          rotation = rotation * Eigen::AngleAxisd(value * M_PI / 180, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
      }
      Eigen::Matrix4d local = Eigen::Matrix4d::Identity();
      local.topLeftCorner<3, 3>() = rotation;
      local.topRightCorner<3, 1>() = place;
      world[j] = joints[j].parent < 0 ? local : Eigen::Matrix4d(world[static_cast<size_t>(joints[j].parent)] * local);
      out[joints[j].name].push_back(world[j].topRightCorner<3, 1>());
    }
  }
  return out;
}

/// The joints of the first skin of a .glb, all tracks having a value a frame.
inline Places places_in_glb(const std::string& glb) {
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const nlohmann::json gltf = nlohmann::json::parse(glb.substr(20, length));
  const auto track = [&](size_t accessor, size_t width) {
    const auto& a = gltf["accessors"][accessor];
    const char* at =
        glb.data() + 20 + length + 8 + gltf["bufferViews"][a["bufferView"].get<size_t>()].value("byteOffset", 0);
    std::vector<float> values(a["count"].get<size_t>() * width);
    std::memcpy(values.data(), at, values.size() * 4);
    return values;
  };
  std::map<int, std::vector<float>> rotations, moves;
  size_t frames = 0;
  for (const auto& channel : gltf["animations"][0]["channels"]) {
    const size_t output = gltf["animations"][0]["samplers"][channel["sampler"].get<size_t>()]["output"];
    const int node = channel["target"]["node"];
    if (channel["target"]["path"] == "rotation")
      rotations[node] = track(output, 4), frames = rotations[node].size() / 4;
    else
      moves[node] = track(output, 3);
  }
  Places out;
  const std::function<void(int, size_t, const Eigen::Affine3d&)> descend = [&](int n, size_t f,
                                                                               const Eigen::Affine3d& above) {
    const auto& node = gltf["nodes"][static_cast<size_t>(n)];
    Eigen::Vector3d place(node["translation"][0], node["translation"][1], node["translation"][2]);
    if (moves.count(n) != 0) place = Eigen::Vector3d(moves[n][3 * f], moves[n][3 * f + 1], moves[n][3 * f + 2]);
    const float* q = rotations.at(n).data() + 4 * f;
    const Eigen::Affine3d world = above * Eigen::Translation3d(place) * Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
    out[node["name"]].push_back(world.translation());
    if (node.contains("children"))
      for (const int child : node["children"]) descend(child, f, world);
  };
  for (size_t f = 0; f < frames; ++f) descend(gltf["skins"][0]["joints"][0], f, Eigen::Affine3d::Identity());
  return out;
}

/// Of inhabit's own arrays, whatever they are kept in. @param number value of an array at frame, joint, axis.
inline Places places_in_arrays(const std::vector<std::string>& names, const std::vector<int>& parents, size_t frames,
                               const std::function<double(const char*, size_t, size_t, int)>& number, bool translates) {
  Places out;
  for (size_t f = 0; f < frames; ++f) {
    std::vector<Eigen::Affine3d> world(names.size());
    for (size_t j = 0; j < names.size(); ++j) {
      Eigen::Vector3d axis_angle, place;
      for (int k = 0; k < 3; ++k) {
        axis_angle[k] = number("rotations", f, j, k);
        place[k] = number(translates ? "translations" : "offsets", f, j, k);
        if (j == 0) place[k] += number("trans", f, 0, k);
      }
      const Eigen::AngleAxisd rotation(axis_angle.norm(),
                                       axis_angle.norm() > 0 ? axis_angle.normalized() : Eigen::Vector3d::UnitX());
      const Eigen::Affine3d local = Eigen::Translation3d(place) * rotation;
      world[j] = parents[j] < 0 ? local : world[static_cast<size_t>(parents[j])] * local;
      out[names[j]].push_back(world[j].translation());
    }
  }
  return out;
}

inline Places places_in_npz(const inhabit::Npz& npz) {
  const std::vector<std::string>& names = npz.strings.at("joint_names").values;
  std::vector<int> parents;
  for (size_t j = 0; j < names.size(); ++j)
    parents.push_back(npz.tensors.at("parents")[static_cast<int64_t>(j)].item<int>());
  const auto J = static_cast<int64_t>(names.size());
  const torch::Tensor trans = npz.tensors.at("trans"), offsets = npz.tensors.at("offsets");
  const torch::Tensor poses = npz.has("poses")
                                  ? npz.tensors.at("poses")
                                  : torch::cat({npz.tensors.at("root_orient"), npz.tensors.at("pose_body")}, 1);
  const torch::Tensor rotations = poses.reshape({trans.size(0), J, 3});
  const auto number = [&](const char* array, size_t f, size_t j, int k) -> double {
    const auto t = static_cast<int64_t>(f), joint = static_cast<int64_t>(j);
    const std::string name(array);
    if (name == "offsets") return offsets[joint][k].item<double>();
    if (name == "trans") return trans[t][k].item<double>();
    return (name == "rotations" ? rotations : npz.tensors.at("translations"))[t][joint][k].item<double>();
  };
  return places_in_arrays(names, parents, static_cast<size_t>(trans.size(0)), number, npz.has("translations"));
}

inline Places places_in_json(const std::string& text) {
  const nlohmann::json file = nlohmann::json::parse(text);
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const auto& joint : file["skeleton"]) {
    names.push_back(joint["name"]);
    parents.push_back(joint["parent"]);
  }
  const auto number = [&](const char* array, size_t f, size_t j, int k) -> double {
    const std::string name(array);
    const auto axis = static_cast<size_t>(k);
    if (name == "offsets") return file["skeleton"][j]["offset"][axis];
    if (name == "trans") return file["trans"][f][axis];
    return file[name][f][j][axis];
  };
  return places_in_arrays(names, parents, file["trans"].size(), number, file.contains("translations"));
}

/// Exponential-map text in metres: a row is the root's translation, then an axis-angle for each joint, whose rotation
/// is the opposite one. @param skeleton the data set's, in metres. @param unit metres, of the root's columns. @param
/// steps the root's columns are what it did since the row before, seen from where it was then (Human3.6M); else where
/// it is
inline Places places_in_expmap_text(const std::string& text, const inhabit::Skeleton& skeleton, double unit,
                                    bool steps) {
  Places out;
  Eigen::Matrix3d root = Eigen::Matrix3d::Identity();
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    Eigen::Vector3d move, w;
    row >> move[0] >> move[1] >> move[2];
    place = steps ? Eigen::Vector3d(place + root * move * unit) : Eigen::Vector3d(move * unit);
    std::vector<Eigen::Matrix3d> rotations;
    std::vector<Eigen::Vector3d> places;
    for (int j = 0; j < skeleton.size(); ++j) {
      row >> w[0] >> w[1] >> w[2];
      // Rodrigues' formula of -w.
      const double angle = w.norm();
      Eigen::Matrix3d cross, rotation = Eigen::Matrix3d::Identity();
      cross << 0, w[2], -w[1], -w[2], 0, w[0], w[1], -w[0], 0;
      if (angle > 0)
        rotation += std::sin(angle) / angle * cross + (1 - std::cos(angle)) / (angle * angle) * cross * cross;
      const int parent = skeleton.parents[static_cast<size_t>(j)];
      if (parent < 0) {
        root = steps ? Eigen::Matrix3d(root * rotation) : rotation;
        rotations.push_back(root);
        places.push_back(place);
      } else {
        const auto above = static_cast<size_t>(parent);
        Eigen::Vector3d bone;
        for (int k = 0; k < 3; ++k) bone[k] = skeleton.offsets[j][k].item<double>();
        places.push_back(places[above] + rotations[above] * bone);
        rotations.push_back(rotations[above] * rotation);
      }
      out[skeleton.names[static_cast<size_t>(j)]].push_back(places.back());
    }
  }
  return out;
}

/// Acclaim's pair in its unit of length, angles in degrees: a joint is where its bone begins, moved by what the bone
/// translates, and "NAME_end" where it ends. A bone's rotation is C M C^-1, C of its axes and M of its degrees of
/// freedom.
inline Places places_in_acclaim(const std::string& asf, const std::string& amc) {
  struct Bone {
    std::string parent;
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    std::vector<std::string> channels;
    bool ends = true;
  };
  const auto about = [](char axis, double degrees) {
    return Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d::Unit(axis - 'x')).toRotationMatrix();
  };
  std::map<std::string, Bone> bones;
  std::vector<std::string> order = {"root"};  // parents before their children
  std::string name, section;
  std::istringstream lines(asf);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key, word;
    words >> key;
    if (key[0] == ':') section = key;
    if (section == ":root" && key == "order") {
      while (words >> word)
        bones["root"].channels.push_back(
            {static_cast<char>(std::tolower(word[0])), static_cast<char>(std::tolower(word[1]))});
    } else if (section == ":bonedata") {
      if (key == "name") words >> name;
      Eigen::Vector3d v = Eigen::Vector3d::Zero();
      if (key == "direction") words >> v[0] >> v[1] >> v[2], bones[name].tip = v;
      if (key == "length") words >> v[0], bones[name].tip *= v[0];
      if (key == "axis")
        words >> v[0] >> v[1] >> v[2], bones[name].axes = about('z', v[2]) * about('y', v[1]) * about('x', v[0]);
      while (key == "dof" && words >> word) bones[name].channels.push_back(word);
    } else if (section == ":hierarchy" && bones.count(key) != 0) {
      bones[key].ends = false;
      while (words >> word) bones[word].parent = key, order.push_back(word);
    }
  }
  Places out;
  std::map<std::string, std::vector<double>> numbers;
  const auto end_frame = [&] {
    std::map<std::string, Eigen::Affine3d> world;
    for (const std::string& bone_name : order) {
      const Bone& bone = bones[bone_name];
      Eigen::Vector3d move = Eigen::Vector3d::Zero();
      Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
      for (size_t k = 0; k < bone.channels.size(); ++k) {
        const double value = numbers.at(bone_name).at(k);
        const char axis = bone.channels[k][1];
        if (bone.channels[k][0] == 't')
          move[axis - 'x'] = value;
        else
          rotation = about(axis, value) * rotation;
      }
      const Eigen::Vector3d begin = bone.parent.empty() ? Eigen::Vector3d(0, 0, 0) : bones[bone.parent].tip;
      const Eigen::Affine3d above = bone.parent.empty() ? Eigen::Affine3d::Identity() : world.at(bone.parent);
      world[bone_name] = above * Eigen::Translation3d(begin + bone.axes * move) *
                         Eigen::Affine3d(bone.axes * rotation * bone.axes.transpose());
      out[bone_name].push_back(world[bone_name].translation());
      if (bone.ends) out[bone_name + "_end"].push_back(world[bone_name] * bone.tip);
    }
  };
  std::istringstream motion(amc);
  for (std::string line; std::getline(motion, line);) {
    std::istringstream words(line);
    words >> name;
    if (bones.count(name) == 0) {
      if (!numbers.empty()) end_frame(), numbers.clear();
      continue;
    }
    for (double value = 0; words >> value;) numbers[name].push_back(value);
  }
  end_frame();
  return out;
}
