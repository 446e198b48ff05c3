#include "inhabit/inbetween/residual_sample.h"

#include "inhabit/inbetween/residual.h"
#include "inhabit/inbetween/residual_input.h"

namespace inhabit::inbetween {

using torch::Tensor;

SampledMotion sample_residual(const Networks& networks, FastDenoiser& denoiser, const Baseline& baseline,
                              const SceneDistances& scene, const ResidualSampling& how) {
  const torch::NoGradGuard no_gradients;
  Denoiser network = networks.network;
  const double rate = networks.config.rate;
  const int64_t count = baseline.poses.frames();
  const ResidualFrames frames = residual_frames({&baseline}, networks.residual_table);
  const Tensor open = (frames.scale > 0).to(torch::kFloat32), bones = bone_lengths(baseline.poses).unsqueeze(0),
               no_fan = torch::zeros({count, kFanFeatures}), no_points = torch::zeros({1, kPointFeatures, count});
  const Tensor shape = network->embed_shape(bones);
  const Tensor hidden = static_features(baseline, no_fan, rate).unsqueeze(0);
  const Tensor shown =
      how.guidance == 0 ? hidden : static_features(baseline, scene_fan(scene, baseline), rate).unsqueeze(0);
  Tensor before = torch::zeros({1, kResidualFeatures, count});
  const auto denoise = [&](const Tensor& x, int64_t t) {
    const auto predict = [&](const Tensor& fixed, const Tensor& body) {
      return denoiser.residual(denoiser_channels(x, before, fixed, body), t, shape) * open;
    };
    Tensor clean;
    if (how.guidance == 0) {
      clean = predict(hidden, no_points);
    } else {
      // What sees the scene is asked last, for feet are told from its features.
      const Tensor blind = how.guidance == 1 ? Tensor() : predict(hidden, no_points);
      clean = predict(shown, body_features(frames, {scene}, before));
      if (blind.defined()) clean = how.guidance * clean + (1 - how.guidance) * blind;
    }
    return before = clean;
  };
  const KeyConstraints keys{torch::zeros_like(open), 1 - open};
  const Tensor residual = sample(how.schedule, how.sampler, how.steps, denoise, keys, how.noise, how.progress);
  SampledMotion out{motion_of(residual[0], frames.scale[0], baseline), {}};
  if (FootContactNet feet = networks.feet) out.feet = torch::sigmoid(feet(denoiser.features()))[0].t().contiguous();
  return out;
}

}  // namespace inhabit::inbetween
