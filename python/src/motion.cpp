#include "calls.h"
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/mirror.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace inhabit::python {
namespace {

/// The same body with arrays of its own.
BodyModel copy_of(BodyModel body) {
  for (torch::Tensor* t : {&body.template_vertices, &body.skin_weights, &body.faces, &body.joint_limits})
    *t = t->clone();
  return body;
}

}  // namespace

void add_motion(py::module_& m) {
  m.def(
      "retarget",
      [](const Clip& clip, const std::string& name) { return released([&, clip] { return retarget(clip, name); }); },
      "clip"_a, "name"_a = "motion",
      "The motion on the standard 22 joints, from any skeleton whose joints inhabit knows. `name` is what errors call "
      "it.");
  m.def(
      "resample",
      [](const Clip& clip, double rate, const std::string& name) {
        return released([&, clip] { return resample(clip, rate, name); });
      },
      "clip"_a, "rate"_a, "name"_a = "motion",
      "The clip at another frame rate (Hz): rotations by slerp, the root by cubic splines, labels of the nearest "
      "frame.");
  m.def(
      "mirrored",
      [](const Clip& clip) {
        if (clip.skeleton.names != standard_joint_names())
          throw Error("clip", "is not on the standard skeleton: retarget it");
        return mirrored(clip);
      },
      "clip"_a, "The image of a clip of the standard skeleton in the plane x = 0: left and right change places.");
  m.def(
      "forward_kinematics",
      [](const Skeleton& skeleton, const Floats& rotations, const Floats& trans) {
        const int64_t joints = skeleton.size();
        if (rotations.dim() != 3 || rotations.size(1) != joints || rotations.size(2) != 3)
          throw Error("rotations", "are not (T, " + std::to_string(joints) + ", 3)");
        if (trans.dim() != 2 || trans.size(1) != 3 || trans.size(0) != rotations.size(0))
          throw Error("trans", "is not (T, 3)");
        return released([&] { return joint_positions(skeleton, rotations, trans); });
      },
      "skeleton"_a, "rotations"_a, "trans"_a,
      "Joint positions (T, J, 3), metres, of axis-angle rotations (T, J, 3), radians, and trans (T, 3), metres.");

  py::class_<BodyModel>(m, "Body", "A skinned body with linear shape space.")
      .def(py::init([](const std::optional<Path>& path) {
             if (!path) return copy_of(builtin_body());  // who writes into it changes no other
             return released([&] { return read_smpl_model(path->string()); });
           }),
           "path"_a = py::none(),
           "The body that ships with inhabit, or that of an SMPL, SMPL-H or SMPL-X model file (.npz).")
      .def_readonly("name", &BodyModel::name, "'inhabit', 'smpl', 'smplh' or 'smplx'.")
      .def_readonly("skeleton", &BodyModel::skeleton, "Of the mean shape; the first 22 joints are the standard ones.")
      .def_property_readonly(
          "faces", [](const BodyModel& body) { return body.faces; },
          "(F, 3) int64, counter-clockwise seen from outside.")
      .def_property_readonly(
          "template_vertices", [](const BodyModel& body) { return body.template_vertices; },
          "(V, 3) float32, metres: the mean shape at rest.")
      .def_property_readonly(
          "skin_weights", [](const BodyModel& body) { return body.skin_weights; }, "(V, J) float32, rows sum to 1.")
      .def_property_readonly(
          "joint_limits", [](const BodyModel& body) { return body.joint_limits; },
          "(J, 3, 2) float32, radians: lowest and highest of each axis-angle component.")
      .def(
          "skin",
          [](const BodyModel& body, const Clip& clip) {
            if (!clip.rotations.defined()) throw Error("clip", "has no rotations to pose a body by: retarget it");
            if (clip.skeleton.size() != body.joints())
              throw Error("clip", "has " + std::to_string(clip.skeleton.size()) + " joints, the body " +
                                      std::to_string(body.joints()));
            return released([&, clip] { return skin_points(clip, body); });
          },
          "clip"_a, "The skin's vertices (T, V, 3), metres, in the poses of a clip on the body's joints.")
      .def("__repr__", [](const BodyModel& body) {
        return "<inhabit.Body '" + body.name + "': " + std::to_string(body.joints()) + " joints, " +
               std::to_string(body.template_vertices.size(0)) + " vertices>";
      });
}

}  // namespace inhabit::python
