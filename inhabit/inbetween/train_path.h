#pragma once
#include "inhabit/inbetween/drawn_floors.h"
#include "inhabit/train/loop.h"

namespace inhabit::inbetween {

/// Losses of PathNet's four paths over each drawn floor:
/// - "total", which is trained on, sums over the rounds, later ones with more weight: the distance (metres) from A*'s
///   path, above all of the nearest of the four, and by how much they come too near to obstacles. It includes "likely";
/// - "likely": minus the log-probability of the nearest path;
/// - "metres": the distance of the likeliest path from A*'s, after the last round;
/// - "touches": the fraction of that path's points that are nearer than 0.15 m to something where A*'s path is not.
Losses path_losses(PathNet network, const DrawnFloors& floors);

/// PathNet's training. It needs no data set: floors are drawn as it goes.
/// @param seed of the floors that validate @param device where the network is trained
TrainTask path_task(const PathNet& network, uint64_t seed, torch::Device device);

}  // namespace inhabit::inbetween
