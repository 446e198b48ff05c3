#include "inhabit/reconstruct/rendered.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/png_mask.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/nn/random_tensor.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/sampling.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

constexpr double kEdgeJump = 0.05;  // part of the depth: networks smear what jumps more

/// A camera's pose at `eye` that looks at `target`.
Eigen::Isometry3d looking(const Vector3d& eye, const Vector3d& target) {
  const Vector3d ahead = (target - eye).normalized(), right = ahead.cross(Vector3d::UnitY()).normalized();
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear().col(0) = right;
  out.linear().col(1) = ahead.cross(right);
  out.linear().col(2) = ahead;
  out.translation() = eye;
  return out;
}

/// Everything that images are made of.
struct Film {
  Camera camera;
  Scene room;
  Tensor skins;                      // (T, V, 3)
  Tensor rays;                       // (pixels, 3) directions in the world, z = 1 in the camera
  Tensor room_depth, room_mesh;      // (pixels)
  std::vector<std::string> objects;  // name of each of the room's meshes
  KnownErrors errors;
  uint64_t seed = 1;

  struct Frame {
    Tensor depth, person;  // (height, width) metres; bool
  };

  Frame frame(size_t t) const {
    Scene body;
    body.meshes.push_back({"body", skins[static_cast<int64_t>(t)], builtin_body().faces, {}});
    const RayHits hits = SceneQuery(body).cast(eyes(), rays);
    const Tensor depth = hits.distances / rays.norm(2, {1}), before = depth.lt(room_depth);
    return {torch::where(before, depth, room_depth).view({camera.height, camera.width}),
            before.view({camera.height, camera.width})};
  }

  Tensor eyes() const {
    const Vector3d eye = camera.to_world[0].translation();
    return torch::tensor({eye.x(), eye.y(), eye.z()}).to(torch::kFloat32).expand_as(rays);
  }

  /// (K, height, width) as networks tell it.
  Tensor maps(size_t t) const {
    const Frame seen = frame(t);
    std::mt19937_64 random(item_seed(seed, t));
    const Tensor warp = torch::upsample_bilinear2d(
        nn::normal_tensor(random, {1, 1, 4, 5}), {camera.height, camera.width}, true, c10::nullopt, c10::nullopt)[0][0];
    const Tensor wide = seen.depth.view({1, 1, camera.height, camera.width});
    const Tensor far = torch::max_pool2d(wide, {3, 3}, {1, 1}, {1, 1})[0][0],
                 near = -torch::max_pool2d(-wide, {3, 3}, {1, 1}, {1, 1})[0][0];
    const Tensor edge = (far - near).gt(kEdgeJump * near);
    std::vector<Tensor> out;
    for (int k = 0; k < errors.maps; ++k) {
      const Tensor mix = uniforms(random, {camera.height, camera.width});
      const Tensor smeared = torch::where(edge, near + mix * (far - near), seen.depth);
      const Tensor wrong = errors.noise * nn::normal_tensor(random, {camera.height, camera.width}) + errors.warp * warp;
      out.push_back((smeared * (1 + wrong) - errors.offset) / errors.scale);
    }
    return torch::stack(out).to(torch::kFloat32).contiguous();
  }

  Tensor object_mask(const std::string& name, size_t t) const {
    std::vector<int64_t> own;
    for (size_t m = 0; m < objects.size(); ++m)
      if (objects[m] == name) own.push_back(static_cast<int64_t>(m));
    const Tensor is = torch::isin(room_mesh, torch::tensor(own)).view({camera.height, camera.width});
    return is.logical_and(frame(t).person.logical_not());
  }

  static Tensor uniforms(std::mt19937_64& random, at::IntArrayRef sizes) {
    Tensor out = torch::empty(sizes);
    float* x = out.data_ptr<float>();
    for (int64_t i = 0; i < out.numel(); ++i) x[i] = static_cast<float>(uniform(random, 0, 1));
    return out;
  }
};

/// The place, of corners and walls' middles, from which most of the body is seen.
Eigen::Isometry3d camera_pose(const Room& room, const SceneQuery& query, const Tensor& anchors, const Camera& lens) {
  const Tensor flat = anchors.flatten(0, 1);
  const Tensor middle = flat.mean(0);
  const Vector3d target(middle[0].item<double>(), 0.8, middle[2].item<double>());
  const double x = room.size.x() / 2 - 0.3, z = room.size.y() / 2 - 0.3, y = std::min(1.9, room.height - 0.3);
  Eigen::Isometry3d best = Eigen::Isometry3d::Identity();
  double most = -1;
  for (const auto& [px, pz] :
       std::vector<std::pair<double, double>>{{x, z}, {-x, z}, {x, -z}, {-x, -z}, {x, 0}, {-x, 0}, {0, z}, {0, -z}}) {
    const Vector3d eye(px, y, pz);
    if (query.signed_distance(point_rows({eye}))[0].item<float>() < 0.1F) continue;
    const Eigen::Isometry3d pose = looking(eye, target), back = pose.inverse();
    const Tensor from = point_rows({eye}).expand_as(flat), rays = flat - from;
    const Tensor free = query.cast(from, rays).distances.gt(rays.norm(2, {1}) - 0.02);
    const auto f = flat.accessor<float, 2>();
    const auto clear = free.accessor<bool, 1>();
    double seen = 0, near = HUGE_VAL;
    for (int64_t i = 0; i < flat.size(0); ++i) {
      const Vector3d at(f[i][0], f[i][1], f[i][2]);
      near = std::min(near, (at - eye).norm());
      if (clear[i] && project(lens, back, at).inside()) seen += 1;
    }
    if (near > 0.8 && seen > most) most = seen, best = pose;
  }
  if (most < 0) throw Error("room", "has no place for a camera");
  return best;
}

/// How much of what an object alone would show the camera is seen of it in the room.
double seen_part(const Scene& room, const SceneQuery& query, const std::string& name, const Camera& camera) {
  Scene alone;
  for (const Mesh& mesh : room.meshes)
    if (object_of_mesh(mesh.name) == name) alone.meshes.push_back(mesh);
  std::mt19937_64 random(1);
  const Tensor points = sample_points(alone, 1000, random),
               from = point_rows({camera.to_world[0].translation()}).expand_as(points), rays = points - from;
  const Tensor away = rays.norm(2, {1}) - 0.02;
  const Tensor shown = SceneQuery(alone).cast(from, rays).distances.gt(away),
               seen = query.cast(from, rays).distances.gt(away);
  const Eigen::Isometry3d to_camera = camera.to_world[0].inverse();
  const auto p = points.accessor<float, 2>();
  double all = 0, own = 0;
  for (int64_t i = 0; i < points.size(0); ++i) {
    if (!shown[i].item<bool>()) continue;
    all += 1;
    if (seen[i].item<bool>() && project(camera, to_camera, {p[i][0], p[i][1], p[i][2]}).inside()) own += 1;
  }
  return all > 0 ? own / all : 0;
}

/// The estimate that a network would have made.
Clip estimated(const Clip& truth, const Camera& camera, const KnownErrors& errors, std::mt19937_64& random) {
  Clip out = person_of(truth);
  out.rotations = truth.rotations.clone();
  out.trans = truth.trans.clone();
  auto rotations = out.rotations.accessor<float, 3>();
  auto trans = out.trans.accessor<float, 2>();
  const double phase = uniform(random, 0, 2 * M_PI), period = uniform(random, 2, 4);
  const Vector3d eye = camera.to_world[0].translation();
  for (int64_t t = 0; t < truth.frames(); ++t) {
    const Vector3d place(trans[t][0], trans[t][1], trans[t][2]), along = (place - eye).normalized();
    const double seconds = static_cast<double>(t) / truth.rate;
    const double far =
        errors.root_along * normal(random) + errors.drift * std::sin(phase + 2 * M_PI * seconds / period);
    Vector3d across(normal(random), normal(random), normal(random));
    across -= across.dot(along) * along;
    const Vector3d wrong = far * along + errors.root_across * across;
    for (int i = 0; i < 3; ++i) trans[t][i] += static_cast<float>(wrong[i]);
    for (int64_t j = 0; j < rotations.size(1); ++j)
      for (int64_t i = 0; i < 3; ++i)
        rotations[t][j][i] += static_cast<float>(errors.pose * M_PI / 180 * normal(random));
  }
  out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
  return out;
}

/// A piece of furniture as another network would have made it: another unit, rotated, shifted.
void add_object(const Furniture& piece, const std::string& name, std::mt19937_64& random, Rendered& out) {
  const double unit = uniform(random, 0.3, 2), yaw = uniform(random, -M_PI, M_PI);
  const Vector3d shift(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
  const Placement to_own{unit, yaw, shift};
  ObjectInput object;
  object.name = name;
  for (Mesh mesh : piece.meshes) {
    mesh.vertices = mesh.vertices.clone();
    auto v = mesh.vertices.accessor<float, 2>();
    for (int64_t i = 0; i < v.size(0); ++i) {
      const Vector3d at = to_own.place({v[i][0], v[i][1], v[i][2]});
      for (int c = 0; c < 3; ++c) v[i][c] = static_cast<float>(at[c]);
    }
    object.meshes.push_back(std::move(mesh));
  }
  const Vector3d ahead = piece.pose.linear() * Vector3d::UnitZ();
  TrueObject truth{name, {1 / unit, std::atan2(ahead.x(), ahead.z()) - yaw, Vector3d::Zero()}};
  truth.placement.shift = piece.pose.translation() - truth.placement.place(shift);
  out.objects.push_back(truth);
  out.inputs.objects.push_back(std::move(object));
}

}  // namespace

Rendered render_life(const Room& room, const Clip& life, const RenderOptions& options, uint64_t seed) {
  std::mt19937_64 random(seed);
  Rendered out;
  out.truth = life;
  out.room = room.scene();
  out.errors = options.errors;
  auto film = std::make_shared<Film>();
  film->room = out.room;
  film->errors = options.errors;
  film->seed = seed;
  film->skins = skin_points(life, builtin_body());
  for (const Mesh& mesh : out.room.meshes) film->objects.push_back(object_of_mesh(mesh.name));

  Camera& camera = film->camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = 0.5 * static_cast<double>(options.width) / std::tan(options.field * M_PI / 360);
  camera.cx = 0.5 * static_cast<double>(options.width - 1);
  camera.cy = 0.5 * static_cast<double>(options.height - 1);
  const SceneQuery query(out.room);
  const Tensor every = torch::arange(0, life.frames(), std::max<int64_t>(1, life.frames() / 12));
  const Tensor anchors = film->skins.index_select(0, every).index_select(1, builtin_body().anchors);
  camera.to_world = {camera_pose(room, query, anchors, camera)};

  std::vector<Vector3d> rays;
  rays.reserve(static_cast<size_t>(camera.width * camera.height));
  for (int64_t row = 0; row < camera.height; ++row)
    for (int64_t column = 0; column < camera.width; ++column)
      rays.emplace_back(camera.to_world[0].linear() *
                        camera.ray(static_cast<double>(column), static_cast<double>(row)));
  film->rays = point_rows(rays);
  const RayHits hits = query.cast(film->eyes(), film->rays);
  // Out of a window and up into the sky: far away.
  const Tensor lengths = film->rays.norm(2, {1});
  film->room_depth = torch::where(hits.hit, hits.distances / lengths, torch::full_like(lengths, 12));
  film->room_mesh = hits.mesh;

  std::vector<int64_t> frames(static_cast<size_t>(life.frames()));
  for (size_t t = 0; t < frames.size(); ++t) frames[t] = static_cast<int64_t>(t);
  out.inputs.camera = camera;
  out.inputs.motion = estimated(life, camera, options.errors, random);
  out.inputs.depth = {"depth", frames, false, [film](size_t t) { return film->maps(t); }};
  out.inputs.masks = {"mask", frames, false, [film](size_t t) { return film->frame(t).person; }};
  for (size_t i = 0; i < room.furniture.size(); ++i) {
    const std::string name = room.object_name(i);
    if (film->object_mask(name, 0).sum().item<int64_t>() < options.fewest_pixels ||
        seen_part(out.room, query, name, camera) < options.least_seen)
      continue;
    add_object(room.furniture[i], name, random, out);
    out.inputs.objects.back().masks = {name, frames, false,
                                       [film, name](size_t t) { return film->object_mask(name, t); }};
  }
  return out;
}

void write_rendered(const Rendered& rendered, const std::string& folder) {
  namespace fs = std::filesystem;
  const Inputs& in = rendered.inputs;
  fs::create_directories(fs::path(folder) / "objects");
  fs::create_directories(fs::path(folder) / "object_masks");
  const auto at = [&](const std::string& name) { return (fs::path(folder) / name).string(); };
  write_clip(at("estimated.npz"), in.motion);
  write_clip(at("truth.npz"), rendered.truth);
  write_scene(at("room.glb"), rendered.room);
  write_atomically(at("camera.json"), camera_json(in.camera));
  for (size_t i = 0; i < in.depth.frames.size(); ++i) {
    write_npy(at(fmt::format("depth_{:06}.npy", in.depth.frames[i])), in.depth.read(i));
    write_mask_png(at(fmt::format("mask_{:06}.png", in.depth.frames[i])), in.masks.read(i));
  }
  for (const ObjectInput& object : in.objects) {
    Scene own;
    own.meshes = object.meshes;
    write_scene(at("objects/" + object.name + ".glb"), own);
    for (size_t i = 0; i < object.masks.frames.size(); i += 10)
      write_mask_png(at(fmt::format("object_masks/{}_{:06}.png", object.name, object.masks.frames[i])),
                     object.masks.read(i));
  }
}

}  // namespace inhabit::reconstruct
