#include "calls.h"
#include "inhabit/anticipate/intention_anticipator.h"
#include "results.h"

namespace inhabit::python {

using anticipate::IntentionAnticipator;
using Futures = anticipate::Result;

namespace {

IntentionsResult intentions_of(const Path& data, std::optional<int> labels, const py::object& settings, uint64_t seed,
                               const std::optional<Path>& compare, const py::object& progress) {
  anticipate::Config config;
  set_fields(config, settings_of(settings));
  if (labels) config.labels = *labels;
  validate(config, "settings");
  const Progress told = progress_of(progress);
  Notes notes;
  IntentionsResult out = {released([&] { return clustered_set(data.string(), config, seed, &notes, told); }), {}};
  say(notes);
  if (compare)
    out.agreement = released([&] {
      return anticipate::label_agreement(compare->string(), out.set.recordings, out.set.summary.tracks, out.set.rate);
    });
  return out;
}

void add_intentions(py::module_& m) {
  py::class_<IntentionsResult>(m, "Intentions", "What intentions() returns: intention labels of recordings.")
      .def_property_readonly(
          "labels",
          [](const IntentionsResult& r) {
            return python_of(summary_json(r.set.summary, r.set.recordings).at("labels").dump()).cast<py::list>();
          },
          "A dictionary of each label, as `inhabit intentions --json` has it: fraction of the frames, segments, their "
          "mean\n"
          "seconds, actions that it is seen in, and where it is seen best.")
      .def_property_readonly(
          "tracks",
          [](const IntentionsResult& r) {
            py::dict out;
            for (size_t i = 0; i < r.set.recordings.size(); ++i)
              out[py::str(shown_name(r.set.recordings[i]))] = array_of(r.set.summary.tracks[i].clone());
            return out;
          },
          "(T) int64 labels of every recording, `rate` a second, by its name.")
      .def_property_readonly(
          "rate", [](const IntentionsResult& r) { return r.set.rate; }, "Frames a second.")
      .def_property_readonly(
          "agreement",
          [](const IntentionsResult& r) -> std::optional<py::dict> {
            if (!r.agreement) return std::nullopt;
            const anticipate::LabelAgreement& a = *r.agreement;
            return py::dict("labels"_a = a.labels, "actions_and_other"_a = a.actions_and_other,
                            "actions_and_ours"_a = a.actions_and_ours, "recordings"_a = a.recordings,
                            "frames"_a = a.frames);
          },
          "Normalised mutual information, 0 to 1, with the labels of `compare`, a dictionary: labels (ours with "
          "theirs),\n"
          "actions_and_other, actions_and_ours (the actions' names with either), recordings and frames; None without.")
      .def("__str__", [](const IntentionsResult& r) { return summary_text(r.set.summary); });
  m.def("intentions", &intentions_of, "data"_a, py::kw_only(), "labels"_a = py::none(), "settings"_a = py::none(),
        "seed"_a = 1, "compare"_a = py::none(), "progress"_a = py::none(),
        "Clusters the intention labels of recordings, which page() shows.\n\n"
        "data: 'cmu:FOLDER', 'h36m:FOLDER' or a native data set's folder. labels: how many (8). settings: of the "
        "configuration,\n"
        "{'naive_clusters': True}. seed: of the clusters. compare: an .npz with labels of the same recordings by "
        "others, 120 a\n"
        "second. progress(done, all) is called after each recording.");
}

}  // namespace

void add_anticipate(py::module_& m) {
  add_intentions(m);
  py::class_<Futures>(m, "Futures", "What Anticipator.run returns: futures of one observation, in its world.")
      .def_readonly("past", &Futures::past, "What was observed, a Clip on the person's own bones.")
      .def_readonly("clips", &Futures::futures, "S Clips of T frames on the standard skeleton, at the model's rate.")
      .def_readonly("on_source", &Futures::on_source,
                    "The same on the clip's own skeleton, at its rate; empty where standard=True.")
      .def_property_readonly(
          "joints",
          [](const Futures& r) {
            std::vector<torch::Tensor> joints;
            for (const Clip& clip : r.futures) joints.push_back(clip.joints);
            return torch::stack(joints);
          },
          "(S, T, 22, 3) float32, metres: the joints of all futures (a copy).")
      .def_property_readonly(
          "labels", [](const Futures& r) { return r.labels; },
          "(S, T) int64 intentions, or None for a model without them.")
      .def_property_readonly(
          "labels_on_source", [](const Futures& r) { return r.labels_on_source; },
          "(S, T') int64 intentions of on_source, or None.")
      .def("__len__", [](const Futures& r) { return r.futures.size(); });

  py::class_<IntentionAnticipator, std::shared_ptr<IntentionAnticipator>>(
      m, "Anticipator",
      "Intention-driven anticipation: a motion in, many plausible futures of any length out.\n"
      "Safe to use from several threads.")
      .def(py::init([](const std::optional<Path>& model) {
             const std::string file = model_file(model, "anticipate-cmu.safetensors");
             return released([&] { return std::make_shared<IntentionAnticipator>(IntentionAnticipator::load(file)); });
           }),
           "model"_a = py::none(), "model: a model file; left out, the one that ships.")
      .def_property_readonly(
          "config", [](const IntentionAnticipator& a) { return python_of(to_json(a.config())).cast<py::dict>(); },
          "The model's configuration.")
      .def(
          "run",
          [](const IntentionAnticipator& anticipator, const Clip& clip, const std::optional<Scene>& scene,
             std::optional<int64_t> start, int64_t samples, double seconds, uint64_t seed, bool standard, bool solve,
             bool refine, const std::string& name) {
            const anticipate::Options options{start.value_or(-1), samples, seconds, seed, name,
                                              standard,           solve,   refine};
            return released([&, clip] { return anticipator.run(clip, scene.value_or(Scene()), options); });
          },
          "clip"_a, "scene"_a = py::none(), py::kw_only(), "start"_a = py::none(), "samples"_a = 10, "seconds"_a = 4.0,
          "seed"_a = 1, "standard"_a = false, "solve"_a = false, "refine"_a = false, "name"_a = "motion",
          "Observes up to two seconds before frame `start` of a clip (left out, or -1: its end) and draws `samples` "
          "futures "
          "of\n"
          "`seconds`. The networks see no scene: futures are steered around what stands in it.\n\n"
          "solve: joint rotations are found over all frames together, a second a future. refine: feet stand, and "
          "nobody\n"
          "is inside the scene, a second for each half minute of a future. standard: on_source is not wanted. name: "
          "what\n"
          "errors call the clip.");
}

}  // namespace inhabit::python
