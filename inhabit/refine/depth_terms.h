#pragma once
#include <torch/types.h>

#include <array>
#include <memory>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/refine/problem.h"
#include "inhabit/refine/terms.h"
#include "inhabit/scene/query.h"

namespace inhabit::refine {

/// The skin of a body on the standard joints: what hangs on others (fingers, face) moves with the nearest standard
/// joint above. A vertex x at rest goes to sum_a w_a (p_a + R_a (x - j_a)), j_a the body's own joints at rest, p_a
/// those of the skeleton that is posed, which need not be as long: linear blend skinning where it is.
struct Skin {
  /// A joint's part of a vertex.
  struct Weight {
    int joint;      ///< of the standard skeleton
    double weight;  ///< w_a, not 0; those of a vertex add up to 1
  };
  std::vector<Eigen::Vector3d> rest;      ///< (V) metres
  std::vector<Eigen::Vector3d> joints;    ///< (22) metres
  std::vector<int> first;                 ///< vertex v has weights [first[v], first[v + 1])
  std::vector<Weight> weights;            ///< of all vertices, one after the other
  std::vector<std::array<int, 3>> faces;  ///< vertices of each triangle
  std::vector<int> first_face;            ///< vertex v is in vertex_faces [first_face[v], first_face[v + 1])
  std::vector<int> vertex_faces;          ///< numbers of the faces at each vertex, one vertex after the other
  Eigen::MatrixXf pose_dirs;              ///< (3 V, 189) of rotations 1 to 21, row by row; empty: none

  /// V, how many vertices there are.
  int64_t size() const { return static_cast<int64_t>(rest.size()); }
};

/// @param betas (B) shape, or undefined
Skin skin_of(const BodyModel& model, const torch::Tensor& betas);

/// The shape of the body that a clip on the standard skeleton shows: the clip's own betas, where they are of this
/// model, else undefined. Those of another model than the built-in one must explain the clip's bones.
torch::Tensor shape_in(const Clip& clip, const BodyModel& body);

/// Vertices of the skin in a pose.
struct PosedSkin {
  std::vector<Eigen::Vector3d> rest;  ///< (V) metres, where they are before skinning, the pose's blend shapes included
  std::vector<Eigen::Vector3d> vertices;  ///< (V) metres, world
};
/// Poses a skin by linear blend skinning.
/// @param bones the same pose by forward kinematics (pose_bones)
PosedSkin pose_skin(const Skin& skin, const FramePose& pose, const BonesPose& bones);

/// A place on the skin.
struct SkinPlace {
  int face = -1;                                    ///< of Skin::faces; -1: none is near, the rest says nothing
  std::array<double, 3> corners{};                  ///< barycentric
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< metres
};

/// The places of a posed skin nearest to points. Faces at the three nearest vertices are looked at, which on a body's
/// mesh is exact but for slivers.
std::vector<SkinPlace> closest_on_skin(const Skin& skin, const PosedSkin& posed,
                                       const std::vector<Eigen::Vector3d>& points);

/// Points seen of the body in one frame.
struct DepthCloud {
  std::vector<Eigen::Vector3d> points;           ///< metres, world: each is pulled to the skin
  std::vector<int> seen;                         ///< vertices of the skin that are pulled to the cloud; may be empty
  std::vector<Eigen::Vector3d> all;              ///< what they are pulled to
  std::shared_ptr<const CloudQuery> all_points;  ///< the same, for the search
};

/// Chamfer distance between point clouds and the skin (forecasting paper, Eq. 15 and 18): weight / 2 times
///   mean over points o of |o - S|^2 + mean over seen vertices v of |v - O|^2,
/// |o - S| the distance to the nearest place of the surface (the paper: the nearest vertex), |v - O| that to the
/// nearest point. Squares are as `loss` has them, and beyond `reach` constant. Nearest places are found anew wherever
/// the term is evaluated, and held for its Jacobian, of which the distance's derivative is exact.
struct DepthTerm {
  std::shared_ptr<const Skin> skin;  ///< on the problem's joints; not null
  std::vector<DepthCloud> clouds;    ///< (frames); a frame without points has no term
  double weight = 1;                 ///< 1 / m^2
  Loss loss;                         ///< of a distance in metres
  double reach = 0.3;                ///< metres
};

/// Every `step`-th vertex of the skin that a camera sees: no other skin is before it. Metres, world.
std::vector<int> seen_vertices(const Skin& skin, const PosedSkin& posed, const Eigen::Vector3d& camera, int step);

/// Adds the term of a frame to its cost, and, where `unknowns` are given, rows of the Jacobian by the main system's
/// unknowns (row by row) and residuals, both times the root of the weight.
void add_depth_rows(const Problem& problem, const Unknowns* unknowns, int64_t frame, const FramePose& pose,
                    const BonesPose& bones, std::vector<double>& values, std::vector<double>& residuals, double& cost);

/// Distances of points to the skin, metres; infinite where no face is near.
std::vector<double> distances_to_skin(const Skin& skin, const FramePose& pose, const Bones& bones,
                                      const std::vector<Eigen::Vector3d>& points);

}  // namespace inhabit::refine
