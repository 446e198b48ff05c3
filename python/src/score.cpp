#include <algorithm>

#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/score_features.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/metrics/frechet.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/metrics/score_clips.h"
#include "inhabit/metrics/score_json.h"
#include "inhabit/metrics/score_motions.h"
#include "inhabit/motion/retarget.h"
#include "options.h"

namespace inhabit::python {
namespace {

using Clips = std::vector<Clip>;

/// Motions on the standard skeleton at the score's rate.
std::vector<ScoredClip> scored(const Clips& clips, double rate, const std::string& what, int64_t least = 1) {
  if (clips.empty()) throw Error(what, "holds no clip");
  std::vector<ScoredClip> out;
  for (size_t i = 0; i < clips.size(); ++i)
    out.push_back(scored_clip(clips[i], rate, least, what + " " + std::to_string(i)));
  return out;
}

std::vector<NamedMotion> standard_motions(const Clips& clips, double rate, const std::string& what) {
  return joints_of(scored(clips, rate, what));
}

/// (N, 64) of all windows of the clips, by the network that ships.
torch::Tensor features_of(const Clips& clips, const std::string& what) {
  static const auto network = inbetween::load_motion_autoencoder(inhabit::shipped_model("motion-features.safetensors"));
  const torch::NoGradGuard no_gradients;
  return inbetween::features_of(over_floors(scored(clips, 30, what, inbetween::kFeatureFrames)), network);
}

/// The clip as scores of poses want it: on the standard skeleton with rotations.
Clip posed(const Clip& clip) {
  const bool standard =
      clip.skeleton.names == standard_joint_names() && clip.rotations.defined() && clip.trans.defined();
  return standard ? clip : retarget(clip, "clip");
}

py::dict ndms_of(const Clips& motions, const Clips& reference, double rate, int64_t kappa, int64_t observed,
                 const std::string& words) {
  if (kappa < 2) throw Error("kappa", "is under 2");
  if (observed < 0) throw Error("observed", "is under 0");
  NdmsOptions options;
  options.rate = rate;
  options.kappa = kappa;
  options.observed = observed;
  options.words = named("words", words, word_kinds_by_name());
  const NdmsScore score = released([&] {
    return score_ndms(scored(motions, rate, "motion", std::max(kappa, observed + 1)),
                      scored(reference, rate * static_cast<double>(options.reference_stride), "reference"), options);
  });
  py::list by_motion;
  for (const NdmsOfMotion& of : score.motions)
    by_motion.append(
        py::dict("ndms"_a = of.ndms, "coded"_a = of.coded, "words"_a = of.words, "by_second"_a = of.by_second));
  return py::dict("ndms"_a = score.ndms, "coded"_a = score.coded, "words"_a = score.words,
                  "reference_words"_a = score.reference_words, "motions"_a = by_motion);
}

/// What `score()` gives as JSON, a dictionary.
template <class Work>
py::dict scored_dict(const Work& score) {
  const std::string facts = released([&] {
    const torch::NoGradGuard no_gradients;
    return score().dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  });
  return python_of(facts).template cast<py::dict>();
}

py::dict skating_of(const Clips& motions, const std::optional<Scene>& scene, double rate) {
  return scored_dict([&] {
    const auto clips = over_floors(scored(motions, rate, "motion", 2), scene.value_or(Scene()));
    return score_json(score_skating(clips), clips);
  });
}

py::dict jerk_of(const Clips& motions, const Clips& reference, double rate) {
  return scored_dict([&] {
    const auto clips = scored(motions, rate, "motion", 4);
    const JerkScore score = score_jerk(clips);
    if (reference.empty()) return score_json(score, clips);
    const JerkScore real = score_jerk(scored(reference, rate, "reference", 4));
    return score_json(score, clips, &real);
  });
}

py::dict penetration_of(const Clips& motions, const Scene& scene, double rate) {
  if (scene.meshes.empty()) throw Error("scene", "has no meshes: where a body is inside it cannot be told");
  return scored_dict([&] {
    const auto clips = scored(motions, rate, "motion");
    return score_json(score_penetration(clips, scene), clips);
  });
}

py::dict collisions_of(const Clip& clip, const Scene& scene) {
  struct Found {
    Collision collision;
    Penetration deepest;
  };
  const Found found = released([&] {
    const Clip motion = posed(clip);
    return Found{CollisionMeter(builtin_body(), scene).measure(motion),
                 deepest_penetration(motion, builtin_body(), scene)};
  });
  return py::dict("depth"_a = array_of(found.collision.depth), "vertices"_a = array_of(found.collision.vertices),
                  "frame_ratio"_a = found.collision.frame_ratio(), "deepest"_a = found.deepest.depth,
                  "deepest_frame"_a = found.deepest.frame,
                  "deepest_joint"_a = found.deepest.joint < 0
                                          ? std::string()
                                          : standard_joint_names().at(static_cast<size_t>(found.deepest.joint)),
                  "deepest_object"_a = found.deepest.object);
}

}  // namespace

void add_score(py::module_& m) {
  m.def("score_ndms", &ndms_of, "motions"_a, "reference"_a, py::kw_only(), "rate"_a = 25.0, "kappa"_a = 8,
        "observed"_a = 0, "words"_a = "poses",
        "Normalised directional motion similarity (Eq. 10-12 of the anticipation paper) of clips with real ones: 1 is "
        "motion\n"
        "that people make. A dictionary of ndms, coded (in the form that the authors' code computes), words, "
        "reference_words and the same of each motion.\n\n"
        "rate: frames a second to score at; kappa: frames of a word; observed: frames (at rate) at each start that do "
        "not\n"
        "count; words: of poses that know neither place nor heading, as the authors evaluate; dlow: with spine, neck "
        "and head; package: as their package has them.");
  m.def(
      "score_npss",
      [](const Clips& motions, const Clips& truth, double rate) {
        return released([&] {
          return score_npss(standard_motions(motions, rate, "motion"), standard_motions(truth, rate, "truth"));
        });
      },
      "motions"_a, "truth"_a, py::kw_only(), "rate"_a = 25.0,
      "Mean normalised power spectrum similarity of clips, each with what came true; 0 is equal.");
  m.def(
      "score_apd",
      [](const Clips& futures, double rate) {
        if (futures.size() < 2) throw Error("futures", "are fewer than two");
        return released([&] { return score_apd(standard_motions(futures, rate, "future")); });
      },
      "futures"_a, py::kw_only(), "rate"_a = 25.0,
      "Average pairwise distance of futures of one observation by frame: (T) float32, metres.");
  m.def(
      "score_error",
      [](const Clips& futures, const Clip& truth, double rate) {
        const MotionError error = released([&] {
          return score_error(standard_motions(futures, rate, "future"), standard_motions({truth}, rate, "truth"));
        });
        const auto dict_of = [](const ErrorByFrame& e) {
          return py::dict("mean"_a = array_of(e.mean), "best"_a = array_of(e.best), "overall"_a = e.overall,
                          "best_overall"_a = e.best_overall);
        };
        py::dict out = dict_of(error.pose);
        out["path"] = dict_of(error.path);
        out["world"] = dict_of(error.world);
        return out;
      },
      "futures"_a, "truth"_a, py::kw_only(), "rate"_a = 25.0,
      "Joint error of futures against the one that came true, metres: by frame (T) of all ('mean') and of the future "
      "whose\n"
      "error is the least ('best'), and both over all frames ('overall', 'best_overall'). These are of poses without\n"
      "place and heading; the same of the root ('path') and of all joints ('world') in the world are dictionaries.");
  m.def(
      "motion_features", [](const Clips& clips) { return released([&] { return features_of(clips, "clip"); }); },
      "clips"_a,
      "What score_fid and score_diversity are taken over: features (N, 64) float32 of the windows of all clips.");
  m.def(
      "score_fid",
      [](const Clips& motions, const Clips& reference) {
        const inbetween::FidScore score = released(
            [&] { return inbetween::score_fid(features_of(motions, "motion"), features_of(reference, "reference")); });
        return py::dict("fid"_a = score.fid, "windows"_a = score.windows,
                        "reference_windows"_a = score.reference_windows, "dimensions"_a = score.dimensions);
      },
      "motions"_a, "reference"_a,
      "Frechet distance of the motion features of clips from those of real motion: a dictionary of fid, windows,\n"
      "reference_windows and dimensions. Two windows of each are needed at least.");
  m.def(
      "score_diversity",
      [](const Clips& motions) {
        return released([&] { return inbetween::score_diversity(features_of(motions, "motion")); });
      },
      "motions"_a, "Mean distance between the motion features of all pairs of windows of clips.");
  m.def("score_skating", &skating_of, "motions"_a, "scene"_a = py::none(), py::kw_only(), "rate"_a = 30.0,
        "How much feet slide, as `inhabit score skating` says it: a dictionary of foot_skating, the fraction of all "
        "frames in\n"
        "which a foot slides, motions, how many, and files, the same of each.\n\n"
        "scene: whose floor counts; left out, the floor that the feet stand on. rate: frames a second to score at.");
  m.def("score_jerk", &jerk_of, "motions"_a, "reference"_a = Clips(), py::kw_only(), "rate"_a = 30.0,
        "How clips move, as `inhabit score jerk` says it: a dictionary of jerk (m/s^3) and acceleration (m/s^2) of the "
        "joints,\n"
        "speed of the root over the ground (m/s), motions, how many, and files, the jerk of each.\n\n"
        "reference: real motion; jerk_ratio, of the jerk to theirs, is there too. rate: frames a second to score at.");
  m.def(
      "score_penetration", &penetration_of, "motions"_a, "scene"_a, py::kw_only(), "rate"_a = 30.0,
      "How much of the body is inside a scene, as `inhabit score penetration` says it: a dictionary of\n"
      "collision_frame_ratio, collision_vertex_ratio and penetration_max_mm, the same without tolerance (exact_...),\n"
      "motions, how many, and files, of each penetration_mm, deepest_frame (of the clip), deepest_in and\n"
      "collision_frame_ratio. rate: frames a second to score at.");
  m.def(
      "foot_skating",
      [](const Clip& clip, double height, double distance) {
        const FootSkating found = released([&, clip] { return foot_skating(posed(clip), height, distance); });
        return found.fraction();
      },
      "clip"_a, "height"_a = 0.05, "distance"_a = 0.025,
      "Fraction of frames in which a foot joint is less than `height` metres above the floor y = 0 and moves more "
      "than\n"
      "`distance` metres by the next frame. The clip is taken as it is: at its own rate, over y = 0. score_skating "
      "gives\n"
      "the number that the command prints.");
  m.def(
      "dynamics",
      [](const Clip& clip) {
        const Dynamics found = released([&, clip] { return dynamics(clip); });
        return py::dict("frames"_a = found.frames, "speed"_a = found.speed, "acceleration"_a = found.acceleration,
                        "jerk"_a = found.jerk);
      },
      "clip"_a,
      "Means over frames: speed of the root over the ground (m/s), acceleration (m/s^2) and jerk (m/s^3) of the "
      "joints.\n"
      "The clip is taken as it is: on its own skeleton, at its own rate. score_jerk gives the numbers that the command "
      "prints.");
  m.def("collisions", &collisions_of, "clip"_a, "scene"_a,
        "The built-in body in the clip's poses against a scene's meshes; floors do not count. A dictionary: depth (T) "
        "metres\n"
        "that the deepest vertex that collides is inside, vertices (T) fraction that collides, frame_ratio, and "
        "deepest:\n"
        "metres that a limb is inside what is not sat on, deepest_frame, deepest_joint, deepest_object. The clip is "
        "taken\n"
        "as it is: at its own rate, frames of its own. score_penetration gives the numbers that the command prints.");
  m.def(
      "frechet_distance",
      [](const Floats& first, const Floats& second) {
        for (const Floats* features : {&first, &second})
          if (features->dim() != 2 || features->size(0) < 2 || features->size(1) != first.size(-1))
            throw Error("features", "are not (N, D) and (M, D) with N, M over 1");
        return released([&] { return frechet_distance(feature_gaussian(first), feature_gaussian(second)); });
      },
      "first"_a, "second"_a, "Squared Frechet distance (FID) of features (N, D) and (M, D).");
}

}  // namespace inhabit::python
