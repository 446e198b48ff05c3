#include "inhabit/forecast/contact_forecaster.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "inhabit/body/fit.h"
#include "inhabit/error.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/motion_of.h"
#include "inhabit/forecast/window_frame.h"
#include "inhabit/motion/observe.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/nn/instance_pool.h"
#include "inhabit/nn/one_blas_thread.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/scene_terms.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/sampling.h"

namespace inhabit::forecast {
namespace {

/// The observed person, on their own bones, in predicted joints (T, 22, 3).
/// @param rigid whether the network keeps the lengths of bones: else they are fitted over all frames together
Clip embodied(const Clip& past, const torch::Tensor& joints, bool rigid) {
  const BodyModel body = body_on(past.skeleton);
  const BodyFit fit = rigid ? fit_rotations(body, joints) : fit_body(body, joints);
  Clip out = person_of(past);
  out.file = {};
  out.joints = joints;
  out.rotations = fit.rotations;
  out.trans = fit.trans;
  return out;
}

}  // namespace

torch::Tensor Forecast::contact_maps() const {
  if (!contact_dct.defined()) throw Error("contact maps", "are not made where joints are wanted alone");
  const torch::NoGradGuard no_gradients;
  return contact_maps_from_dct(contact_dct.unsqueeze(0), map_frames, joints.size(1))[0];
}

struct ContactForecaster::Impl {
  Config config;
  mutable nn::InstancePool<FastContactNetwork> contact;
  Motion motion;
  Hypothesize hypothesize;
  bool rigid = false;  // the network keeps the lengths of bones

  /// Ways to go on from what was observed (P, J, 3) with the contact points of its forecast, likeliest first.
  std::vector<Hypothesis> hypotheses_of(const torch::Tensor& past, const Forecast& forecast, int64_t count) const {
    const WindowFrame frame = window_frame(past, config);
    const torch::Tensor touching = forecast.contact_points.narrow(2, 3, 1);
    const torch::Tensor points =
        torch::cat({frame.to_window(forecast.contact_points.narrow(2, 0, 3)) * touching, touching}, 2);
    const Hypotheses found = hypothesize(frame.to_window(past).unsqueeze(0), points.unsqueeze(0));
    const auto [log_probability, order] = found.log_probability[0].sort(0, /*descending=*/true);
    std::vector<Hypothesis> out;
    for (int64_t k = 0; k < count; ++k) {
      Hypothesis one;
      one.joints = frame.to_world(found.joints[0][order[k].item<int64_t>()]);
      one.probability = std::exp(log_probability[k].item<double>());
      out.push_back(std::move(one));
    }
    return out;
  }
};

ContactForecaster::ContactForecaster(const Networks& networks)
    : impl_(new Impl{
          networks.config,
          nn::InstancePool<FastContactNetwork>([network = networks.contact] { return FastContactNetwork(network); }),
          motion_of(networks, Contacts::predicted), hypothesize_of(networks), !networks.articulated.is_empty()}) {}
ContactForecaster::~ContactForecaster() = default;
ContactForecaster::ContactForecaster(ContactForecaster&&) noexcept = default;

ContactForecaster ContactForecaster::load(const std::string& path) {
  Networks networks = load_networks(path);
  if (!networks.complete()) throw Error(path, "lacks the contact or the motion network: train both stages");
  return ContactForecaster(networks);
}

const Config& ContactForecaster::config() const { return impl_->config; }

int64_t ContactForecaster::hypotheses() const { return impl_->hypothesize ? config().articulated.hypotheses : 0; }

Forecast ContactForecaster::predict(const torch::Tensor& past, const torch::Tensor& points) const {
  torch::NoGradGuard no_grad;
  const nn::OneBlasThread one_blas_thread;  // products are small, and its threads keep a core from what comes next
  const Config& c = config();
  if (past.sizes() != torch::IntArrayRef({c.past, c.joints, 3}))
    throw Error("the forecaster observes (" + std::to_string(c.past) + ", " + std::to_string(c.joints) +
                ", 3) joints, not another shape");
  const WindowFrame frame = window_frame(past, c);
  const torch::Tensor observed = frame.to_window(past).unsqueeze(0), scene = frame.to_window(points).unsqueeze(0);
  const torch::Tensor dct = impl_->contact.take()->forward(scene, contact_features(scene, observed, c), observed);
  Forecast out;
  out.contact_dct = dct[0];
  out.map_frames = c.frames();
  torch::Tensor contacts = contact_points(scene, dct, c);
  out.joints = frame.to_world(impl_->motion(observed, contacts)[0]);
  const torch::Tensor touching = contacts[0].narrow(2, 3, 1);
  out.contact_points = torch::cat({frame.to_world(contacts[0].narrow(2, 0, 3)) * touching, touching}, 2);
  out.points = points;
  return out;
}

Result ContactForecaster::run(const Clip& clip, const Scene& scene, const Options& options) const {
  torch::NoGradGuard no_grad;
  const Config& c = config();
  if (c.joints != kStandardJoints)
    throw Error("the model", "observes " + std::to_string(c.joints) + " joints, not the standard 22");
  if (options.points < 0 || options.points > 1'000'000) throw Error("points", "are out of range");
  if (options.samples < 1) throw Error("samples", "must be at least 1");
  if (options.samples > 1 && options.samples > hypotheses())
    throw Error("samples", hypotheses() == 0 ? "this model has one forecast alone"
                                             : "this model has " + std::to_string(hypotheses()) + " ways to go on");
  if (options.samples > 1 && options.joints_alone)
    throw Error("samples", "are not made where the joints of the one forecast are wanted alone");
  const Observed observed = observe(clip, options.start, c.rate, c.past, options.name);
  const Clip& motion = observed.motion;
  const int64_t start = observed.start;
  Result out;
  out.floor_assumed = scene.empty();
  out.scene = out.floor_assumed ? assumed_floor(motion) : scene;
  out.past = slice(motion, start - c.past, start);
  if (motion.frames() > start) out.truth = slice(motion, start, std::min<int64_t>(motion.frames(), start + c.future));
  std::mt19937_64 random(options.seed);
  const torch::Tensor points = sample_points_near(out.scene, out.past.joints[c.past - 1][c.root], c.inference.radius,
                                                  options.points > 0 ? options.points : c.inference.points, random);
  out.forecast = predict(out.past.joints, points);
  if (options.joints_alone) {
    out.forecast.contact_dct.reset();
    out.prediction.skeleton = out.past.skeleton;
    out.prediction.rate = c.rate;
    out.prediction.joints = out.forecast.joints;
    return out;
  }
  const int64_t end = options.start < 0 ? clip.frames() : options.start;
  std::optional<refine::SharedSurroundings> surroundings;
  if (options.refine) surroundings.emplace(out.scene);
  const auto finish = [&](const torch::Tensor& joints, Clip& prediction, Clip& on_source) {
    // What positions do not determine (twist, and how head, hands and feet are held) goes on from the last observed
    // pose.
    const Clip whole = embodied(out.past, torch::cat({out.past.joints.slice(0, c.past - 1), joints}), impl_->rigid);
    prediction = going_on(out.past, c.past, slice(whole, 0, 1), slice(whole, 1, whole.frames()));
    prediction.joints = joints;
    if (surroundings) prediction = refine::refine_continuation(out.past, prediction, *surroundings);
    if (!options.standard) on_source = going_on(clip, end, slice(out.past, c.past - 1, c.past), prediction);
  };
  finish(out.forecast.joints, out.prediction, out.on_source);
  if (options.samples > 1) out.hypotheses = impl_->hypotheses_of(out.past.joints, out.forecast, options.samples);
  for (Hypothesis& one : out.hypotheses) finish(one.joints, one.prediction, one.on_source);
  return out;
}

}  // namespace inhabit::forecast
