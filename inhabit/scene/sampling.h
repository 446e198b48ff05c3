#pragma once
#include <torch/types.h>

#include <random>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// `count` points spread evenly over the surface of a scene's meshes, each equally likely to fall anywhere; from its
/// point cloud where there are no meshes: without repetition where it has enough, else every point at least once.
/// (count, 3) metres. Throws Error when the scene is empty.
torch::Tensor sample_points(const Scene& scene, int64_t count, std::mt19937_64& random);

/// The same of that part of the scene that lies within `radius` metres of `center` (3): 5000 points within 2.5 m of the
/// root are what a forecast looks at. Throws Error, with the distance, when nothing of the scene is that near.
torch::Tensor sample_points_near(const Scene& scene, const torch::Tensor& center, double radius, int64_t count,
                                 std::mt19937_64& random);

}  // namespace inhabit
