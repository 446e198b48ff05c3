#pragma once
#include <functional>

#include "inhabit/forecast/model_file.h"

namespace inhabit::forecast {

/// What the contact points that a forecast is made from are.
enum class Contacts { none, real, predicted };

/// Joints (B, T, J, 3) in the window's axes from past joints (B, P, J, 3) and contact points (B, T, J, 4), which are
/// ignored and may be undefined where there are none.
using Motion = std::function<torch::Tensor(const torch::Tensor& past, const torch::Tensor& contact_points)>;

/// How a model's networks move a person who has such contact points, on the CPU; empty where the model cannot.
/// Safe to use from several threads.
Motion motion_of(const Networks& networks, Contacts contacts);

/// Ways to go on (hypotheses.h) from the same, with predicted contact points; empty where the model has none.
using Hypothesize = std::function<Hypotheses(const torch::Tensor& past, const torch::Tensor& contact_points)>;
/// A model's hypotheses of past (B, P, J, 3) and contact points (B, T, J, 4), metres. Keeps its networks.
Hypothesize hypothesize_of(const Networks& networks);

}  // namespace inhabit::forecast
