#include "inhabit/reconstruct/reconstruct.h"

#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/reconstruct/input_files.h"

namespace inhabit::python {
namespace {

using reconstruct::PlacedObject;
using reconstruct::Result;
using Patterns = std::variant<std::string, std::vector<Path>>;

std::vector<std::string> patterns_of(const Patterns& given) {
  if (const auto* one = std::get_if<std::string>(&given)) return {*one};
  return texts_of(std::get<std::vector<Path>>(given));
}

std::string text_or_none(const std::optional<Path>& path) { return path ? path->string() : std::string(); }

inbetween::SceneInbetweener noise_aware(const std::optional<Path>& model) {
  const std::string file = model_file(model, "inbetween-noisy.safetensors");
  auto out = inbetween::SceneInbetweener::load(file);
  inbetween::require_noise_aware(out.config(), file);
  return out;
}

constexpr const char* kReconstruct =
    "A person's motion and the room around them, in metres, from what your own networks made of a video "
    "(docs/reconstruction.md).\n\n"
    "motion: file of the person's estimated motion, a frame for each of the video. camera: camera file (.json).\n"
    "depth: numbered depth maps (.npy), a pattern such as 'depth_*.npy' or a list of files; masks: where the person is "
    "(.png),\n"
    "numbered alike. objects: folder with a mesh of each object; object_masks: folder with NAME_NUMBER.png.\n"
    "body: the Body that was seen, from read_body (left out: the built-in one). rate: frames a second of the motion.\n"
    "model: a noise-aware in-betweening model. key_step: frames (30 a second) between key frames whose root is moved;\n"
    "keep_every: of these, every so many are keys of in-betweening. uncertainty: several maps of a frame: a depth "
    "counts "
    "where\n"
    "their deviation is at most this part of the frame's spread. floor_scale: the floor tells the depth's scale, too.\n"
    "steps: evaluations of the denoiser, 0: the model's own. collisions: `collides` is found. progress(done, all) is "
    "called\n"
    "after depth maps.";

}  // namespace

void add_reconstruct(py::module_& m) {
  py::class_<PlacedObject>(m, "PlacedObject", "An object where it was found.")
      .def_readonly("name", &PlacedObject::name, "Name of its mesh.")
      .def_property_readonly(
          "scale", [](const PlacedObject& o) { return o.placement.scale; }, "Times the size of its mesh.")
      .def_property_readonly(
          "yaw", [](const PlacedObject& o) { return o.placement.yaw; }, "Radians about the vertical.")
      .def_property_readonly(
          "shift",
          [](const PlacedObject& o) {
            const auto& s = o.placement.shift;
            return std::array<double, 3>{s.x(), s.y(), s.z()};
          },
          "(x, y, z) metres.")
      .def_readonly("distance", &PlacedObject::distance, "Metres, median, of what was seen of it from its surface.");
  py::class_<Result>(m, "ReconstructResult", "What reconstruct returns.")
      .def_readonly("clip", &Result::motion, "The motion, a Clip on the standard skeleton at 30 frames a second.")
      .def_readonly("on_source", &Result::on_source, "The same on the motion's own skeleton at its rate.")
      .def_readonly("before", &Result::before, "The estimate on the standard skeleton, in the same world.")
      .def_readonly("keys", &Result::keys, "Frames of `clip` that it was made between.")
      .def_readonly("scene", &Result::scene, "The Scene: floor and objects as meshes, all else as points.")
      .def_readonly("objects", &Result::objects, "A PlacedObject for each object.")
      .def_property_readonly(
          "depth_scale", [](const Result& r) { return r.depth.scale.scale; }, "Depth is depth_scale times the maps'")
      .def_property_readonly(
          "depth_offset", [](const Result& r) { return r.depth.scale.offset; }, "plus so many metres.")
      .def_readonly("floor", &Result::floor, "Metres, height.")
      .def_readonly("moved", &Result::moved, "Metres, mean, that key frames' roots were moved.")
      .def_readonly("collides", &Result::collides, "(T) bool: `clip` is inside an object; None unless collisions=True.")
      .def_readonly("notes", &Result::notes, "What the user should know.");
  m.def(
      "reconstruct",
      [](const Path& motion, const Path& camera, const Patterns& depth, const Patterns& masks,
         const std::optional<Path>& objects, const std::optional<Path>& object_masks, const BodyModel* body,
         std::optional<double> rate, const std::optional<Path>& model, int64_t key_step, int64_t keep_every,
         double uncertainty, bool floor_scale, int64_t steps, uint64_t seed, bool collisions,
         const py::object& progress) {
        reconstruct::Options options;
        if (key_step < 1) throw Error("key_step", "is under 1");
        if (keep_every < 1) throw Error("keep_every", "is under 1");
        options.key_step = key_step;
        options.keep_every = keep_every;
        options.uncertainty = uncertainty;
        options.floor_scale = floor_scale;
        options.steps = steps;
        options.seed = seed;
        options.collisions = collisions;
        options.name = motion.string();
        options.progress = progress_of(progress);
        ClipReadOptions reading = reading_of("y", {}, rate, {});
        reading.body = options.body = body;
        Notes notes;
        const auto inputs =
            reconstruct::open_inputs({motion.string(), camera.string(), patterns_of(depth), patterns_of(masks),
                                      text_or_none(objects), text_or_none(object_masks)},
                                     reading, &notes);
        say(notes);
        return released([&] { return reconstruct::run(inputs, noise_aware(model), options); });
      },
      "motion"_a, "camera"_a, "depth"_a, "masks"_a, py::kw_only(), "objects"_a = py::none(),
      "object_masks"_a = py::none(), "body"_a = py::none(), "rate"_a = py::none(), "model"_a = py::none(),
      "key_step"_a = 5, "keep_every"_a = 3, "uncertainty"_a = 0.05, "floor_scale"_a = true, "steps"_a = 0, "seed"_a = 1,
      "collisions"_a = false, "progress"_a = py::none(), kReconstruct);
}

}  // namespace inhabit::python
