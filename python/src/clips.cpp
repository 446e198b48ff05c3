#include <pybind11/stl.h>

#include <algorithm>

#include "calls.h"
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/clip.h"

namespace inhabit::python {
namespace {

using torch::Tensor;

Skeleton make_skeleton(std::vector<std::string> names, std::vector<int> parents, const Floats& offsets) {
  Skeleton out{std::move(names), std::move(parents), offsets};
  out.validate("skeleton");
  return out;
}

Clip make_clip(const std::optional<Floats>& joints, double rate, const std::optional<Skeleton>& skeleton,
               const std::optional<Floats>& rotations, const std::optional<Floats>& trans,
               const std::optional<Floats>& betas, const std::string& gender) {
  Clip out;
  out.skeleton = skeleton ? *skeleton : builtin_body().skeleton;
  out.rate = rate;
  if (rotations) out.rotations = *rotations;
  if (trans) out.trans = *trans;
  if (betas) out.betas = *betas;
  out.gender = gender;
  if (betas && !skeleton) out.skeleton = shaped_skeleton(builtin_body(), out.betas);
  if (joints) {
    out.joints = *joints;
  } else {
    if (!rotations || !trans) throw Error("clip", "needs joints, or rotations and trans");
    const int64_t count = out.skeleton.size();
    if (rotations->dim() != 3 || rotations->size(1) != count || rotations->size(2) != 3 || trans->dim() != 2 ||
        trans->size(1) != 3 || trans->size(0) != rotations->size(0))
      throw Error("clip", "rotations are not (T, " + std::to_string(count) + ", 3) or trans not (T, 3)");
    out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
  }
  validate(out, "clip");
  return out;
}

void as_set(Clip&) {}

/// Positions that were set say nothing of rotations: those that were there would put the joints elsewhere.
void positions_alone(Clip& clip) { clip.rotations = clip.trans = clip.translations = Tensor(); }

/// Joints where rotations and trans, one of which was set, put them.
void pose_joints(Clip& clip) {
  if (!clip.rotations.defined() || !clip.trans.defined()) return;
  validate(clip, "clip");
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans, clip.translations);
}

/// A property over one of a clip's arrays. Setting it brings along what depends on it, and checks the clip.
template <class Array, Tensor Clip::*kField, void (*kAfter)(Clip&) = as_set>
void add_array(py::class_<Clip>& clip, const char* name, const char* doc) {
  clip.def_property(
      name, [](const Clip& c) -> Tensor { return c.*kField; },
      [](Clip& c, const std::optional<Array>& array) {
        Clip changed = c;
        changed.*kField = array ? Tensor(*array) : Tensor();
        kAfter(changed);
        validate(changed, "clip");
        c = std::move(changed);
      },
      doc);
}

template <class Value, Value Clip::*kField, void (*kAfter)(Clip&) = as_set>
void add_value(py::class_<Clip>& clip, const char* name, const char* doc) {
  clip.def_property(
      name, [](const Clip& c) { return c.*kField; },
      [](Clip& c, const Value& value) {
        Clip changed = c;
        changed.*kField = value;
        kAfter(changed);
        validate(changed, "clip");
        c = std::move(changed);
      },
      doc);
}

Clip frames_of(const Clip& clip, const py::slice& frames) {
  py::ssize_t first = 0, last = 0, step = 0, count = 0;
  if (!frames.compute(clip.frames(), &first, &last, &step, &count)) throw py::error_already_set();
  if (step != 1) throw Error("clip", "frames are taken one after the other: see resample");
  if (count == 0) throw Error("clip", "no frame is left");
  return slice(clip, first, first + count);
}

std::string text_of_clip(const Clip& clip) {
  return "<inhabit.Clip: " + std::to_string(clip.frames()) + " frames at " +
         py::str(py::float_(clip.rate)).cast<std::string>() + " Hz, " + std::to_string(clip.skeleton.size()) +
         " joints" + (clip.rotations.defined() ? "" : ", positions alone") + ">";
}

}  // namespace

void add_clips(py::module_& m) {
  py::class_<Skeleton>(m, "Skeleton",
                       "A tree of joints at rest; parents come before their children, joint 0 is the root.")
      .def(
          py::init(&make_skeleton), "names"_a, "parents"_a, "offsets"_a,
          "names: J names; parents: J indices, -1 for the root; offsets: (J, 3) metres, rest position relative to the\n"
          "parent (row 0: the root's rest position).")
      .def_readonly("names", &Skeleton::names, "J names.")
      .def_readonly("parents", &Skeleton::parents, "J indices of parents, -1 for the root.")
      .def_property_readonly(
          "offsets", [](const Skeleton& s) { return s.offsets.clone(); },
          "(J, 3) float32, metres: rest position relative to the parent. A copy: clips share their skeletons.")
      .def_property_readonly(
          "rest_joints", [](const Skeleton& s) { return s.rest_joints(); },
          "(J, 3) float32, metres: rest positions in the root's frame.")
      .def("find", &Skeleton::find, "name"_a, "Index of a joint, or -1.")
      .def("__len__", &Skeleton::size)
      .def("__repr__", [](const Skeleton& s) { return "<inhabit.Skeleton: " + std::to_string(s.size()) + " joints>"; });
  m.def(
      "standard_skeleton",
      [](const std::optional<Floats>& betas) {
        return shaped_skeleton(builtin_body(), betas ? Tensor(*betas) : Tensor());
      },
      "betas"_a = py::none(),
      "The 22 standard joints (SMPL's first) with the built-in body's bones, of shape `betas` (B), or the mean one.");

  py::class_<Clip> clip(
      m, "Clip",
      "One person's motion and what is annotated on it. Metres, seconds, radians, +Y up, the person faces\n"
      "+Z at rest. Arrays are views of the clip's memory; those that are not known are None.");
  clip.def(
      py::init(&make_clip), "joints"_a = py::none(), "rate"_a = 30.0, py::kw_only(), "skeleton"_a = py::none(),
      "rotations"_a = py::none(), "trans"_a = py::none(), "betas"_a = py::none(), "gender"_a = "neutral",
      "joints: (T, J, 3) metres, world; left out, forward kinematics of rotations (T, J, 3) and trans (T, 3) gives\n"
      "them. rate: frames a second. skeleton: left out, the standard 22 joints (of shape `betas`, where given).\n"
      "float32 arrays are not copied.");
  clip.def_property_readonly(
      "frames", [](const Clip& c) { return c.frames(); }, "T, number of frames.");
  clip.def_property_readonly(
      "seconds", [](const Clip& c) { return c.seconds(); }, "Length, seconds.");
  add_value<double, &Clip::rate>(clip, "rate", "Frames a second.");
  add_value<Skeleton, &Clip::skeleton, pose_joints>(clip, "skeleton", "The joints' tree at rest.");
  add_array<Floats, &Clip::joints, positions_alone>(
      clip, "joints", "(T, J, 3) float32, metres, world. Set, rotations, trans and translations are None.");
  add_array<Floats, &Clip::rotations, pose_joints>(
      clip, "rotations",
      "(T, J, 3) float32, axis-angle radians, each joint relative to its parent; row 0 is the root's;\n"
      "or None. Set, with trans, the joints follow.");
  add_array<Floats, &Clip::trans, pose_joints>(
      clip, "trans",
      "(T, 3) float32, metres: root joint = trans + skeleton.offsets[0] (SMPL's convention), or None. Set, with\n"
      "rotations, the joints follow.");
  add_array<Floats, &Clip::translations, pose_joints>(
      clip, "translations", "(T, J, 3) float32, metres, in place of skeleton.offsets where joints translate, or None.");
  add_array<Floats, &Clip::betas>(clip, "betas", "(B) float32, body shape, or None.");
  add_value<std::string, &Clip::gender>(clip, "gender", "'neutral', 'female' or 'male'.");
  clip.def_property_readonly(
      "source_body", [](const Clip& c) { return c.source_body; },
      "Body model of the file it came from ('smplx'), empty for the built-in body.");
  clip.def_readwrite("action_names", &Clip::action_names, "Labels that `action` indexes.");
  add_array<Longs, &Clip::action>(clip, "action", "(T) int64, indices into action_names, or None.");
  add_array<Floats, &Clip::contact>(clip, "contact",
                                    "(T, J) float32, 1 where the joint's skin touches the scene, or None.");
  add_array<Floats, &Clip::hand_targets>(
      clip, "hand_targets",
      "(T, 2, 4) float32, left and right: x y z metres of the touched point, then 1, or 0; or None.");
  clip.def_property_readonly(
      "object_names", [](const Clip& c) { return c.object_names; }, "Objects that object_pose places.");
  clip.def_property_readonly(
      "object_pose", [](const Clip& c) { return c.object_pose; },
      "(T, O, 6) float32, world translation metres, then axis-angle radians, or None.");
  clip.def(
      "set_objects",
      [](Clip& c, std::vector<std::string> names, const Floats& pose) {
        Clip changed = c;
        changed.object_names = std::move(names);
        changed.object_pose = pose;
        validate(changed, "clip");
        c = std::move(changed);
      },
      "names"_a, "pose"_a, "Sets object_names (O) and object_pose (T, O, 6) together.");
  clip.def(
      "copy",
      [](const Clip& c) {
        Clip out = c;
        for (Tensor* t : {&out.joints, &out.rotations, &out.trans, &out.translations, &out.betas, &out.source_betas,
                          &out.action, &out.contact, &out.hand_targets, &out.object_pose, &out.skeleton.offsets})
          if (t->defined()) *t = t->clone();
        return out;
      },
      "The same clip with memory of its own.");
  clip.def("__len__", [](const Clip& c) { return c.frames(); });
  clip.def("__getitem__", &frames_of, "frames"_a, "Frames first:last with every annotation, as views.");
  clip.def("__repr__", &text_of_clip);
  clip.def(py::pickle([](const Clip& c) { return py::bytes(npz_bytes(npz_from_clip(c, "clip"))); },
                      [](const py::bytes& bytes) {
                        return clip_from_npz(parse_npz(std::string_view(bytes), "pickled clip"), "pickled clip");
                      }));
}

}  // namespace inhabit::python
