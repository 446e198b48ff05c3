#include "inhabit/data/vposer.h"

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/torch_file.h"
#include "inhabit/math/rotation.h"

namespace inhabit {

torch::Tensor Vposer::decode(const torch::Tensor& codes) const {
  constexpr double kSlope = 0.2;  // of its leaky ReLUs
  torch::Tensor x = codes.to(torch::kFloat32);
  for (int layer = 0; layer < 3; ++layer) {
    x = torch::addmm(bias[layer], x, weight[layer].t());
    if (layer < 2) x = torch::leaky_relu(x, kSlope);
  }
  // A joint's six numbers are the rows of its matrix's first two columns.
  const torch::Tensor columns = x.view({-1, 21, 3, 2}).transpose(2, 3).reshape({-1, 21, 6});
  return matrix_to_axis_angle(rotation6d_to_matrix(columns)).view({-1, 63});
}

Vposer read_vposer(const std::string& path) {
  const Pickle file = parse_torch(read_whole_file(path, uint64_t{1} << 30), path);
  Vposer out;
  const char* names[] = {"bodyprior_dec_fc1", "bodyprior_dec_fc2", "bodyprior_dec_out"};
  int64_t in = 32;
  for (int layer = 0; layer < 3; ++layer) {
    const std::string name = names[layer];
    const auto finite = [&](const char* part) {
      torch::Tensor t = file.numbers_at(*file.root, name + part).contiguous();
      if (!torch::isfinite(t).all().item<bool>()) throw Error(path, name + part + " is not finite");
      return t;
    };
    out.weight[layer] = finite(".weight");
    out.bias[layer] = finite(".bias");
    const torch::Tensor& w = out.weight[layer];
    const bool fits = w.dim() == 2 && w.size(1) == in && out.bias[layer].dim() == 1 &&
                      out.bias[layer].size(0) == w.size(0) && (layer < 2 || w.size(0) == 126);
    if (!fits) throw Error(path, name + " is not as wide as VPoser 1.0 has it");
    in = w.size(0);
  }
  return out;
}

}  // namespace inhabit
