#include "inhabit/forecast/motion_batch.h"

#include <cmath>
#include <memory>
#include <unordered_map>

#include "inhabit/forecast/articulated_network.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/math/random.h"

namespace inhabit::forecast {

using torch::Tensor;

namespace {

constexpr int kPaces = 5;  // that a window can have, few enough for what is predicted of each to be kept

/// -2 (slowest) to 2 (fastest) for a recording's window, 0 (as it is) for others.
int drawn_pace(const Data& data, const Config& config, int64_t window, uint64_t draw) {
  if (config.training.time_warp == 0 || data.windows().entry(window).source.empty()) return 0;
  return static_cast<int>(item_seed(draw, 2) % kPaces) - kPaces / 2;
}

}  // namespace

ContactSource no_contacts(const Config& config) {
  return [&config](int64_t, int64_t, const Sample&, uint64_t) {
    return ConditioningContacts{torch::zeros({config.future, config.joints, 4})};
  };
}

ContactSource true_contacts(const Config& config) {
  return [&config](int64_t, int64_t, const Sample& s, uint64_t) {
    return ConditioningContacts{
        true_contact_points(s.points.unsqueeze(0), s.joints.slice(0, config.past).unsqueeze(0), config)[0], true,
        false};
  };
}

ContactSource predicted_contacts(const Config& config, const ContactNetwork& network) {
  auto contact = std::make_shared<FastContactNetwork>(network);
  auto known = std::make_shared<std::unordered_map<int64_t, Tensor>>();
  return [&config, contact, known](int64_t, int64_t window, const Sample& s, uint64_t) {
    Tensor& kept = (*known)[window];
    if (!kept.defined()) {
      const Tensor points = s.points.unsqueeze(0), past = s.joints.slice(0, 0, config.past).unsqueeze(0);
      const Tensor dct = contact->forward(points, contact_features(points, past, config), past);
      kept = contact_points(points, dct, config)[0].to(torch::kHalf);
    }
    return ConditioningContacts{kept.to(torch::kFloat), true, true};
  };
}

ContactSource every_other_true(const Config& config, const ContactSource& predicted) {
  return [predicted, truth = true_contacts(config)](int64_t place, int64_t window, const Sample& s, uint64_t draw) {
    return place % 2 == 0 ? truth(place, window, s, draw) : predicted(place, window, s, draw);
  };
}

ContactSource mixed_contacts(const Config& config, const ContactSource& predicted) {
  return [predicted, truth = true_contacts(config), none = no_contacts(config)](int64_t place, int64_t window,
                                                                                const Sample& s, uint64_t draw) {
    const uint64_t eighth = draw % 8;
    return eighth < 4   ? predicted(place, window, s, draw)
           : eighth < 7 ? truth(place, window, s, draw)
                        : none(place, window, s, draw);
  };
}

MotionBatch motion_batch(const Data& data, const Config& config, const std::vector<int64_t>& windows,
                         const ContactSource& contacts, uint64_t point_seed, std::optional<uint64_t> seed, bool truth) {
  torch::NoGradGuard no_grad;
  std::vector<Tensor> joints, points, touching, conditioning, touched;
  for (size_t i = 0; i < windows.size(); ++i) {
    const uint64_t draw = item_seed(seed.value_or(0), static_cast<uint64_t>(windows[i]));
    const int pace = seed ? drawn_pace(data, config, windows[i], draw) : 0;
    Sample s = data.sample(windows[i], point_seed, false, std::pow(1 + config.training.time_warp, 0.5 * pace));
    const auto place = static_cast<int64_t>(i);
    const ContactSource real = true_contacts(config);
    ConditioningContacts contact = contacts(place, windows[i] * kPaces + pace + kPaces / 2, s, item_seed(draw, 1));
    Tensor right = !truth                              ? Tensor()
                   : contact.any && !contact.predicted ? contact.points
                                                       : real(place, windows[i], s, 0).points;
    if (seed) {
      std::mt19937_64 random(draw);
      Augmentation moved = draw_augmentation(config, random);
      moved.mirror = config.training.mirror && random() % 2 == 0;
      moved.scale = 1 + uniform(random, -config.training.stature, config.training.stature);
      s.joints = moved.joints(s.joints);
      s.points = moved(s.points);
      contact.points = moved.contacts(contact.points);
      if (truth) right = moved.contacts(right);
    }
    joints.push_back(s.joints);
    points.push_back(s.points);
    touching.push_back(contact.points);
    conditioning.push_back(contact_conditioning(1, contact.any, contact.predicted));
    if (truth) touched.push_back(right);
  }
  const Tensor all = torch::stack(joints);
  return {all.slice(1, 0, config.past).contiguous(),
          all.slice(1, config.past).contiguous(),
          torch::stack(points),
          torch::stack(touching),
          torch::cat(conditioning),
          truth ? torch::stack(touched) : Tensor()};
}

}  // namespace inhabit::forecast
