#include "handles.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/interact/contact_script.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/refine/refine_clip.h"
#include "options.h"

namespace inhabit::c {
namespace {

using nlohmann::json;

/// The result with arrays that are there.
inhabit_result with_arrays(std::vector<Clip> clips, std::vector<Clip> on_source,
                           const std::vector<std::pair<const char*, torch::Tensor>>& arrays) {
  inhabit_result out{std::move(clips), std::move(on_source), {}};
  for (const auto& [name, tensor] : arrays)
    if (tensor.defined()) out.arrays[name] = kept(tensor);
  return out;
}

/// Where a hand goes: a part of the chair by name, a point, or null.
std::optional<Eigen::Vector3d> hand_of(const json& value, const interact::Chair& chair, int side) {
  try {
    return interact::contact_at(chair, interact::contact_place(value), side);
  } catch (const Error& e) {
    throw Error(side == 0 ? "left" : "right", e.what());
  }
}

/// The motions of several results, on the standard skeleton and on the clip's own.
template <class Result>
std::pair<std::vector<Clip>, std::vector<Clip>> motions_of(const std::vector<Result>& results) {
  std::pair<std::vector<Clip>, std::vector<Clip>> out;
  for (const Result& r : results) {
    out.first.push_back(r.motion);
    out.second.push_back(r.on_source);
  }
  return out;
}

inhabit_result run(const forecast::ContactForecaster& system, const Clip& clip, const Scene& scene, Options& text) {
  forecast::Options options;
  text.take("start", options.start);
  text.take("points", options.points);
  text.take("seed", options.seed);
  text.take("refine", options.refine);
  text.take("standard", options.standard);
  text.take("joints_alone", options.joints_alone);
  text.finish();
  return result_of(system.run(clip, scene, options));
}

inhabit_result run(const anticipate::IntentionAnticipator& system, const Clip& clip, const Scene& scene,
                   Options& text) {
  anticipate::Options options;
  text.take("start", options.start);
  text.take("samples", options.samples);
  text.take("seconds", options.seconds);
  text.take("seed", options.seed);
  text.take("refine", options.refine);
  text.take("standard", options.standard);
  text.finish();
  return result_of(system.run(clip, scene, options));
}

inhabit_result run(const inbetween::SceneInbetweener& system, const Clip& clip, const Scene& scene, Options& text) {
  inbetween::Options options;
  std::string keys = "ends";
  int64_t samples = 1;
  text.take("keys", keys);
  text.take("samples", samples);
  text.take("seed", options.seed);
  text.take("temperature", options.temperature);
  text.take("noise", options.noise);
  text.take("steps", options.steps);
  text.take("refine", options.refine);
  text.take("standard", options.standard);
  text.finish();
  options.keys = inbetween::key_frames(keys, clip.frames(), options.seed, "keys");
  const std::vector<inbetween::Result> results = system.run_samples(clip, scene, options, samples);
  auto [motions, on_source] = motions_of(results);
  return with_arrays(std::move(motions), std::move(on_source), {{"keys", torch::tensor(results.front().keys)}});
}

inhabit_result run(const interact::ChairInteractor& system, const Clip& clip, const Scene& scene, Options& text) {
  interact::Options options;
  int64_t samples = 1;
  text.take("samples", samples);
  text.take("chair", options.chair);
  text.take("seconds", options.seconds);
  text.take("seed", options.seed);
  text.take("raw", options.raw);
  text.take("standard", options.standard);
  text.take("draw_contacts", options.draw_contacts);
  text.take("hold", options.hold);
  const json left = text.value("left"), right = text.value("right");
  text.finish();
  if (!left.is_null() || !right.is_null()) {
    const interact::Chair chair = system.chair_of(clip, scene, options);
    options.contacts.push_back({hand_of(left, chair, 0), hand_of(right, chair, 1)});
  }
  const std::vector<interact::Result> results = system.run_samples(clip, scene, options, samples);
  std::vector<int64_t> seated;
  for (const interact::Result& r : results) seated.push_back(r.seated.value_or(-1));
  auto [motions, on_source] = motions_of(results);
  return with_arrays(std::move(motions), std::move(on_source), {{"seated", torch::tensor(seated)}});
}

inhabit_result run(const Refiner&, const Clip& clip, const Scene& scene, Options& text) {
  refine::Options options;
  std::string keep;
  text.take("keep", keep);
  text.take("contacts", options.contacts);
  text.take("hands", options.hands);
  text.take("generated", options.generated);
  text.take("smooth", options.smooth);
  text.take("standard", options.standard);
  text.finish();
  if (!keep.empty()) refine::add_kept(keep, clip, options);
  refine::Result r = refine::refine(clip, scene, options);
  return with_arrays({r.clip}, {r.on_source}, {{"moved", torch::tensor(static_cast<float>(r.moved))}});
}

template <class T>
const T& of(const std::shared_ptr<const T>& pointer) {
  return *pointer;
}
const Refiner& of(const Refiner& refiner) { return refiner; }

inhabit_system load(const std::string& system, const char* model) {
  const auto file = [&](const char* shipped) { return model_file(model == nullptr ? "" : model, shipped); };
  if (system == "forecast")
    return {std::make_shared<const forecast::ContactForecaster>(
        forecast::ContactForecaster::load(file("forecast-compact.safetensors")))};
  if (system == "anticipate")
    return {std::make_shared<const anticipate::IntentionAnticipator>(
        anticipate::IntentionAnticipator::load(file("anticipate-cmu.safetensors")))};
  if (system == "inbetween")
    return {std::make_shared<const inbetween::SceneInbetweener>(
        inbetween::SceneInbetweener::load(file("inbetween-compact.safetensors")))};
  if (system == "interact")
    return {std::make_shared<const interact::ChairInteractor>(
        interact::ChairInteractor::load(file("interact-compact.safetensors")))};
  if (system != "refine")
    throw Error("system",
                "is '" + system.substr(0, 64) + "', none of anticipate, forecast, inbetween, interact, refine");
  if (model != nullptr) throw Error("model", "is given, but refinement has none");
  return {Refiner{}};
}

const Clip& clip_at(const std::vector<Clip>& clips, int64_t index, const char* what) {
  if (index < 0 || index >= static_cast<int64_t>(clips.size()))
    throw Error("index", "is not under " + std::to_string(clips.size()));
  const Clip& clip = clips[static_cast<size_t>(index)];
  if (clip.frames() == 0) throw Error(what, "were not asked for");
  return clip;
}

}  // namespace

inhabit_result result_of(forecast::Result r) {
  return with_arrays(
      {r.prediction}, {r.on_source},
      {{"joints", r.forecast.joints}, {"points", r.forecast.points}, {"contact_points", r.forecast.contact_points}});
}

inhabit_result result_of(anticipate::Result r) {
  return with_arrays(std::move(r.futures), std::move(r.on_source), {{"labels", r.labels}});
}

}  // namespace inhabit::c

using namespace inhabit;
using namespace inhabit::c;

inhabit_system* inhabit_system_load(const char* system, const char* model) {
  return guarded<>(static_cast<inhabit_system*>(nullptr),
                   [&] { return new inhabit_system(load(text_of(system, "system"), model)); });
}

inhabit_result* inhabit_run(const inhabit_system* system, const inhabit_clip* clip, const inhabit_scene* scene,
                            const char* options) {
  return guarded<>(static_cast<inhabit_result*>(nullptr), [&] {
    needed(system, "system");
    const Clip& motion = needed(clip, "clip").clip;
    Options given(options);
    return std::visit(
        [&](const auto& one) {
          return new inhabit_result(run(of(one), motion, scene == nullptr ? Scene() : scene->scene, given));
        },
        system->system);
  });
}

void inhabit_system_free(inhabit_system* system) { delete system; }

int64_t inhabit_result_clips(const inhabit_result* result) {
  return result == nullptr ? -1 : static_cast<int64_t>(result->clips.size());
}

inhabit_clip* inhabit_result_clip(const inhabit_result* result, int64_t index) {
  return guarded<>(static_cast<inhabit_clip*>(nullptr),
                   [&] { return clip_handle(clip_at(needed(result, "result").clips, index, "motions")); });
}

inhabit_clip* inhabit_result_on_source(const inhabit_result* result, int64_t index) {
  return guarded<>(static_cast<inhabit_clip*>(nullptr), [&] {
    return clip_handle(clip_at(needed(result, "result").on_source, index, "motions on the clip's skeleton"));
  });
}

int inhabit_result_array(const inhabit_result* result, const char* name, inhabit_array* out) {
  return guarded<>(-1, [&] {
    fill_array(needed(result, "result").arrays, text_of(name, "name"), needed(out, "out"));
    return 0;
  });
}

void inhabit_result_free(inhabit_result* result) { delete result; }
