#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "inhabit/interact/chair.h"
#include "inhabit/interact/config.h"
#include "inhabit/scene/distance_field.h"
#include "inhabit/scene/free_space.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// A place on the floor and a direction there: the root frame of a person, the frame of a goal. In its axes +Z is
/// ahead, +X to the left, +Y up, the origin on the floor.
struct Place {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< world (x, z), metres
  Eigen::Vector2f facing{0, 1};                        ///< unit, (x, z)

  /// A world direction (x, z) in its axes.
  Eigen::Vector2f turned_in(const Eigen::Vector2f& v) const {
    return {facing.y() * v.x() - facing.x() * v.y(), facing.x() * v.x() + facing.y() * v.y()};
  }
  /// The way back.
  Eigen::Vector2f turned_out(const Eigen::Vector2f& v) const {
    return {facing.y() * v.x() + facing.x() * v.y(), -facing.x() * v.x() + facing.y() * v.y()};
  }
  /// A world direction in its axes.
  Eigen::Vector3f turned_in(const Eigen::Vector3f& v) const {
    const Eigen::Vector2f g = turned_in(Eigen::Vector2f(v.x(), v.z()));
    return {g.x(), v.y(), g.y()};
  }
  /// The way back.
  Eigen::Vector3f turned_out(const Eigen::Vector3f& v) const {
    const Eigen::Vector2f g = turned_out(Eigen::Vector2f(v.x(), v.z()));
    return {g.x(), v.y(), g.y()};
  }
  /// Its position in the world, on the floor y = 0.
  Eigen::Vector3f origin() const { return {position.x(), 0, position.y()}; }
  /// A world point in the axes of this place.
  Eigen::Vector3f in(const Eigen::Vector3f& p) const { return turned_in(Eigen::Vector3f(p - origin())); }
  /// The way back.
  Eigen::Vector3f out(const Eigen::Vector3f& p) const { return origin() + turned_out(p); }
};

/// The chair as N x N x N voxels of its box in its own frame, y outermost, then x, z. Sensed once for a chair.
struct ChairGrid {
  std::vector<Eigen::Vector3f> centres;  ///< world, metres
  std::vector<float> values;  ///< 1 - distance / longest side for what lies within the cell, else 0; inside 1
  Place seat;                 ///< the chair's frame on the floor
};
/// Voxels of a chair: config.chair_grid cells a side over the box of its mesh.
ChairGrid sense_chair(const Chair& chair, const Config& config);

/// Position in the axes of `root`, then value, of every voxel: 4 N^3 numbers. Allocates nothing.
void chair_around(const ChairGrid& grid, const Place& root, float* out);

/// What a person may run into: everything in a scene but floors and rugs, and the
/// floor y = 0 of a scan, whatever its name. Distances come from a field whose cells are
/// sampled when they are first needed, or by prepare(); nothing is allocated afterwards. Safe to use from several
/// threads.
class Surroundings {
 public:
  /// @param cell metres, of the field.
  explicit Surroundings(const Scene& scene, double cell = 0.05);
  ~Surroundings();
  Surroundings(Surroundings&&) noexcept;  ///< what was moved from may only be destroyed
  /// The image in the plane x = 0, which shares the field.
  Surroundings mirrored() const;

  Surroundings& operator=(Surroundings&&) noexcept;  ///< likewise

  /// Metres from a world point to the nearest surface, 0 inside, and `reach` where it is farther than that.
  float distance(const Eigen::Vector3f& point, float reach) const;
  /// False where no object is within `reach` metres of a vertical cylinder around (x, z).
  bool anything_near(const Eigen::Vector2f& position, float radius) const;
  /// Computes what distance() needs up to 2 m over the floor, which else takes time where somebody first comes. @param
  /// stopped as of DistanceField::sample
  void prepare(const std::function<bool()>& stopped = {}) const;
  /// The floor between it, computed when it is first asked for. That of the scene as given, also where this is an
  /// image.
  const FreeSpace& floor() const;

 private:
  struct Impl;
  explicit Surroundings(std::shared_ptr<const Impl> impl, float side) : impl_(std::move(impl)), side_(side) {}
  std::shared_ptr<const Impl> impl_;
  float side_ = 1;  // -1 for the image
};

/// The cylindrical ego-centric grid: points of concentric rings, layer upon layer, relative to the root.
class EgoGrid {
 public:
  static constexpr double kSize = 4.0;  ///< metres across the outermost ring
  /// Of config.ego_rings and config.ego_layers.
  explicit EgoGrid(const Config& config);
  const std::vector<Eigen::Vector3f>& points() const { return points_; }  ///< in the root's axes, metres
  float radius() const { return radius_; }                                ///< of a point's sphere, metres

  /// 1 - distance / radius within the sphere of each point, else 0; 1 inside. Allocates nothing.
  void sense(const Surroundings& around, const Place& root, float* out) const;

 private:
  std::vector<Eigen::Vector3f> points_;
  float radius_ = 0, reach_ = 0;
};

}  // namespace inhabit::interact
