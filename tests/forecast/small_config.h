#pragma once
#include "inhabit/forecast/config.h"

/// A network small enough to build in every test.
inline inhabit::forecast::Config small_forecast_config() {
  inhabit::forecast::Config config;
  config.preset = "small";
  config.past = 6;
  config.future = 9;
  config.joints = 5;
  config.root = 2;
  config.contact_coefficients = 4;
  config.root_coefficients = 7;
  config.hidden = 16;
  config.inference.points = 120;
  config.abstraction = {{inhabit::forecast::PointVoxelSpec{16, 2, 8}, 40, 0.5, 8, {12, 20}},
                        {inhabit::forecast::PointVoxelSpec{24, 1, 4}, 12, 1.0, 8, {24}},
                        {std::nullopt, 4, 2.0, 8, {16, 32}}};
  config.propagation = {{{32, 24}, inhabit::forecast::PointVoxelSpec{16, 1, 4}},
                        {{16}, inhabit::forecast::PointVoxelSpec{16, 1, 8}},
                        {{24, 16}, inhabit::forecast::PointVoxelSpec{8, 1, 8}}};
  return config;
}
