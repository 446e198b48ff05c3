#include "inhabit/io/clip_npz.h"

#include <initializer_list>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/joint_array.h"
#include "inhabit/io/source_motion.h"
#include "inhabit/io/upright.h"
#include "inhabit/lower_case.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/human36m_joints.h"

namespace inhabit {
namespace {

using torch::Tensor;
using Names = std::initializer_list<const char*>;

void note(Notes* notes, const std::string& text) {
  if (notes != nullptr) notes->push_back(text);
}

const char* first_of(const Npz& npz, const Names& names) {
  for (const char* name : names)
    if (npz.has(name)) return name;
  return nullptr;
}

Tensor as_float(const Tensor& t) { return t.to(torch::kFloat32); }

/// The first array of `names` as float, undefined where there is none.
Tensor any_of(const Npz& npz, const Names& names) {
  const char* name = first_of(npz, names);
  return name == nullptr ? Tensor() : as_float(npz.at(name, ""));
}

/// (T, J, 3) axis-angle from (T, 3J), (T, J, 3) or (T, J, 3, 3), undefined where no array of `names` is there.
Tensor rotations_of(const Npz& npz, const Names& names, const std::string& subject) {
  const char* name = first_of(npz, names);
  if (name == nullptr) {
    for (const char* n : names)
      if (npz.skipped.count(n) != 0) npz.at(n, subject);  // says why it cannot be read
    return {};
  }
  Tensor t = as_float(npz.at(name, subject));
  const std::string at = std::string("its array ") + name;
  if (t.dim() == 4 && t.size(2) == 3 && t.size(3) == 3) {
    if (!torch::isfinite(t).all().item<bool>()) throw Error(subject, at + " has a value that is not finite");
    return matrix_to_axis_angle(t);
  }
  if (t.dim() == 3 && t.size(2) == 3) return t;
  if (t.dim() == 3 && t.size(1) == 1) t = t.squeeze(1);
  if (t.dim() == 1 && t.size(0) % 3 == 0) t = t.unsqueeze(0);  // a single frame
  if (t.dim() == 2 && t.size(1) == 32 && std::string(name) == "body_pose")
    throw Error(subject, at + " holds VPoser codes; joint angles are needed");
  if (t.dim() != 2 || t.size(1) % 3 != 0 || t.size(1) == 0)
    throw Error(subject, at + " is neither (T, 3J) nor (T, J, 3) nor (T, J, 3, 3)");
  return t.view({t.size(0), t.size(1) / 3, 3});
}

/// Every joint's rotation in the order of SMPL-X: 22 of the body, jaw and eyes, hands. Undefined parts are not known.
struct PoseParts {
  Tensor body;   ///< (T, 22, 3)
  Tensor face;   ///< (T, 3, 3)
  Tensor hands;  ///< (T, 30, 3)
};

PoseParts split_pose(const Tensor& pose, const std::string& subject) {
  const int64_t J = pose.size(1);
  PoseParts parts;
  if (J != 22 && J != 24 && J != 52 && J != 55)
    throw Error(subject, "a pose of " + std::to_string(J) + " joints is none of the SMPL family's (22, 24, 52 or 55)");
  parts.body = pose.narrow(1, 0, 22);
  if (J == 52) parts.hands = pose.narrow(1, 22, 30);
  if (J == 55) {
    parts.face = pose.narrow(1, 22, 3);
    parts.hands = pose.narrow(1, 25, 30);
  }
  return parts;
}

PoseParts join_parts(const Npz& npz, const Tensor& root, const Tensor& body, const std::string& subject) {
  if (!body.defined()) throw Error(subject, "has the root's orientation but neither pose_body nor body_pose");
  if (!root.defined()) throw Error(subject, "has a body pose but no root_orient or global_orient");
  const int64_t T = root.size(0), J = body.size(1);
  if (root.size(1) != 1) throw Error(subject, "the root's orientation is not one rotation a frame");
  if (J == 22 || J == 24 || J == 52 || J == 55) return split_pose(body, subject);  // some files repeat the root there
  if (J != 21 && J != 23) throw Error(subject, "a body pose of " + std::to_string(J) + " joints, 21 or 23 expected");
  if (body.size(0) != T) throw Error(subject, "root orientation and body pose differ in their number of frames");
  PoseParts parts;
  parts.body = torch::cat({root, body.narrow(1, 0, 21)}, 1);
  Tensor hands = rotations_of(npz, {"pose_hand", "hand_pose"}, subject);
  if (!hands.defined()) {
    const Tensor left = rotations_of(npz, {"left_hand_pose"}, subject);
    const Tensor right = rotations_of(npz, {"right_hand_pose"}, subject);
    if (left.defined() && right.defined() && left.sizes() == right.sizes()) hands = torch::cat({left, right}, 1);
  }
  if (hands.defined() && hands.size(0) == T && hands.size(1) == 30) parts.hands = hands;
  const Tensor jaw = rotations_of(npz, {"pose_jaw", "jaw_pose"}, subject);
  if (jaw.defined() && jaw.size(0) == T && jaw.size(1) == 1) {
    const Tensor eyes = rotations_of(npz, {"pose_eye", "eye_pose"}, subject);
    const bool has_eyes = eyes.defined() && eyes.size(0) == T && eyes.size(1) == 2;
    parts.face = torch::cat({jaw, has_eyes ? eyes : torch::zeros({T, 2, 3})}, 1);
  }
  return parts;
}

/// The pose on a body with J joints (22; SMPL's 24; SMPL-H's 52; SMPL-X's 55); parts that are not known stay at rest.
Tensor pose_for(const PoseParts& parts, int64_t J) {
  const int64_t T = parts.body.size(0);
  std::vector<Tensor> joints = {parts.body};
  auto add = [&](const Tensor& part, int64_t n) { joints.push_back(part.defined() ? part : torch::zeros({T, n, 3})); };
  if (J == 24) add({}, 2);
  if (J == 55) add(parts.face, 3);
  if (J == 52 || J == 55) add(parts.hands, 30);
  return torch::cat(joints, 1);
}

double rate_of(const Npz& npz, const std::string& subject, const ClipReadOptions& options, Notes* notes) {
  if (options.rate != 0) return options.rate;
  const char* name = first_of(npz, {"mocap_framerate", "mocap_frame_rate", "fps", "framerate", "frame_rate"});
  if (name == nullptr) {
    note(notes, "no frame rate in the file: 30 a second assumed");
    return 30.0;
  }
  const Tensor& t = npz.at(name, subject);
  if (t.numel() != 1) throw Error(subject, std::string("its array ") + name + " is not one number");
  return t.to(torch::kFloat64).item<double>();
}

std::string text_of(const Npz& npz, const char* name) {
  const auto found = npz.strings.find(name);
  return found == npz.strings.end() || found->second.values.empty() ? std::string() : found->second.values[0];
}

std::string gender_of(const Npz& npz) {
  const std::string text = lower_case(text_of(npz, "gender"));
  if (text == "f" || text.find("female") != std::string::npos) return "female";
  return text == "m" || text.find("male") != std::string::npos ? "male" : "neutral";
}

/// One shape (B) of (B), (1, B) or (T, B).
Tensor shape_of(const Npz& npz, const std::string& subject, Notes* notes) {
  Tensor betas = any_of(npz, {"betas", "beta", "shape"});
  if (!betas.defined()) return {};
  if (betas.dim() == 3 && betas.size(1) == 1) betas = betas.squeeze(1);
  if (betas.dim() == 2 && betas.size(0) > 0) {
    if ((betas - betas[0]).abs().gt(1e-6).any().item<bool>())
      note(notes, "the body shape changes from frame to frame: the first is taken");
    betas = betas[0];
  }
  if (betas.dim() != 1) throw Error(subject, "its betas are not one row of shape parameters");
  return betas.contiguous();
}

/// "smplx" of "SMPL-X" and "smplx_locked_head", alike for the others of the family; else the text as it is.
std::string family_of(const std::string& model) {
  std::string letters;
  for (const char c : model)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* family : {"smplx", "smplh"})
    if (letters.rfind(family, 0) == 0) return family;
  return letters == "smpl" ? letters : model;
}

/// Where the pelvis of the mean body of each model rests, metres: trans is measured from there.
Tensor family_pelvis(const std::string& body) {
  return body == "smplx" ? torch::tensor({0.003F, -0.351F, 0.012F}) : torch::tensor({-0.002F, -0.223F, 0.028F});
}

bool pelvis_points_along_z(const Tensor& root_matrices, const Tensor& root_path, const std::string& subject,
                           const ClipReadOptions& options, Notes* notes) {
  const Tensor trunk = root_matrices.select(2, 1).mean(0);  // where the pelvis' own up points, on average
  check_told_up(Eigen::Vector3d(trunk[0].item<double>(), trunk[1].item<double>(), trunk[2].item<double>()), options.up,
                subject, notes);
  if (options.up != UpAxis::automatic) return options.up == UpAxis::z;
  const float y = trunk[1].item<float>(), z = trunk[2].item<float>();
  bool z_up = z > y;
  if (std::max(y, z) < 0.4F) {  // lying: then it is the axis along which the pelvis moves least
    const Tensor spread = std::get<0>(root_path.max(0)) - std::get<0>(root_path.min(0));
    z_up = spread[2].item<float>() < spread[1].item<float>();
  }
  note(notes, z_up ? "+Z is up in the file (detected): rotated to +Y" : "+Y is up in the file (detected)");
  return z_up;
}

Skeleton own_skeleton(const Npz& npz, const std::string& subject) {
  Skeleton skeleton;
  const auto names = npz.strings.find("joint_names");
  const Tensor& parents = npz.at("parents", subject);
  if (names == npz.strings.end()) throw Error(subject, "has parents but no joint_names");
  if (parents.dim() != 1 || parents.is_floating_point()) throw Error(subject, "its parents are not (J) whole numbers");
  skeleton.names = names->second.values;
  const Tensor whole = parents.to(torch::kInt64);
  for (int64_t j = 0; j < whole.size(0); ++j) {
    const int64_t parent = whole[j].item<int64_t>();
    if (parent < -1 || parent >= whole.size(0)) throw Error(subject, "a joint's parent does not exist");
    skeleton.parents.push_back(static_cast<int>(parent));
  }
  skeleton.offsets = as_float(npz.at("offsets", subject));
  skeleton.validate(subject);
  return skeleton;
}

/// The built-in skeleton with the bone lengths of joint positions (T, 22, 3): the median over the frames.
Skeleton measured_skeleton(const Tensor& joints) {
  Skeleton skeleton = builtin_body().skeleton;
  skeleton.offsets = skeleton.offsets.clone();
  for (int64_t j = 1; j < kStandardJoints; ++j) {
    const int64_t parent = skeleton.parents[static_cast<size_t>(j)];
    const Tensor length = std::get<0>((joints.select(1, j) - joints.select(1, parent)).norm(2, {1}).median(0));
    skeleton.offsets[j] *= length / skeleton.offsets[j].norm();
  }
  return skeleton;
}

/// What is annotated on the motion; shapes are checked by validate().
void read_annotations(const Npz& npz, Clip& clip) {
  auto strings = [&](const char* name) {
    const auto found = npz.strings.find(name);
    return found == npz.strings.end() ? std::vector<std::string>() : found->second.values;
  };
  clip.action_names = strings("action_names");
  clip.object_names = strings("object_names");
  if (npz.has("action") && !npz.tensors.at("action").is_floating_point())
    clip.action = npz.tensors.at("action").to(torch::kInt64);
  clip.contact = any_of(npz, {"contact"});
  clip.hand_targets = any_of(npz, {"hand_targets"});
  clip.object_pose = any_of(npz, {"object_pose"});
}

const Names kPoses = {"poses",  "pose",      "root_orient", "global_orient",
                      "orient", "pose_body", "body_pose",   "human_pose"};

/// Whether a file of others holds joint positions and no pose.
bool holds_positions(const Npz& npz) {
  if (npz.has("parents") && npz.has("offsets")) return false;
  if (!positions_called_poses(npz).empty()) return true;
  return first_of(npz, kPoses) == nullptr && !joint_array_name(npz).empty();
}

/// Arrays of npz_from_clip with a row a frame.
constexpr const char* kFrameArrays[] = {"trans",        "root_orient", "pose_body",   "poses",
                                        "joints",       "root_path",   "action",      "contact",
                                        "hand_targets", "object_pose", "translations"};

/// How many motions lie in the leading dimension of `joints`; -1 where there is no such dimension.
int64_t samples_of(const Npz& npz) {
  const auto joints = npz.tensors.find("joints");
  return joints != npz.tensors.end() && joints->second.dim() == 4 ? joints->second.size(0) : -1;
}

Clip own_clip(const Npz& npz, const std::string& subject, const ClipReadOptions& options, Notes* notes) {
  Clip clip;
  clip.skeleton = own_skeleton(npz, subject);
  const int64_t J = clip.skeleton.size();
  clip.rate = rate_of(npz, subject, options, notes);
  clip.gender = gender_of(npz);
  clip.betas = shape_of(npz, subject, notes);
  clip.source_body = text_of(npz, "source_body");
  clip.source_betas = any_of(npz, {"source_betas"});
  clip.trans = any_of(npz, {"trans"});
  clip.rotations = rotations_of(npz, {"poses"}, subject);
  if (!clip.rotations.defined()) {
    const Tensor root = rotations_of(npz, {"root_orient"}, subject);
    const Tensor body = rotations_of(npz, {"pose_body"}, subject);
    if (root.defined() && body.defined()) {
      if (root.size(0) != body.size(0)) throw Error(subject, "root_orient and pose_body differ in their frames");
      clip.rotations = torch::cat({root, body}, 1);
    }
  }
  if (clip.rotations.defined() && clip.rotations.size(1) != J)
    throw Error(subject, "a pose of " + std::to_string(clip.rotations.size(1)) + " joints on a skeleton of " +
                             std::to_string(J));
  clip.translations = any_of(npz, {"translations"});
  clip.joints = any_of(npz, {"joints"});
  if (!clip.joints.defined()) {
    if (!clip.rotations.defined() || !clip.trans.defined())
      throw Error(subject, "has neither joints nor both rotations and trans");
    if (clip.trans.dim() != 2 || clip.trans.size(1) != 3 || clip.trans.size(0) != clip.rotations.size(0))
      throw Error(subject, "trans has the wrong shape");
    if (clip.translations.defined() && clip.translations.sizes() != torch::IntArrayRef({clip.trans.size(0), J, 3}))
      throw Error(subject, "translations has the wrong shape");
    clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans, clip.translations);
  }
  read_annotations(npz, clip);
  validate(clip, subject);
  const std::string up = text_of(npz, "up");
  if (!up.empty() && up != "y" && up != "z") throw Error(subject, "its up is neither y nor z");
  clip.file.format = "npz";
  clip.file.z_up = up == "z";
  if (options.up != UpAxis::automatic) {
    check_told_up(mean_trunk(clip), options.up, subject, notes);
    clip.file.z_up = options.up == UpAxis::z;
  }
  if (clip.file.z_up) rotate_upright(clip);
  return clip;
}

/// Metres per unit of joint positions: of centimetres and millimetres where these are what a person is as high in.
double unit_of_person(const Tensor& joints, const std::vector<int>& parents, Notes* notes) {
  constexpr double kLeast = 0.5, kMost = 2.6;  // metres, from pelvis or root to the farthest leaf along the bones
  Skeleton bones;                              // of their mean lengths, in whatever direction
  bones.parents = parents;
  bones.offsets = torch::zeros({joints.size(1), 3});
  for (int64_t j = 1; j < joints.size(1); ++j)
    bones.offsets[j][1] = (joints.select(1, j) - joints.select(1, parents[static_cast<size_t>(j)])).norm(2, {1}).mean();
  const double reach = longest_reach(bones);
  for (const auto& [metres, name] : {std::pair(0.01, "centimetres"), std::pair(0.001, "millimetres")})
    if (reach > kMost && reach * metres > kLeast && reach * metres < kMost) {
      note(notes, std::string("lengths taken for ") + name + " by the size of the person");
      return metres;
    }
  return 1;
}

/// A file of positions alone: `joints` (T, 22+, 3), the first 22 in SMPL's order, or Human3.6M's 17 or 32.
Clip positions_clip(const Npz& npz, const std::string& subject, const ClipReadOptions& options, Notes* notes) {
  const Tensor joints = as_float(npz.at("joints", subject));
  if (joints.dim() != 3 || joints.size(2) != 3) throw Error(subject, "its joint positions are not (T, J, 3)");
  if (joints.size(0) == 0) throw Error(subject, "no frames");
  const bool human36m = in_human36m_order(joints);
  if (!human36m && joints.size(1) < kStandardJoints)
    throw Error(subject, "its joint positions are of " + std::to_string(joints.size(1)) +
                             " joints: without joint_names, parents and offsets SMPL's first 22 are needed, or "
                             "Human3.6M's 17 in their order");
  Clip clip;
  const double rate = rate_of(npz, subject, options, notes);
  if (human36m) {
    clip = human36m_clip(joints, rate, subject);
  } else {
    clip.rate = rate;
    clip.joints = joints.narrow(1, 0, kStandardJoints).contiguous();
    if (!torch::isfinite(clip.joints).all().item<bool>()) throw Error(subject, "joints has a value that is not finite");
    clip.skeleton.parents = standard_parents();
  }
  note(notes, human36m ? "joint positions without rotations, taken for Human3.6M's 17 joints"
                       : "joint positions without rotations, taken for SMPL's first 22 joints");
  clip.joints =
      clip.joints * (options.scale > 0 ? options.scale : unit_of_person(clip.joints, clip.skeleton.parents, notes));
  if (!human36m) clip.skeleton = measured_skeleton(clip.joints);
  clip.gender = gender_of(npz);
  read_annotations(npz, clip);
  validate(clip, subject);
  const std::optional<Eigen::Vector3d> trunk = mean_trunk(clip);
  check_told_up(trunk, options.up, subject, notes);
  const bool z_up = options.up == UpAxis::z || (options.up == UpAxis::automatic && trunk && trunk->z() > trunk->y());
  clip.file.format = "npz";
  clip.file.z_up = z_up;
  if (z_up) rotate_upright(clip);
  if (options.up == UpAxis::automatic)
    note(notes, z_up ? "+Z is up in the file (detected): rotated to +Y" : "+Y is up in the file (detected)");
  return clip;
}

Clip smpl_clip(const Npz& npz, const std::string& subject, const ClipReadOptions& options, Notes* notes) {
  const Tensor whole = rotations_of(npz, {"poses", "pose"}, subject);
  const Tensor root = rotations_of(npz, {"root_orient", "global_orient", "orient", "human_orient"}, subject);
  const Tensor body = rotations_of(npz, {"pose_body", "body_pose", "human_pose"}, subject);
  PoseParts parts;
  int64_t joints_in_file = 0;
  if (body.defined() || (root.defined() && !whole.defined())) {
    parts = join_parts(npz, root, body, subject);
    joints_in_file = body.size(1) + 1;
  } else if (whole.defined()) {
    joints_in_file = whole.size(1);
    const bool without_root = (joints_in_file == 21 || joints_in_file == 23) && root.defined() && root.size(1) == 1 &&
                              root.size(0) == whole.size(0);
    parts = split_pose(without_root ? torch::cat({root, whole.narrow(1, 0, 21)}, 1) : whole, subject);
  } else {
    throw Error(subject, "holds no motion: neither poses, nor root_orient and pose_body, nor joints");
  }
  const int64_t T = parts.body.size(0);
  if (T == 0) throw Error(subject, "no frames");
  if (!torch::isfinite(parts.body).all().item<bool>()) throw Error(subject, "the pose has a value that is not finite");

  Clip clip;
  clip.rate = rate_of(npz, subject, options, notes);
  clip.gender = gender_of(npz);
  const Tensor betas = shape_of(npz, subject, notes);
  clip.source_betas = betas;
  clip.source_body = family_of(text_of(npz, "surface_model_type"));
  if (clip.source_body.empty())
    clip.source_body = parts.face.defined() || joints_in_file == 55 ? "smplx" : joints_in_file == 24 ? "smpl" : "smplh";

  Tensor trans = any_of(npz, {"trans", "transl", "translation", "human_transl"});
  if (trans.defined() && trans.dim() == 3 && trans.size(1) == 1) trans = trans.squeeze(1);
  if (!trans.defined()) {
    trans = torch::zeros({T, 3});
    note(notes, "no translation in the file: the pelvis stays in place");
  }
  if (trans.sizes() != torch::IntArrayRef({T, 3})) throw Error(subject, "trans is not (T, 3) for the pose's frames");
  if (options.scale > 0) trans = trans * options.scale;
  if (options.body != nullptr) {
    const int64_t known = betas.defined() ? std::min(betas.size(0), options.body->betas()) : 0;
    clip.betas = known > 0 ? betas.narrow(0, 0, known) : Tensor();
    clip.skeleton = shaped_skeleton(*options.body, clip.betas);
    clip.rotations = pose_for(parts, clip.skeleton.size());
    clip.trans = trans;
  } else {
    clip.skeleton = builtin_body().skeleton;
    clip.rotations = parts.body.contiguous();
    clip.trans = trans + family_pelvis(clip.source_body) - clip.skeleton.offsets[0];
    if (parts.hands.defined()) note(notes, "finger and face joints are left out: the built-in body has none");
    if (betas.defined() && betas.ne(0).any().item<bool>())
      note(notes, "the body's shape belongs to " + clip.source_body + ": the built-in mean skeleton is used");
  }
  if (clip.rotations.size(1) != clip.skeleton.size())
    throw Error(subject, "the body model given is none of the SMPL family");
  read_annotations(npz, clip);
  const Tensor root_path = clip.trans + clip.skeleton.offsets[0];
  clip.file.format = "smpl";
  clip.file.z_up =
      pelvis_points_along_z(axis_angle_to_matrix(clip.rotations.select(1, 0)), root_path, subject, options, notes);
  if (clip.file.z_up) rotate_upright(clip);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  validate(clip, subject);
  return clip;
}

}  // namespace

bool holds_clip(const Npz& npz) { return first_of(npz, kPoses) != nullptr || !joint_array_name(npz).empty(); }

Clip clip_from_npz(const Npz& npz, const std::string& subject, const ClipReadOptions& options, Notes* notes) {
  const bool own = npz.has("parents") && npz.has("offsets");
  if (own && options.scale > 0)
    throw Error(subject, "was written by inhabit, in metres: a scale given by hand is for foreign files");
  if (own) return own_clip(npz, subject, options, notes);
  if (holds_positions(npz)) return positions_clip(with_joint_array(npz), subject, options, notes);
  return smpl_clip(npz, subject, options, notes);
}

Clip read_clip_npz(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  std::vector<Clip> clips = read_clips_npz(path, options, notes);
  if (clips.size() > 1) throw Error(path, "holds " + std::to_string(clips.size()) + " motions where one is wanted");
  return std::move(clips.front());
}

Npz npz_from_clip(const Clip& given, const std::string& subject) {
  validate(given, subject);
  Clip clip = given;
  Npz npz;
  const std::string& format = clip.file.format;
  if (format == "smpl" && clip.trans.defined() && !clip.betas.defined()) {  // trans as the family has it
    const Tensor root = clip.trans + clip.skeleton.offsets[0];
    clip.skeleton.offsets = clip.skeleton.offsets.clone();
    clip.skeleton.offsets[0].copy_(family_pelvis(clip.source_body));
    clip.trans = root - clip.skeleton.offsets[0];
    if (clip.translations.defined()) {
      clip.translations = clip.translations.clone();
      clip.translations.select(1, 0).copy_(clip.skeleton.offsets[0].expand({clip.frames(), 3}));
    }
  }
  if (clip.file.z_up && (format == "smpl" || format == "npz")) {
    rotate_z_up(clip);
    npz.strings["up"] = {{}, {"z"}};
  }
  auto put = [&](const char* name, const Tensor& t) {
    if (t.defined()) npz.tensors[name] = t;
  };
  auto put_names = [&](const char* name, const std::vector<std::string>& values) {
    if (!values.empty()) npz.strings[name] = {{static_cast<int64_t>(values.size())}, values};
  };
  const int64_t T = clip.frames(), J = clip.skeleton.size();
  put("mocap_framerate", torch::tensor(clip.rate, torch::kFloat64));
  npz.strings["gender"] = {{}, {clip.gender}};
  put("trans", clip.trans);
  put("translations", clip.translations);
  if (clip.rotations.defined()) {
    if (J == kStandardJoints) {
      put("root_orient", clip.rotations.select(1, 0));
      put("pose_body", clip.rotations.narrow(1, 1, J - 1).reshape({T, 3 * (J - 1)}));
    } else {
      put("poses", clip.rotations.reshape({T, 3 * J}));
    }
  }
  put("betas", clip.betas);
  put("joints", clip.joints);
  put("root_path", clip.root_path());
  put_names("joint_names", clip.skeleton.names);
  put("parents", torch::tensor(clip.skeleton.parents, torch::kInt32));
  put("offsets", clip.skeleton.offsets);
  put("action", clip.action);
  put_names("action_names", clip.action_names);
  put("contact", clip.contact);
  put("hand_targets", clip.hand_targets);
  put_names("object_names", clip.object_names);
  put("object_pose", clip.object_pose);
  if (!clip.source_body.empty()) npz.strings["source_body"] = {{}, {clip.source_body}};
  put("source_betas", clip.source_betas);
  return npz;
}

void write_clip_npz(const std::string& path, const Clip& clip) { write_npz(path, npz_from_clip(clip, path)); }

void write_clips_npz(const std::string& path, const std::vector<Clip>& clips,
                     const std::map<std::string, Tensor>& more) {
  if (clips.empty()) throw Error(path, "no motion to write");
  std::vector<Npz> each;
  each.reserve(clips.size());
  for (const Clip& clip : clips) each.push_back(npz_from_clip(clip, path));
  Npz all = each.front();
  for (const char* name : kFrameArrays) {
    if (!all.has(name)) continue;
    std::vector<Tensor> rows;
    for (const Npz& one : each) {
      if (!one.has(name) || one.tensors.at(name).sizes() != all.tensors.at(name).sizes())
        throw Error(path, std::string("motions written together differ in ") + name);
      rows.push_back(one.tensors.at(name));
    }
    all.tensors[name] = torch::stack(rows);
  }
  for (const auto& [name, tensor] : more)
    if (tensor.defined()) all.tensors[name] = tensor;
  write_npz(path, all);
}

std::vector<Clip> read_clips_npz(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  return clips_from_npz(read_npz(path), path, options, notes);
}

std::vector<Clip> clips_from_npz(const Npz& given, const std::string& subject, const ClipReadOptions& options,
                                 Notes* notes) {
  const Npz npz = holds_positions(given) ? with_joint_array(given) : given;
  if (samples_of(npz) < 0) return {clip_from_npz(npz, subject, options, notes)};
  std::vector<Clip> out;
  for (int64_t s = 0; s < samples_of(npz); ++s) {
    Npz one = npz;
    for (const char* name : kFrameArrays)
      if (npz.has(name)) {
        const Tensor& all = npz.tensors.at(name);
        if (all.dim() < 2 || all.size(0) != samples_of(npz))
          throw Error(subject, std::string(name) + " has not the sample dimension that joints has");
        one.tensors[name] = all[s];
      }
    out.push_back(clip_from_npz(one, subject, options, s == 0 ? notes : nullptr));
  }
  if (out.empty()) throw Error(subject, "holds no motion");
  return out;
}

}  // namespace inhabit
