#pragma once
#include <cstdint>
#include <vector>

namespace inhabit {

/// The few joints that move each vertex of a skin: vertex v has the entries [first[v], first[v + 1]).
struct SparseWeights {
  std::vector<int32_t> first;  ///< (V + 1)
  std::vector<int32_t> joint;  ///< of each entry
  std::vector<float> weight;   ///< of each entry; those of a vertex sum to 1
};

/// How a joint moves the skin. A line of the cache, so that no vector is read from two.
struct alignas(64) SkinTransform {
  float columns[4][4] = {};  ///< of its rotation, then its shift, metres; the fourth of each is padding
};

/// Linear blend skinning of one frame. All levels of vector instructions give the same bits.
/// @param transforms of each joint. @param rest (V, 3) metres. @param skinned (V, 3) metres, is written
void skin_vertices(const SparseWeights& weights, const SkinTransform* transforms, const float* rest, float* skinned);

}  // namespace inhabit
