#pragma once
#include <random>

#include "inhabit/scene/scene.h"
#include "inhabit/synth/furniture.h"

/// A floor and pieces of furniture, each with the name of its kind and 0, as rooms have them.
inline inhabit::Scene scene_of(const std::vector<inhabit::Furniture>& pieces) {
  inhabit::Scene scene = inhabit::floor_scene();
  scene.name = "made.glb";
  for (const inhabit::Furniture& piece : pieces)
    for (size_t m = 0; m < piece.meshes.size(); ++m) {
      inhabit::Mesh mesh = piece.meshes[m];
      mesh.name = piece.kind + "_0" + (m == 0 ? "" : "." + std::to_string(m));
      const Eigen::Matrix3f rotation = piece.pose.linear().cast<float>();
      const Eigen::Vector3f shift = piece.pose.translation().cast<float>();
      mesh.vertices = mesh.vertices.clone();
      float* v = mesh.vertices.data_ptr<float>();
      for (int64_t i = 0; i < mesh.vertices.size(0); ++i, v += 3)
        Eigen::Map<Eigen::Vector3f>(v, 3) = rotation * Eigen::Map<Eigen::Vector3f>(v, 3) + shift;
      scene.meshes.push_back(mesh);
    }
  return scene;
}

/// The first surface of a piece that is a seat.
inline inhabit::Surface seat_surface(const inhabit::Furniture& piece) {
  for (const inhabit::Surface& s : piece.surfaces)
    if (s.kind == inhabit::Surface::Kind::seat) return s;
  return {};
}
