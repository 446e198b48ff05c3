#pragma once
#include <torch/types.h>

#include <cstdint>

#include "inhabit/inbetween/path_net.h"

namespace inhabit::inbetween {

/// A floor plan that was drawn at random, and a detour over it: what PathNet is trained on. B of them in a batch.
struct DrawnFloors {
  torch::Tensor distance;  ///< (B, 48, 64) metres to obstacles, negative inside, in the line's axes
  torch::Tensor length;    ///< (B) metres of the lines
  torch::Tensor offsets;   ///< (B, 32, 2) metres of the path that A* finds, from the line at a steady pace

  DrawnFloors to(torch::Device device) const {  ///< the same on another device
    return {distance.to(device), length.to(device), offsets.to(device)};
  }
};

/// Boxes that block the line between two places, boxes beside it, sometimes a wall or two pieces with an opening
/// between them, sometimes the walls of a room around it, sometimes a seat at an end, which is no obstacle; only those
/// that A* finds a detour in (obstacle_detours.h). Half of them, at random, with the sides changed, so that none is
/// preferred.
DrawnFloors draw_floors(size_t count, uint64_t seed);

}  // namespace inhabit::inbetween
