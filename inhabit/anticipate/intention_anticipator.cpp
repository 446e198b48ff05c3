#include "inhabit/anticipate/intention_anticipator.h"

#include <mutex>
#include <optional>

#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/body/fit.h"
#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/observe.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/nn/parallel_chunks.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/floor_area.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/steering.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kMostFutures = 100'000;

/// Where a person can go on the floor under them; nothing where nothing stands on it.
std::optional<FreeSpace> floor_around(const Scene& scene, const Clip& person) {
  if (scene.empty()) return std::nullopt;
  const Scene obstacles = obstacles_of(rooms_looking_in(scene, person.root_path()));
  if (obstacles.empty()) return std::nullopt;
  const double floor = floor_under(person, SceneQuery(scene));
  const Tensor last = person.root_path()[-1];
  return free_floor(raised(scene, -floor), raised(obstacles, -floor), {last[0].item<double>(), last[2].item<double>()});
}

}  // namespace

struct IntentionAnticipator::Impl {
  Config config;
  BodyModel body;  // on the bones that the networks know
  FutureFunction networks;

  explicit Impl(const Networks& n) : config(n.config), body(body_on(n.skeleton)), networks(future_function(n)) {}
};

IntentionAnticipator IntentionAnticipator::load(const std::string& path) {
  const Networks networks = load_networks(path);
  if (!networks.forecasts()) throw Error(path, "lacks the networks that forecast intention and pose");
  return IntentionAnticipator(networks);
}

IntentionAnticipator::IntentionAnticipator(const Networks& networks) : impl_(std::make_unique<Impl>(networks)) {}
IntentionAnticipator::~IntentionAnticipator() = default;
IntentionAnticipator::IntentionAnticipator(IntentionAnticipator&&) noexcept = default;

const Config& IntentionAnticipator::config() const { return impl_->config; }

Result IntentionAnticipator::run(const Clip& clip, const Scene& scene, const Options& options) const {
  const torch::NoGradGuard no_gradients;
  const Config& c = impl_->config;
  if (options.samples < 1) throw Error("samples", "must be at least 1");
  if (options.samples > kMostFutures) throw Error("samples", "must be at most " + std::to_string(kMostFutures));
  if (!(options.seconds > 0 && options.seconds <= 3600)) throw Error("seconds", "must be over 0 and at most 3600");
  const Observed observed = observe(clip, options.start, c.rate, c.kappa, options.name);
  const int64_t start = observed.start;
  const int64_t frames = std::max<int64_t>(1, std::llround(options.seconds * c.rate));

  Result out;
  out.scene = scene;
  out.past = slice(observed.motion, std::max<int64_t>(0, start - c.observed), start);
  const Tensor seen = on_skeleton(out.past, impl_->body.skeleton).joints;  // (t, 22, 3)
  const Tensor past = observation(joint_features(seen), seen.size(0), c.observed).unsqueeze(0);
  const Futures futures = impl_->networks(past, draw_noise(c, options.samples, frames, options.seed), frames);
  out.labels = futures.labels;

  const Tensor last = seen[seen.size(0) - 1];
  const Tensor joints =
      feature_joints(futures.features, last[0].expand({options.samples, 3}), headings(last).expand({options.samples}));
  const auto posed = [&](const Tensor& places) {
    const BodyFit fit = options.solve ? fit_body(impl_->body, places) : fit_rotations(impl_->body, places);
    Clip on_body;
    on_body.rate = c.rate;
    on_body.skeleton = impl_->body.skeleton;
    on_body.joints = places;
    on_body.rotations = fit.rotations;
    on_body.trans = fit.trans;
    return on_skeleton(on_body, out.past.skeleton);
  };
  out.futures.resize(static_cast<size_t>(options.samples));
  if (!options.standard) out.on_source.resize(out.futures.size());
  const int64_t first = options.start < 0 ? clip.frames() : options.start, observed_frames = out.past.frames();
  const Clip last_pose = slice(out.past, observed_frames - 1, observed_frames);
  const std::optional<FreeSpace> floor = floor_around(scene, out.past);
  std::optional<refine::SharedSurroundings> surroundings;
  if (options.refine) surroundings.emplace(scene);
  std::mutex counting;
  int64_t done = 0;
  nn::parallel_chunks(options.samples, [&](int64_t s) {
    interruption_point();
    const torch::NoGradGuard none;
    const auto i = static_cast<size_t>(s);
    // What positions do not determine (twist, and how head, hands and feet are held) goes on from the last pose.
    Clip whole = posed(torch::cat({last.unsqueeze(0), joints[s]}));
    if (floor) whole = steered(whole, *floor);
    out.futures[i] = going_on(out.past, observed_frames, slice(whole, 0, 1), slice(whole, 1, whole.frames()));
    if (surroundings) out.futures[i] = refine::refine_continuation(out.past, out.futures[i], *surroundings);
    if (!options.standard) out.on_source[i] = going_on(clip, first, last_pose, out.futures[i]);
    const std::lock_guard<std::mutex> lock(counting);
    if (options.progress) options.progress(++done, options.samples);
  });
  if (!options.standard && out.labels.defined()) out.labels_on_source = labels_going_on(out.labels, c.rate, clip.rate);
  return out;
}

}  // namespace inhabit::anticipate
