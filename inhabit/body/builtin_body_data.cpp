#include "inhabit/body/builtin_body_data.h"

#include <cstring>

#include "inhabit/body/proportions.h"
#include "inhabit/error.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr int64_t kMovers = 4;  // joints that move a vertex, at most

void append(std::string& bytes, const Tensor& t) {
  const Tensor whole = t.contiguous();
  bytes.append(static_cast<const char*>(whole.data_ptr()), whole.nbytes());
}

/// Takes what append() put there.
Tensor taken(std::string_view& bytes, torch::IntArrayRef sizes, torch::ScalarType type) {
  Tensor out = torch::empty(sizes, type);
  if (out.nbytes() > bytes.size()) throw Error("the built-in body", "is cut short");
  std::memcpy(out.data_ptr(), bytes.data(), out.nbytes());
  bytes.remove_prefix(out.nbytes());
  return out;
}

/// Whole numbers up to 65535, which LibTorch has no type for.
Tensor packed(const Tensor& numbers) {
  return torch::where(numbers > INT16_MAX, numbers - (1 << 16), numbers).to(torch::kInt16);
}
Tensor unpacked(const Tensor& numbers) {
  const Tensor whole = numbers.to(torch::kLong);
  return torch::where(whole < 0, whole + (1 << 16), whole);
}

}  // namespace

std::string builtin_skin_bytes(const BuiltinSkin& skin) {
  const auto [weights, joints] = skin.weights.topk(kMovers, 1);
  std::string out;
  append(out, torch::tensor({skin.vertices.size(0), skin.faces.size(0)}, torch::kInt));
  for (const Tensor& t : {skin.vertices, skin.shape_dirs, weights}) append(out, t);
  append(out, packed(skin.faces));
  append(out, packed(skin.anchors));
  append(out, joints.to(torch::kUInt8));
  return out;
}

BuiltinSkin builtin_skin_from(std::string_view bytes) {
  const Tensor counts = taken(bytes, {2}, torch::kInt);
  const int64_t vertices = counts[0].item<int64_t>(), faces = counts[1].item<int64_t>();
  if (vertices < kBuiltinAnchors || vertices > UINT16_MAX || faces < 1 || faces > 2 * vertices)
    throw Error("the built-in body", "has an odd number of vertices or faces");
  BuiltinSkin out;
  out.vertices = taken(bytes, {vertices, 3}, torch::kFloat32);
  out.shape_dirs = taken(bytes, {vertices, 3, static_cast<int64_t>(kBuiltinBetas)}, torch::kFloat32);
  const Tensor weights = taken(bytes, {vertices, kMovers}, torch::kFloat32);
  out.faces = unpacked(taken(bytes, {faces, 3}, torch::kInt16));
  out.anchors = unpacked(taken(bytes, {kBuiltinAnchors}, torch::kInt16));
  const Tensor joints = taken(bytes, {vertices, kMovers}, torch::kUInt8).to(torch::kLong);
  if (!bytes.empty()) throw Error("the built-in body", "goes on behind its end");
  out.weights = torch::zeros({vertices, kStandardJoints}).scatter_(1, joints, weights);
  return out;
}

}  // namespace inhabit
