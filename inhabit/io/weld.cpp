#include "inhabit/io/weld.h"

#include <bit>

namespace inhabit {

Mesh weld(const std::vector<float>& vertices, const std::vector<int64_t>& faces) {
  // An open hash table from places to new numbers, no more than half full.
  const size_t size = std::bit_ceil(2 * std::min(faces.size(), vertices.size() / 3) + 2);
  std::vector<int64_t> table(size, -1), renamed(vertices.size() / 3, -1), out;
  std::vector<float> kept;
  out.reserve(faces.size());
  for (const int64_t index : faces) {
    int64_t& number = renamed[static_cast<size_t>(index)];
    if (number < 0) {
      std::array<float, 3> p{};
      uint64_t hash = 0;
      for (size_t axis = 0; axis < 3; ++axis) {
        p[axis] = vertices[3 * static_cast<size_t>(index) + axis] + 0.F;  // -0 is 0
        hash = (hash ^ std::bit_cast<uint32_t>(p[axis])) * 0x9e3779b97f4a7c15ULL;
        hash ^= hash >> 29;
      }
      size_t slot = hash & (size - 1);
      while (table[slot] >= 0 && !std::equal(p.begin(), p.end(), kept.begin() + 3 * table[slot]))
        slot = (slot + 1) & (size - 1);
      if (table[slot] < 0) {
        table[slot] = static_cast<int64_t>(kept.size() / 3);
        kept.insert(kept.end(), p.begin(), p.end());
      }
      number = table[slot];
    }
    out.push_back(number);
  }
  Mesh mesh;
  mesh.vertices = torch::tensor(kept).view({-1, 3});
  mesh.faces = torch::tensor(out, torch::kInt64).view({-1, 3});
  return mesh;
}

}  // namespace inhabit
