#pragma once
#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "inhabit/math/random.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/synth/furniture.h"

namespace inhabit::furniture {

/// Linear red, green and blue, each in [0, 1].
using Color = std::array<float, 3>;

// Linear RGB.
/// Colours of wood, bare or painted.
inline constexpr std::array<Color, 6> kWoods = {{{0.50F, 0.31F, 0.15F},
                                                 {0.20F, 0.10F, 0.05F},
                                                 {0.63F, 0.44F, 0.25F},
                                                 {0.74F, 0.72F, 0.68F},
                                                 {0.05F, 0.05F, 0.055F},
                                                 {0.33F, 0.17F, 0.08F}}};
/// Colours of covers and cushions.
inline constexpr std::array<Color, 9> kFabrics = {{{0.06F, 0.22F, 0.24F},
                                                   {0.58F, 0.34F, 0.06F},
                                                   {0.27F, 0.28F, 0.30F},
                                                   {0.05F, 0.09F, 0.22F},
                                                   {0.45F, 0.13F, 0.06F},
                                                   {0.22F, 0.31F, 0.19F},
                                                   {0.66F, 0.57F, 0.44F},
                                                   {0.25F, 0.08F, 0.16F},
                                                   {0.42F, 0.50F, 0.55F}}};
/// Colour of metal legs and frames.
inline constexpr Color kSteel = {0.16F, 0.165F, 0.17F};
/// Colour of bed linen.
inline constexpr Color kLinen = {0.78F, 0.75F, 0.69F};

/// One of some colours, each as likely; `colors` must outlive the reference.
template <size_t N>
const Color& pick(std::mt19937_64& random, const std::array<Color, N>& colors) {
  return colors[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(N) - 1))];
}

/// A piece being built: every solid is a box for collisions and a shape of the same size to look at.
class Builder {
 public:
  /// @param kind Furniture::kind
  explicit Builder(const std::string& kind) { piece_.kind = kind; }
  /// A box from corner to corner, rounded to look at (MeshBuilder::box).
  void solid(const Color& color, const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius = 0.006,
             int steps = 1) {
    const Eigen::Vector3d center = (low + high) / 2, half = (high - low) / 2;
    piece_.boxes.push_back({center, half});
    shapes(color).box(center, half, radius, steps);
  }
  /// An upright leg with its foot at (x, z): a box to collide with, tapered or square to look at.
  void leg(const Color& color, double x, double z, double top, double half, bool round) {
    const Eigen::Vector3d low(x - half, 0, z - half), high(x + half, top, z + half);
    if (!round) return solid(color, low, high, 0.004);
    piece_.boxes.push_back({(low + high) / 2, (high - low) / 2});
    shapes(color).column({x, 0, z}, 0, top, 0.7 * half, half);
  }
  /// A rectangle that people use.
  void surface(Surface::Kind kind, double x0, double x1, double z0, double z1, double height) {
    piece_.surfaces.push_back({kind, {(x0 + x1) / 2, height, (z0 + z1) / 2}, (x1 - x0) / 2, (z1 - z0) / 2});
  }
  /// @param height of the back rest's top @param z of its front face
  void back(double height, double z) {
    piece_.back_height = height;
    piece_.back_z = z;
  }
  /// The piece; the builder is used up.
  Furniture finish() {
    for (const auto& [color, builder] : materials_) piece_.meshes.push_back(builder.mesh(piece_.kind, color));
    return std::move(piece_);
  }

 private:
  MeshBuilder& shapes(const Color& color) {
    for (auto& [c, builder] : materials_)
      if (c == color) return builder;
    return materials_.emplace_back(color, MeshBuilder()).second;
  }
  Furniture piece_;
  std::vector<std::pair<Color, MeshBuilder>> materials_;
};

}  // namespace inhabit::furniture
