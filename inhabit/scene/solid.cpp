#include "inhabit/scene/solid.h"

#include <numeric>

namespace inhabit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Vertices at the very same place get the same number.
std::vector<uint32_t> welded(const std::vector<Vector3f>& vertices) {
  std::vector<uint32_t> order(vertices.size()), number(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto before = [&](uint32_t i, uint32_t j) {
    const Vector3f &a = vertices[i], &b = vertices[j];
    if (a.x() != b.x()) return a.x() < b.x();
    if (a.y() != b.y()) return a.y() < b.y();
    return a.z() < b.z();
  };
  std::sort(order.begin(), order.end(), before);
  for (size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    number[order[i]] = same ? number[order[i - 1]] : order[i];
  }
  return number;
}

/// An edge of a face, ends in order; `forward` when the face runs from the lower to the higher end.
struct Edge {
  uint32_t low, high, face;
  bool forward;
};

/// By their ends, then by face.
std::vector<Edge> sorted_edges(const Solid& solid, const std::vector<uint32_t>& number) {
  // Counted into place by their lower end; few share one.
  std::vector<uint32_t> begin(solid.vertices.size() + 1, 0);
  const auto each_edge = [&](const auto& use) {
    for (uint32_t f = 0; f < solid.faces.size(); ++f) {
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t a = number[solid.faces[f][k]], b = number[solid.faces[f][(k + 1) % 3]];
        if (a != b) use(Edge{std::min(a, b), std::max(a, b), f, a < b});
      }
    }
  };
  each_edge([&](const Edge& edge) { ++begin[edge.low + 1]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Edge> edges(begin.back());
  std::vector<uint32_t> end = begin;
  each_edge([&](const Edge& edge) { edges[end[edge.low]++] = edge; });
  for (size_t low = 0; low + 1 < begin.size(); ++low)
    std::sort(edges.begin() + begin[low], edges.begin() + begin[low + 1],
              [](const Edge& x, const Edge& y) { return x.high != y.high ? x.high < y.high : x.face < y.face; });
  return edges;
}

struct Part {
  std::vector<uint32_t> faces;
  bool closed = true;
  double area_kept = 0, area_flipped = 0;
  double volume = 0;  ///< signed, of a closed part
  Vector3f lower = Vector3f::Constant(HUGE_VALF), upper = Vector3f::Constant(-HUGE_VALF);

  bool within(const Part& other) const {
    return (lower.array() >= other.lower.array()).all() && (upper.array() <= other.upper.array()).all();
  }
  bool as_large_as_a_room() const {
    const Vector3f size = upper - lower;
    return size.x() >= 1.5F && size.y() >= 1.8F && size.z() >= 1.5F;
  }
};

/// Connected parts of the surface. Sets `outward` so that neighbours in a part agree.
std::vector<Part> connected_parts(Solid& solid) {
  const std::vector<Edge> edges = sorted_edges(solid, welded(solid.vertices));
  // Up to three neighbours over edges that exactly two faces share: face * 2 + (they disagree).
  constexpr uint32_t none = UINT32_MAX;
  std::vector<std::array<uint32_t, 3>> neighbours(solid.faces.size(), {none, none, none});
  std::vector<bool> at_boundary(solid.faces.size(), false);
  const auto add = [&](uint32_t from, uint32_t to, bool disagree) {
    for (uint32_t& slot : neighbours[from]) {
      if (slot != none) continue;
      slot = to * 2 + (disagree ? 1U : 0U);
      return;
    }
  };
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i == 2 && edges[i].face != edges[i + 1].face) {
      const bool disagree = edges[i].forward == edges[i + 1].forward;
      add(edges[i].face, edges[i + 1].face, disagree);
      add(edges[i + 1].face, edges[i].face, disagree);
    }
    if ((end - i) % 2 != 0) {
      for (size_t k = i; k < end; ++k) at_boundary[edges[k].face] = true;
    }
    i = end;
  }

  std::vector<Part> parts;
  std::vector<uint32_t> open;
  solid.outward.assign(solid.faces.size(), 0);
  for (uint32_t seed = 0; seed < solid.faces.size(); ++seed) {
    if (solid.outward[seed] != 0) continue;
    Part& part = parts.emplace_back();
    solid.outward[seed] = 1;
    open.assign(1, seed);
    while (!open.empty()) {
      const uint32_t face = open.back();
      open.pop_back();
      part.faces.push_back(face);
      part.closed = part.closed && !at_boundary[face];
      const double area = static_cast<double>(solid.normal(face).norm());
      (solid.outward[face] > 0 ? part.area_kept : part.area_flipped) += area;
      for (size_t k = 0; k < 3; ++k) {
        part.lower = part.lower.cwiseMin(solid.corner(face, k));
        part.upper = part.upper.cwiseMax(solid.corner(face, k));
      }
      for (const uint32_t neighbour : neighbours[face]) {
        if (neighbour == none || solid.outward[neighbour / 2] != 0) continue;
        const bool disagree = neighbour % 2 != 0;
        solid.outward[neighbour / 2] = static_cast<int8_t>(disagree ? -solid.outward[face] : solid.outward[face]);
        open.push_back(neighbour / 2);
      }
    }
  }
  return parts;
}

void flip(Solid& solid, Part& part) {
  for (const uint32_t face : part.faces) solid.outward[face] = static_cast<int8_t>(-solid.outward[face]);
  part.volume = -part.volume;
}

}  // namespace

Solid make_solid(const Scene& scene) {
  Solid solid;
  solid.first_face.push_back(0);
  std::vector<int32_t> mesh_of;
  for (const Mesh& mesh : scene.meshes) {
    const torch::Tensor vertices = mesh.vertices.contiguous(), faces = mesh.faces.contiguous();
    const auto first = static_cast<uint32_t>(solid.vertices.size());
    const float* v = vertices.data_ptr<float>();
    const int64_t* f = faces.data_ptr<int64_t>();
    for (int64_t i = 0; i < vertices.size(0); ++i) solid.vertices.emplace_back(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
    for (int64_t i = 0; i < faces.size(0); ++i) {
      solid.faces.push_back({first + static_cast<uint32_t>(f[3 * i]), first + static_cast<uint32_t>(f[3 * i + 1]),
                             first + static_cast<uint32_t>(f[3 * i + 2])});
      mesh_of.push_back(static_cast<int32_t>(solid.first_face.size()) - 1);
    }
    solid.first_face.push_back(static_cast<int64_t>(solid.faces.size()));
  }
  if (scene.points.defined()) {
    const torch::Tensor points = scene.points.contiguous();
    const float* p = points.data_ptr<float>();
    for (int64_t i = 0; i < points.size(0); ++i) solid.points.emplace_back(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
  }

  std::vector<Part> parts = connected_parts(solid);
  std::vector<Part*> closed;
  for (Part& part : parts) {
    if (part.area_flipped > part.area_kept) flip(solid, part);
    if (!part.closed) continue;
    closed.push_back(&part);
    const Vector3d origin = part.lower.cast<double>();
    for (const uint32_t face : part.faces) {
      const Vector3d a = solid.corner(face, 0).cast<double>() - origin,
                     b = solid.corner(face, 1).cast<double>() - origin,
                     c = solid.corner(face, 2).cast<double>() - origin;
      part.volume += solid.outward[face] * a.dot(b.cross(c)) / 6;
    }
  }
  // Largest first, so that what a cavity lies in is known before it.
  std::sort(closed.begin(), closed.end(),
            [](const Part* a, const Part* b) { return std::abs(a->volume) > std::abs(b->volume); });
  solid.body.assign(solid.faces.size(), -1);
  std::vector<std::pair<const Part*, int32_t>> holders;
  for (Part* part : closed) {
    int32_t body = -1;
    if (part->volume < 0) {
      for (const auto& [holder, number] : holders) {
        if (part->within(*holder)) body = number;  // the smallest that holds it comes last
      }
      if (body < 0 && !part->as_large_as_a_room()) flip(solid, *part);
    }
    if (body < 0) body = solid.bodies++;
    if (part->volume > 0) holders.emplace_back(part, body);
    for (const uint32_t face : part->faces) solid.body[face] = body;
  }
  std::vector<int32_t> open_body(scene.meshes.size(), -1);
  for (size_t face = 0; face < solid.faces.size(); ++face) {
    if (solid.body[face] >= 0) continue;
    int32_t& body = open_body[static_cast<size_t>(mesh_of[face])];
    if (body < 0) body = solid.bodies++;
    solid.body[face] = body;
  }
  return solid;
}

}  // namespace inhabit
