#pragma once
#include "inhabit/inbetween/drawn_floors.h"
#include "inhabit/train/loop.h"

namespace inhabit::inbetween {

/// Of PathNet's paths over drawn floors, after each of its rounds: metres from A*'s way of the nearest of the four,
/// how much nearer to obstacles than it should all four come, and of how likely it is said to be. Then, of the
/// likeliest after the last round, metres from A*'s way and the share of points nearer than 0.15 m to something where
/// A*'s are not.
Losses path_losses(PathNet network, const DrawnFloors& floors);

/// PathNet's training. It needs no data set: floors are drawn as it goes.
/// @param seed of the floors that validate @param device where the network is trained
TrainTask path_task(const PathNet& network, uint64_t seed, torch::Device device);

}  // namespace inhabit::inbetween
