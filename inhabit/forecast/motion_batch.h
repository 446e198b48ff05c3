#pragma once
#include <torch/types.h>

#include <functional>
#include <optional>
#include <vector>

#include "inhabit/forecast/network.h"
#include "inhabit/forecast/sample.h"

namespace inhabit::forecast {

/// Windows as motion networks are trained on them.
struct MotionBatch {
  torch::Tensor past;          ///< (B, P, J, 3)
  torch::Tensor future;        ///< (B, T, J, 3)
  torch::Tensor points;        ///< (B, N, 3) of the scene
  torch::Tensor contacts;      ///< (B, T, J, 4) contact points that the network sees
  torch::Tensor conditioning;  ///< (B, 2) what they are: contact_conditioning
  torch::Tensor truth;         ///< (B, T, J, 4) true contact points; undefined unless asked for

  /// The same on another device.
  MotionBatch on(torch::Device d) const {
    return {past.to(d),     future.to(d),       points.to(d),
            contacts.to(d), conditioning.to(d), truth.defined() ? truth.to(d) : truth};
  }
};

/// Contact points (T, J, 4) of a window in its sample's axes, and whether there are any and they are predicted.
struct ConditioningContacts {
  torch::Tensor points;    ///< x y z metres, then whether the joint is in contact; zeros where it is not
  bool any = false;        ///< false: the network is to do without
  bool predicted = false;  ///< by the contact network; else true ones
};
/// @param place of the window in its batch, @param window a number of the window and its pace alone, @param draw one of
/// the window's and the step's own.
using ContactSource =
    std::function<ConditioningContacts(int64_t place, int64_t window, const Sample& sample, uint64_t draw)>;

/// No contact points for any window: zeros (T, J, 4), without conditioning. `config` must outlive what is returned.
ContactSource no_contacts(const Config& config);
/// The true contact points (T, J, 4) of each window's future, from its scene points and joints. `config` must outlive
/// what is returned.
ContactSource true_contacts(const Config& config);
/// What the contact network predicts. A window's prediction is made once and kept (10 kB): its scene points must be
/// the same every time. Not safe to use from several threads.
ContactSource predicted_contacts(const Config& config, const ContactNetwork& network);
/// The truth in every other window of a batch, else `predicted`.
ContactSource every_other_true(const Config& config, const ContactSource& predicted);
/// By the draw: `predicted` in half of the windows, the truth in three eighths, none in the others.
ContactSource mixed_contacts(const Config& config, const ContactSource& predicted);

/// Scene points are drawn from `point_seed`, the augmentation and the pace of recordings (config.training.time_warp)
/// from `seed`; none without. @param truth is wanted too
MotionBatch motion_batch(const Data& data, const Config& config, const std::vector<int64_t>& windows,
                         const ContactSource& contacts, uint64_t point_seed, std::optional<uint64_t> seed,
                         bool truth = false);

}  // namespace inhabit::forecast
