#pragma once
#include <torch/types.h>

#include <string>
#include <string_view>

namespace inhabit {

/// Vertices of the built-in body that stand for its whole skin (BodyModel::anchors).
inline constexpr int64_t kBuiltinAnchors = 64;

/// What of the built-in body is generated data, made once by scripts/make_body. Shapes as in BodyModel.
struct BuiltinSkin {
  torch::Tensor vertices;    ///< BodyModel::template_vertices
  torch::Tensor faces;       ///< BodyModel::faces
  torch::Tensor weights;     ///< BodyModel::skin_weights, four joints a vertex at most
  torch::Tensor shape_dirs;  ///< BodyModel::shape_dirs
  torch::Tensor anchors;     ///< BodyModel::anchors
};

/// As bytes, little endian: int32 vertices V and faces F; then float32 vertices (V, 3) and shape_dirs (V, 3, B);
/// float32 weights (V, 4), 0 where there are fewer; uint16 faces (F, 3) and anchors (64); uint8 joints of the weights
/// (V, 4).
std::string builtin_skin_bytes(const BuiltinSkin& skin);

/// The same back. Throws Error when the bytes are not that.
BuiltinSkin builtin_skin_from(std::string_view bytes);

/// inhabit/body/builtin_body.bin as it was when the library was built.
std::string_view builtin_body_file();

}  // namespace inhabit
