// Makes inhabit/body/builtin_body.bin, the skin of the built-in body: make_body FILE. It takes half a second; the
// library has what comes out instead of these sources.
#include <cstdio>
#include <exception>

#include "inhabit/body/builtin_body_data.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/math/furthest_points.h"
#include "skin.h"

using namespace inhabit;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_body FILE\n");
    return 2;
  }
  try {
    const TriangleSurface surface = builtin_skin();
    BuiltinSkin skin;
    skin.vertices = torch::empty({static_cast<int64_t>(surface.vertices.size()), 3});
    skin.faces = torch::empty({static_cast<int64_t>(surface.faces.size()), 3}, torch::kLong);
    for (size_t v = 0; v < surface.vertices.size(); ++v)
      Eigen::Map<Eigen::Vector3f>(skin.vertices.data_ptr<float>() + 3 * v) = surface.vertices[v].cast<float>();
    for (size_t f = 0; f < surface.faces.size(); ++f)
      for (size_t i = 0; i < 3; ++i)
        skin.faces.data_ptr<int64_t>()[3 * f + i] = surface.faces[f][static_cast<Eigen::Index>(i)];
    skin.weights = builtin_skin_weights(surface);
    skin.shape_dirs = builtin_shape_directions(surface, skin.weights);
    skin.anchors = furthest_point_indices(skin.vertices, kBuiltinAnchors);
    write_atomically(argv[1], builtin_skin_bytes(skin));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "make_body: %s\n", e.what());
    return 2;
  }
  return 0;
}
