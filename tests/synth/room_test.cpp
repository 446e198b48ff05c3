#include "inhabit/synth/room.h"

#include <gtest/gtest.h>

#include <set>

#include "inhabit/math/random.h"
#include "inhabit/synth/room_space.h"

namespace inhabit {
namespace {

// Corners of a box of a piece, in the world.
std::vector<Eigen::Vector3d> corners(const Furniture& piece, const Box& box) {
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < 8; ++i)
    out.push_back(piece.pose * (box.center + box.half.cwiseProduct(
                                                 Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1))));
  return out;
}

TEST(Room, SameSeedSameRoomAndOtherSeedsDiffer) {
  std::mt19937_64 a(7), b(7), c(8);
  const Scene x = make_room(a).scene(), y = make_room(b).scene(), z = make_room(c).scene();
  ASSERT_EQ(x.meshes.size(), y.meshes.size());
  for (size_t i = 0; i < x.meshes.size(); ++i) {
    EXPECT_EQ(x.meshes[i].name, y.meshes[i].name);
    EXPECT_TRUE(torch::equal(x.meshes[i].vertices, y.meshes[i].vertices));
  }
  EXPECT_FALSE(x.meshes[0].vertices.equal(z.meshes[0].vertices));
}

TEST(Room, EverythingIsInsideAndNothingOverlaps) {
  for (uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 random(seed);
    const Room room = make_room(random);
    EXPECT_GE(room.size.minCoeff(), 3.5);
    EXPECT_LE(room.size.maxCoeff(), 8.0);
    for (size_t i = 0; i < room.furniture.size(); ++i) {
      const Furniture& f = room.furniture[i];
      for (const Box& box : f.boxes)
        for (const Eigen::Vector3d& p : corners(f, box)) {
          EXPECT_LE(std::abs(p.x()), room.size.x() / 2 + 1e-9) << "seed " << seed << " " << room.object_name(i);
          EXPECT_LE(std::abs(p.z()), room.size.y() / 2 + 1e-9) << "seed " << seed << " " << room.object_name(i);
          EXPECT_GE(p.y(), -1e-9);
          EXPECT_LE(p.y(), room.height);
        }
      // No sampled point of one piece's solids lies inside another's.
      for (size_t k = 0; k < room.furniture.size(); ++k) {
        if (k == i) continue;
        const Furniture& other = room.furniture[k];
        const Eigen::Isometry3d to_other = other.pose.inverse() * f.pose;
        for (const Box& box : f.boxes)
          for (int n = 0; n < 27; ++n) {
            const Eigen::Vector3d g(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            const Eigen::Vector3d p = to_other * (box.center + box.half.cwiseProduct(g));
            for (const Box& o : other.boxes)
              EXPECT_FALSE(((p - o.center).cwiseAbs().array() < o.half.array() - 1e-6).all())
                  << "seed " << seed << ": " << room.object_name(i) << " in " << room.object_name(k);
          }
      }
    }
  }
}

TEST(Room, EverySeatIsWithinReachOnFoot) {
  for (uint64_t seed = 0; seed < 60; ++seed) {
    std::mt19937_64 random(seed);
    const Room room = make_room(random);
    const FreeSpace space = free_space(room);
    const std::vector<int32_t> region = walkable_regions(space, 0.22);
    int seats = 0;
    for (const Furniture& f : room.furniture)
      for (const Surface& s : f.surfaces) {
        if (s.kind != Surface::Kind::seat) continue;
        ++seats;
        const Eigen::Vector2d p = place_before(f, s), cell = (p - space.origin) / space.cell;
        EXPECT_TRUE(walkable(space, p, 0.22)) << "seed " << seed << " " << f.kind;
        const size_t i = static_cast<size_t>(std::lround(cell.y())) * space.nx + std::lround(cell.x());
        EXPECT_EQ(region.at(i), 1) << "seed " << seed << " " << f.kind;
      }
    EXPECT_GE(seats, 1) << "seed " << seed;
  }
}

TEST(Room, MeshesAgreeWithTheBoxes) {
  std::mt19937_64 random(3);
  std::vector<Furniture> pieces = {make_chair(random),
                                   make_armchair(random),
                                   make_stool(random),
                                   make_sofa(random, 3),
                                   make_office_chair(random, 0.48),
                                   make_solid_chair(random, 0.44),
                                   make_table(random, 1.2, 0.8, 0.74),
                                   make_bed(random),
                                   make_shelf(random)};
  for (const Furniture& f : pieces) {
    Eigen::AlignedBox3d seen;
    for (const Mesh& mesh : f.meshes) {
      const auto v = mesh.vertices.accessor<float, 2>();
      for (int64_t i = 0; i < v.size(0); ++i) {
        const Eigen::Vector3d p(v[i][0], v[i][1], v[i][2]);
        seen.extend(p);
        bool inside = false;
        for (const Box& box : f.boxes) inside |= ((p - box.center).cwiseAbs().array() <= box.half.array() + 1e-5).all();
        EXPECT_TRUE(inside) << f.kind;
      }
    }
    EXPECT_LT((seen.min() - f.bounds().min()).norm() + (seen.max() - f.bounds().max()).norm(), 1e-4) << f.kind;
    // The highest point of the mesh over the middle of each surface is that surface.
    for (const Surface& s : f.surfaces) {
      double top = 0;
      for (const Box& box : f.boxes)
        if (((s.center - box.center).cwiseAbs().array() <= box.half.array() + 1e-9).all())
          top = std::max(top, box.center.y() + box.half.y());
      EXPECT_NEAR(top, s.center.y(), 1e-9) << f.kind;
    }
  }
}

TEST(Room, MeshesAreClosedAndFaceOutwards) {
  std::mt19937_64 random(5);
  const Scene scene = make_room(random).scene();
  for (const Mesh& mesh : scene.meshes) {
    // The signed volume of a closed mesh that faces outwards is that of its shapes.
    const torch::Tensor corners_ =
        mesh.vertices.index_select(0, mesh.faces.reshape({-1})).view({-1, 3, 3}).to(torch::kDouble);
    const torch::Tensor volume =
        (corners_.select(1, 0) * torch::cross(corners_.select(1, 1), corners_.select(1, 2), 1)).sum() / 6;
    EXPECT_GT(volume.item<double>(), 0) << mesh.name;
    const torch::Tensor area =
        torch::cross(corners_.select(1, 1) - corners_.select(1, 0), corners_.select(1, 2) - corners_.select(1, 0), 1);
    EXPECT_LT(area.sum(0).norm().item<double>(), 1e-5) << mesh.name << " is not closed";
  }
}

TEST(Room, RoomsVary) {
  std::set<std::string> kinds;
  std::set<size_t> counts;
  int with_arms = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    const Room room = make_room(random);
    counts.insert(room.furniture.size());
    for (const Furniture& f : room.furniture) {
      kinds.insert(f.kind);
      for (const Surface& s : f.surfaces) with_arms += s.kind == Surface::Kind::arm_rest_left;
    }
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"armchair", "bed", "chair", "shelf", "sofa", "stool", "table"}));
  EXPECT_GE(counts.size(), 6U);
  EXPECT_GT(with_arms, 20);
}

TEST(Furniture, HeightsAreThoseAskedFor) {
  std::mt19937_64 random(1);
  for (const double h : {0.38, 0.45, 0.55}) {
    for (const Furniture& f : {make_chair(random, h), make_armchair(random, h), make_stool(random, h),
                               make_sofa(random, 2, h), make_office_chair(random, h), make_solid_chair(random, h)})
      EXPECT_DOUBLE_EQ(f.surfaces.at(0).center.y(), h) << f.kind;
  }
  for (double h = 0.4; h < 1.65; h += 0.1) {
    const Furniture shelf = make_shelf(random, h);
    EXPECT_TRUE(std::any_of(shelf.surfaces.begin(), shelf.surfaces.end(), [&](const Surface& s) {
      return std::abs(s.center.y() - h) < 1e-9;
    })) << h;
  }
}

TEST(FreeSpace, ClearanceIsTheDistanceToTheNearestSolid) {
  Room room;
  room.size = {4, 4};
  Furniture block;
  block.boxes.push_back({{0, 0.5, 0}, {0.5, 0.5, 0.25}});
  block.place(0.5, 0, M_PI / 2);  // now 0.25 along x and 0.5 along z
  room.furniture.push_back(block);
  const FreeSpace space = free_space(room);
  EXPECT_NEAR(space.at({1.25, 0}), 0.5, 1e-5);
  EXPECT_NEAR(space.at({1.05, 0.9}), std::hypot(0.3, 0.4), 0.01);
  EXPECT_NEAR(space.at({-1.8, 0}), 0.2, 1e-5);
  EXPECT_LT(space.at({0.5, 0}), 0);
  EXPECT_LT(space.at({3, 0}), 0);
  EXPECT_GT(space.away({1.25, 0}).x(), 0.99);
}

}  // namespace
}  // namespace inhabit
