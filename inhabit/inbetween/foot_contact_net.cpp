#include "inhabit/inbetween/foot_contact_net.h"

#include "inhabit/body/skeleton.h"
#include "inhabit/inbetween/temporal_unet.h"
#include "inhabit/nn/mish.h"
#include "inhabit/refine/contacts.h"

namespace inhabit::inbetween {

namespace tn = torch::nn;

namespace {

constexpr int64_t kMixed = 32;  // channels

}  // namespace

FootContactNetImpl::FootContactNetImpl(int64_t channels) {
  constexpr auto kJoints = static_cast<int64_t>(kFootJoints.size());
  mix = register_module("mix", tn::Conv1d(tn::Conv1dOptions(channels, kMixed, kTaps).padding(kTaps / 2)));
  tell = register_module("tell", tn::Conv1d(tn::Conv1dOptions(kMixed, kJoints, 1)));
}

torch::Tensor FootContactNetImpl::forward(const torch::Tensor& features) { return tell(nn::mish(mix(features))); }

FootContactNet foot_contact_net(const Config& config) {
  return FootContactNet(config.width * config.multipliers.front());
}

torch::Tensor foot_contacts(const Poses& poses, double rate) {
  const int64_t frames = poses.frames();
  torch::Tensor out = torch::zeros({frames, static_cast<int64_t>(kFootJoints.size())});
  const std::vector<double> floor(static_cast<size_t>(frames), 0);
  for (size_t i = 0; i < kFootJoints.size(); ++i) {
    const int joint = kFootJoints[i];
    refine::Track track;
    for (int64_t t = 0; t < frames; ++t) track.push_back(poses.joints[Poses::at(t, joint)].cast<double>());
    for (const refine::Contact& contact :
         refine::detect_contacts(joint, track, floor, refine::standing_height(track, floor), rate,
                                 refine::is_ball(joint) ? refine::ContactDetection{} : refine::kHeelDetection))
      out.select(1, static_cast<int64_t>(i)).slice(0, contact.first, contact.last + 1).fill_(1);
  }
  return out;
}

}  // namespace inhabit::inbetween
