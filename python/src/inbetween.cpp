#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/warnings.h"
#include "options.h"
#include "results.h"

namespace inhabit::python {
namespace {

using inbetween::Controls;
using inbetween::SceneInbetweener;

using JointContactArgument = std::tuple<std::string, double, double, std::array<double, 3>>;
using PathArgument = std::tuple<double, double, double>;

Controls controls_of(const std::vector<double>& weights, const std::vector<JointContactArgument>& contacts,
                     const std::vector<PathArgument>& path, bool loop, const Skeleton& file) {
  Controls out;
  out.key_weights = weights;
  for (const auto& [joint, from, to, place] : contacts) {
    try {
      out.contacts.push_back(inbetween::joint_contact(joint, from, to, {place[0], place[1], place[2]}, file));
    } catch (const Error& e) {
      throw Error("contacts", e.what());
    }
  }
  for (const auto& [seconds, x, z] : path) out.root_path.push_back({seconds, {x, z}});
  out.loop = loop;
  return out;
}

/// What the command says and warns of, as Python's notes and warnings.
void tell_of(const inbetween::Result& result, const std::vector<JointContactArgument>& contacts) {
  std::vector<std::string> names;
  for (size_t k = 0; k < contacts.size(); ++k)
    names.push_back("contacts[" + std::to_string(k) + "] ('" + std::get<0>(contacts[k]) + "')");
  for (const std::string& warning : inbetween::warnings_of(result, names))
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  say(inbetween::notes_of(result));
}

using Keys = std::variant<std::string, std::vector<int64_t>>;

std::vector<int64_t> keys_of(const Keys& keys, const Clip& clip, uint64_t seed) {
  if (const auto* text = std::get_if<std::string>(&keys))
    return inbetween::key_frames(*text, clip.frames(), seed, "keys");
  return std::get<std::vector<int64_t>>(keys);
}

constexpr const char* kInbetweenRun =
    "The motion between key frames of a clip on any skeleton that maps to the standard one, at any rate; what the "
    "clip\n"
    "holds elsewhere is not looked at.\n\n"
    "scene: left out, a flat floor under the feet is assumed.\n"
    "keys: frames of the clip, or 'every:N', '0,30,95', 'random:P' or 'ends'.\n"
    "joints: what keys between the ends constrain, such as 'pelvis,left_wrist' (default: whole poses).\n"
    "noise: level of noise on the keys between the ends, degrees and cm, which are cleaned (models that take it);\n"
    "    None: 0 or, of models for noisy keys, as all frames of the clip tell it.\n"
    "steps: evaluations of the denoiser, 0: the model's own; sampler: 'dpm', 'ddim' or 'ddpm'; seed of the noise.\n"
    "samples: so many motions, with seeds from `seed` on: `samples` of the result.\n"
    "temperature: how much of the motion's course is left to the seed, 0 the likeliest course, 1 any that people "
    "take;\n"
    "left out, 0, of several samples 1.\n"
    "key_weights: one a key, 1 at the ends: 1 meets the pose, 0 leaves it out.\n"
    "contacts: list of (joint, from, to, (x, y, z)): this joint, by its standard name or the one in the clip's "
    "skeleton, or\n"
    "'left_hand' or 'right_hand', is at this place (metres) between these seconds after the first key; of a target "
    "that "
    "is\n"
    "gone through both are the same. Contacts that nobody reaches, key poses inside the scene and keys that no path "
    "leads "
    "to\n"
    "are warned of (warnings.warn).\n"
    "root_path: list of (seconds, x, z) that the root goes through; loop: the last pose is the first again.\n"
    "refine: feet stand, nobody is inside the scene; detours: around what stands between keys: 'learned'\n"
    "(PathNet's paths), 'searched' (A*'s) or 'straight'; collisions: `collides` is found; progress(done, all) is "
    "called after evaluations.\n"
    "standard: on_source is not wanted. name: what errors call the clip.";

}  // namespace

void add_inbetween(py::module_& m) {
  py::class_<Immersion>(m, "Immersion", "What of a scene a body is deepest in.")
      .def_readonly("frame", &Immersion::frame, "Of the motion.")
      .def_readonly("depth", &Immersion::depth, "Metres that the deepest place of the skin is inside; 0: none is.")
      .def_readonly("object", &Immersion::object, "Name of the object.")
      .def("__repr__", [](const Immersion& i) {
        return "<inhabit.Immersion: frame " + std::to_string(i.frame) + (i.depth > 0 ? ", " + i.text() : "") + ">";
      });
  py::class_<InbetweenResult>(m, "InbetweenResult", "What Inbetweener.run returns.")
      .def_property_readonly(
          "clip", [](const InbetweenResult& r) { return r.result.motion; },
          "The motion, a Clip on the standard skeleton at the model's rate, from the first key frame to the last.")
      .def_property_readonly(
          "on_source", [](const InbetweenResult& r) { return r.result.on_source; },
          "The same on the clip's own skeleton, at its rate, key poses bit by bit; empty where standard=True.")
      .def_property_readonly(
          "keys", [](const InbetweenResult& r) { return r.result.keys; }, "Key frames of `clip`.")
      .def_property_readonly(
          "key_poses", [](const InbetweenResult& r) { return r.result.key_poses; },
          "The poses asked for there, a Clip of a frame each.")
      .def_property_readonly(
          "scene", [](const InbetweenResult& r) { return r.result.scene; },
          "What was looked at: the scene given, or an assumed flat floor.")
      .def_property_readonly(
          "floor_assumed", [](const InbetweenResult& r) { return r.result.floor_assumed; },
          "Whether a flat floor was assumed.")
      .def_property_readonly(
          "unreached", [](const InbetweenResult& r) { return r.result.unreached; },
          "Frames of `keys` that no path around what blocks the straight line leads to in time.")
      .def_property_readonly(
          "key_collides", [](const InbetweenResult& r) { return r.result.key_collides; },
          "(K) bool: the key pose is inside the scene.")
      .def_property_readonly(
          "key_immersions", [](const InbetweenResult& r) { return r.result.key_immersions; },
          "What each key pose that is inside the scene is deepest in: a list of Immersion, of frames in `keys`.")
      .def_property_readonly(
          "contact_gaps", [](const InbetweenResult& r) { return r.result.contact_gaps; },
          "Metres that each contact is missed by, at most.")
      .def_property_readonly(
          "collides", [](const InbetweenResult& r) { return r.result.collides; },
          "(T) bool: the motion is inside the scene; None unless collisions=True.")
      .def_property_readonly("samples", &samples_of<InbetweenResult>,
                             "All motions that were asked for, of which this is the first: a list for page().");

  py::class_<SceneInbetweener>(
      m, "Inbetweener",
      "Scene-aware motion in-betweening: key frames and a room in, motion that respects both out.\n"
      "Safe to use from several threads.")
      .def(
          py::init([](const std::optional<Path>& model, bool noisy) {
            const std::string file =
                model_file(model, noisy ? "inbetween-noisy.safetensors" : "inbetween-compact.safetensors");
            auto out = released([&] { return std::make_unique<SceneInbetweener>(SceneInbetweener::load(file)); });
            if (noisy) inbetween::require_noise_aware(out->config(), file);
            return out;
          }),
          "model"_a = py::none(), py::kw_only(), "noisy"_a = false,
          "model: a model file; left out, the one that ships. noisy: key frames are noisy and are cleaned, but for the "
          "ends.")
      .def_property_readonly(
          "config", [](const SceneInbetweener& i) { return python_of(to_json(i.config())).cast<py::dict>(); },
          "The model's configuration.")
      .def(
          "run",
          [](const SceneInbetweener& inbetweener, const Clip& clip, const std::optional<Scene>& scene, const Keys& keys,
             const std::string& joints, std::optional<double> noise, int64_t steps, const std::string& sampler,
             uint64_t seed, int64_t samples, std::optional<double> temperature, const std::vector<double>& key_weights,
             const std::vector<JointContactArgument>& contacts, const std::vector<PathArgument>& root_path, bool loop,
             bool refine, const std::string& detours, bool collisions, const py::object& progress, bool standard,
             const std::string& name) {
            inbetween::Options options;
            options.keys = keys_of(keys, clip, seed);
            if (!joints.empty()) options.key_groups = inbetween::key_groups(joints, clip.skeleton);
            options.noise = noise;
            options.steps = steps;
            options.sampler = named("sampler", sampler, inbetween::samplers_by_name());
            options.seed = seed;
            options.temperature = temperature;
            options.controls = controls_of(key_weights, contacts, root_path, loop, clip.skeleton);
            options.refine = refine;
            options.detours = inbetween::detours_named(detours);
            options.collisions = collisions;
            options.name = name;
            options.standard = standard;
            options.progress = progress_of(progress);
            std::vector<inbetween::Result> made = released(
                [&, clip] { return inbetweener.run_samples(clip, scene.value_or(Scene()), options, samples); });
            tell_of(made.front(), contacts);
            std::vector<InbetweenResult> all;
            for (inbetween::Result& one : made) {
              const bool cleaned = one.noise > 0 || inbetweener.config().t_star > 0;
              all.push_back({std::move(one), cleaned, options.key_groups, {}});
            }
            return first_of(std::move(all));
          },
          "clip"_a, "scene"_a = py::none(), py::kw_only(), "keys"_a = "ends", "joints"_a = "", "noise"_a = py::none(),
          "steps"_a = 0, "sampler"_a = "dpm", "seed"_a = 1, "samples"_a = 1, "temperature"_a = py::none(),
          "key_weights"_a = std::vector<double>(), "contacts"_a = std::vector<JointContactArgument>(),
          "root_path"_a = std::vector<PathArgument>(), "loop"_a = false, "refine"_a = true, "detours"_a = "learned",
          "collisions"_a = false, "progress"_a = py::none(), "standard"_a = false, "name"_a = "motion", kInbetweenRun);
  m.def(
      "poses_at_times",
      [](const std::vector<Clip>& poses, const std::vector<double>& seconds, double rate) {
        std::vector<std::string> names;
        for (size_t i = 0; i < poses.size(); ++i) names.push_back("pose " + std::to_string(i));
        inbetween::PosesInTime made = inbetween::poses_at_times(poses, seconds, rate, names);
        return std::pair(std::move(made.clip), std::move(made.keys));
      },
      "poses"_a, "seconds"_a, "rate"_a = 30.0,
      "The first frames of clips at given times, as a Clip and the key frames of it: what Inbetweener.run takes.\n"
      "rate: frames a second where the clips have less than 12.");
}

}  // namespace inhabit::python
