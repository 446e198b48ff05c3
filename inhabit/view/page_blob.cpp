#include "inhabit/error.h"
#include "inhabit/view/page_parts.h"

namespace inhabit {

using nlohmann::json;

torch::Tensor plain(const torch::Tensor& t, torch::ScalarType type) {
  return t.detach().to(torch::kCPU, type).contiguous();
}

void require_finite(const torch::Tensor& t, const std::string& path, const std::string& what) {
  if (t.numel() > 0 && !torch::isfinite(t).all().item<bool>())
    throw Error(path, what + " has a number that is not finite");
}

json PageBlob::add_floats(const torch::Tensor& t) {
  const torch::Tensor p = plain(t);
  return add(std::vector<float>(p.data_ptr<float>(), p.data_ptr<float>() + p.numel()), "f32");
}

json PageBlob::add_positions(const torch::Tensor& t) {
  const torch::Tensor p = plain(t).reshape({-1, 3});
  if (p.size(0) == 0) return add(std::vector<uint16_t>(), "u16");
  const torch::Tensor low = std::get<0>(p.min(0)), high = std::get<0>(p.max(0));
  const torch::Tensor step = ((high - low) / 65535.0).clamp_min(1e-9);
  const torch::Tensor q = ((p - low) / step).round().clamp(0, 65535).to(torch::kInt32).contiguous();
  json ref = add(std::vector<uint16_t>(q.data_ptr<int>(), q.data_ptr<int>() + q.numel()), "u16");
  for (int a = 0; a < 3; ++a) {
    ref["min"].push_back(low[a].item<float>());
    ref["scale"].push_back(step[a].item<float>());
  }
  return ref;
}

json PageBlob::add_motion(const torch::Tensor& joints) {
  constexpr double kUnit = 0.001;
  const int64_t frames = joints.size(0);
  const torch::Tensor root = joints.slice(1, 0, 1);
  const torch::Tensor seen = torch::cat({root, joints.slice(1, 1) - root}, 1).flatten(1).t();
  const torch::Tensor steps = (plain(seen, torch::kFloat64) / kUnit).round().clamp(-4e6, 4e6).to(torch::kInt32);
  const torch::Tensor changes = torch::cat({steps.slice(1, 0, 1), steps.diff(1, 1)}, 1).contiguous();
  const int* at = changes.data_ptr<int>();
  std::vector<uint8_t> planes;
  for (const int shift : {0, 8, 16})
    for (int64_t i = 0; i < changes.numel(); ++i) planes.push_back(static_cast<uint8_t>(at[i] >> shift));
  return {{"ref", add(planes, "u8")}, {"unit", kUnit}, {"frames", frames}};
}

json PageBlob::add_units(const torch::Tensor& t) {
  const torch::Tensor q = (plain(t) * 32767.0).round().clamp(-32767, 32767).to(torch::kInt32).contiguous();
  json ref = add(std::vector<int16_t>(q.data_ptr<int>(), q.data_ptr<int>() + q.numel()), "i16");
  ref["min"] = {0.0};
  ref["scale"] = {1.0 / 32767.0};
  return ref;
}

json PageBlob::add_indices(const torch::Tensor& t, int64_t bound) {
  const torch::Tensor p = plain(t, torch::kInt64);
  const int64_t* at = p.data_ptr<int64_t>();
  if (bound <= 65536) return add(std::vector<uint16_t>(at, at + p.numel()), "u16");
  return add(std::vector<uint32_t>(at, at + p.numel()), "u32");
}

}  // namespace inhabit
