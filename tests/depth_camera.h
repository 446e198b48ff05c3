#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "inhabit/body/kinematics.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/query.h"

/// A degree on every component of the rotations, a centimetre on the root.
inline inhabit::Clip jittered(const inhabit::Clip& clip, double level) {
  torch::manual_seed(4);
  inhabit::Clip out = clip;
  out.rotations = clip.rotations + torch::randn_like(clip.rotations) * (level * M_PI / 180);
  out.trans = clip.trans + torch::randn_like(clip.trans) * (0.01 * level);
  out.joints = inhabit::joint_positions(out.skeleton, out.rotations, out.trans);
  return out;
}

/// What a depth camera of 60 by 80 degrees sees of the body, every 1 / `lines` of the image's height: rays against the
/// skin.
inline torch::Tensor seen_points(const torch::Tensor& skin, const inhabit::BodyModel& body,
                                 const Eigen::Vector3d& camera, const Eigen::Vector3d& target, int lines,
                                 double noise) {
  inhabit::Scene scene;
  scene.meshes.push_back({"body", skin, body.faces, {}});
  const Eigen::Vector3d ahead = (target - camera).normalized(),
                        right = ahead.cross(Eigen::Vector3d::UnitY()).normalized(), up = right.cross(ahead);
  std::vector<float> directions;
  const int columns = lines * 4 / 3;
  for (int y = 0; y < lines; ++y)
    for (int x = 0; x < columns; ++x) {
      const double u = std::tan(40 * M_PI / 180) * (2.0 * (x + 0.5) / columns - 1),
                   v = std::tan(30 * M_PI / 180) * (1 - 2.0 * (y + 0.5) / lines);
      const Eigen::Vector3d d = (ahead + u * right + v * up).normalized();
      for (int i = 0; i < 3; ++i) directions.push_back(static_cast<float>(d[i]));
    }
  const torch::Tensor d = torch::tensor(directions).view({-1, 3});
  const torch::Tensor from = torch::tensor({camera.x(), camera.y(), camera.z()}).to(torch::kFloat32).expand_as(d);
  const inhabit::RayHits hits = inhabit::SceneQuery(scene).cast(from, d);
  const torch::Tensor at = hits.points + d * torch::randn({d.size(0), 1}) * noise;
  return at.index({hits.hit});
}

struct Rendered {
  inhabit::Clip truth;
  std::vector<torch::Tensor> clouds;
  Eigen::Vector3d camera;
};

/// The built-in body in a clip's poses as one camera sees it from 3 m ahead and to the left of where it starts.
inline Rendered rendered(const inhabit::Clip& truth, const Eigen::Vector3d& from, double noise) {
  torch::manual_seed(7);
  Rendered out{truth, {}, Eigen::Vector3d::Zero()};
  const torch::Tensor skins = inhabit::skin_points(truth, inhabit::builtin_body()), path = truth.root_path();
  const torch::Tensor middle = path.mean(0);
  const Eigen::Vector3d target(middle[0].item<double>(), middle[1].item<double>(), middle[2].item<double>());
  out.camera = target + from;
  for (int64_t t = 0; t < truth.frames(); ++t)
    out.clouds.push_back(seen_points(skins[t], inhabit::builtin_body(), out.camera, target, 120, noise));
  return out;
}
