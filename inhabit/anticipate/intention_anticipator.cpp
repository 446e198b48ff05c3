#include "inhabit/anticipate/intention_anticipator.h"

#include <cmath>

#include "inhabit/anticipate/fast_futures.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/body/fit.h"
#include "inhabit/error.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit {

using torch::Tensor;

namespace {

/// The built-in body on given bones.
BodyModel body_on(const Skeleton& skeleton) {
  BodyModel body = builtin_body();
  body.skeleton = skeleton;
  body.joint_template = skeleton.rest_joints();
  body.joint_dirs = torch::zeros_like(body.joint_dirs);
  return body;
}

}  // namespace

struct IntentionAnticipator::Impl {
  AnticipateConfig config;
  BodyModel body;  // on the bones that the networks know
  FastFutures networks;

  explicit Impl(const AnticipateNetworks& n) : config(n.config), body(body_on(n.skeleton)), networks(n) {}
};

IntentionAnticipator IntentionAnticipator::load(const std::string& path) {
  const AnticipateNetworks networks = load_anticipate_networks(path);
  if (networks.pose.is_empty() || (networks.config.intention && networks.intention.is_empty()))
    throw Error(path, "lacks the networks that forecast intention and pose");
  return IntentionAnticipator(networks);
}

IntentionAnticipator::IntentionAnticipator(const AnticipateNetworks& networks)
    : impl_(std::make_unique<Impl>(networks)) {}
IntentionAnticipator::~IntentionAnticipator() = default;
IntentionAnticipator::IntentionAnticipator(IntentionAnticipator&&) noexcept = default;

const AnticipateConfig& IntentionAnticipator::config() const { return impl_->config; }

Anticipation IntentionAnticipator::anticipate(const Clip& clip, const AnticipateOptions& options,
                                              const std::string& subject) const {
  const torch::NoGradGuard no_gradients;
  const AnticipateConfig& c = impl_->config;
  if (options.start > clip.frames())
    throw Error(subject, "frame " + std::to_string(options.start) + " is beyond the end (" +
                             std::to_string(clip.frames()) + " frames)");
  const Clip motion = resample(retarget(clip, subject), c.rate, subject);
  const int64_t asked = options.start < 0 ? clip.frames() : options.start;
  const int64_t start =
      std::min<int64_t>(motion.frames(), std::llround(static_cast<double>(asked) * c.rate / clip.rate));
  if (start < c.kappa)
    throw Error(subject, "has " + std::to_string(start) + " frames at " + std::to_string(static_cast<int>(c.rate)) +
                             " a second before the start; at least " + std::to_string(c.kappa) + " are needed");
  const int64_t frames = std::max<int64_t>(1, std::llround(options.seconds * c.rate));

  Anticipation out;
  out.past = slice(motion, std::max<int64_t>(0, start - c.observed), start);
  const Tensor seen = on_skeleton(out.past, impl_->body.skeleton).joints;  // (t, 22, 3)
  const Tensor past = observation(anticipate_features(seen), seen.size(0), c.observed).unsqueeze(0);
  const Futures futures = impl_->networks.forward(past, draw_noise(c, options.samples, frames, options.seed), frames);
  out.labels = futures.labels;

  const Tensor last = seen[seen.size(0) - 1];
  const Tensor joints =
      feature_joints(futures.features, last[0].expand({options.samples, 3}), headings(last).expand({options.samples}));
  out.futures.resize(static_cast<size_t>(options.samples));
  nn::parallel_chunks(options.samples, [&](int64_t s) {
    const torch::NoGradGuard none;
    const BodyFit fit = options.solve ? fit_body(impl_->body, joints[s]) : fit_rotations(impl_->body, joints[s]);
    Clip future;
    future.rate = c.rate;
    future.skeleton = impl_->body.skeleton;
    future.joints = joints[s];
    future.rotations = fit.rotations;
    future.trans = fit.trans;
    out.futures[static_cast<size_t>(s)] = on_skeleton(future, out.past.skeleton);
  });
  return out;
}

}  // namespace inhabit
