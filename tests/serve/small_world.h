#pragma once
#include <memory>

#include "inhabit/serve/world.h"
#include "interact/chair_scene.h"
#include "interact/small_networks.h"

namespace inhabit::serve {

/// An armchair at (0.5, -0.4) on a floor, and networks of no training whose people stay where they are.
inline std::shared_ptr<const World> small_world() {
  static const std::shared_ptr<const World> world = [] {
    std::mt19937_64 random(5);
    Furniture chair = make_armchair(random);
    chair.place(0.5, -0.4, 0.7);
    interact::Networks networks = interact::untrained_networks(interact::small_interact_config());
    networks.output_scale.mean.zero_();
    networks.output_scale.deviation.fill_(0.05);
    return make_world(scene_of({chair}), interact::ChairInteractor(networks));
  }();
  return world;
}

}  // namespace inhabit::serve
