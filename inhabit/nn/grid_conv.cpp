#include "inhabit/nn/grid_conv.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <vector>

namespace inhabit::nn {
namespace {

using torch::Tensor;

constexpr int kNeighbours = 27;

/// Voxels (flat, ascending) of one sample (C, G^3) with a channel that is not zero.
std::vector<int32_t> occupied_voxels(const float* x, int64_t channels, int64_t voxels) {
  std::vector<char> occupied(voxels, 0);
  for (int64_t c = 0; c < channels; ++c) {
    const float* row = x + c * voxels;
    for (int64_t v = 0; v < voxels; ++v) occupied[v] |= static_cast<char>(row[v] != 0.0F);
  }
  std::vector<int32_t> list;
  for (int64_t v = 0; v < voxels; ++v) {
    if (occupied[v] != 0) list.push_back(static_cast<int32_t>(v));
  }
  return list;
}

/// (V, C) features of the listed voxels of one sample (C, G^3).
Tensor voxel_rows(const float* x, int64_t channels, int64_t voxels, const std::vector<int32_t>& list) {
  Tensor rows = torch::empty({static_cast<int64_t>(list.size()), channels});
  float* out = rows.data_ptr<float>();
  for (size_t i = 0; i < list.size(); ++i) {
    for (int64_t c = 0; c < channels; ++c) out[i * channels + c] = x[c * voxels + list[i]];
  }
  return rows;
}

/// Calls visit(tap, output voxel) for every output that input voxel `v` reaches: output = v - offset(tap).
template <class Visit>
void for_each_output(int64_t v, int64_t grid, const Visit& visit) {
  const int64_t x = v / (grid * grid), y = v / grid % grid, z = v % grid;
  for (int64_t tap = 0; tap < kNeighbours; ++tap) {
    const int64_t ox = x - (tap / 9 - 1), oy = y - (tap / 3 % 3 - 1), oz = z - (tap % 3 - 1);
    if (ox < 0 || oy < 0 || oz < 0 || ox >= grid || oy >= grid || oz >= grid) continue;
    visit(tap, (ox * grid + oy) * grid + oz);
  }
}

struct GridConvolution : torch::autograd::Function<GridConvolution> {
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& given, const Tensor& weight,
                        const Tensor& bias) {
    const Tensor x = given.detach().contiguous();
    context->save_for_backward({x, weight});
    const int64_t batch = x.size(0), in = x.size(1), grid = x.size(2), out = weight.size(0);
    const int64_t voxels = grid * grid * grid;
    const Tensor taps = weight.detach().permute({1, 2, 3, 4, 0}).reshape({in, kNeighbours * out}).contiguous();
    const Tensor offset = bias.detach().contiguous();
    Tensor result = torch::empty({batch, out, grid, grid, grid}, x.options());
    at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
      torch::NoGradGuard no_gradients;
      for (int64_t b = first; b < last; ++b) {
        const float* sample = x.data_ptr<float>() + b * in * voxels;
        const auto list = occupied_voxels(sample, in, voxels);
        const Tensor products = voxel_rows(sample, in, voxels, list).mm(taps);  // (V, 27 O)
        Tensor sums = offset.repeat({voxels, 1});                               // (G^3, O)
        for (size_t i = 0; i < list.size(); ++i) {
          const float* from = products.data_ptr<float>() + static_cast<int64_t>(i) * kNeighbours * out;
          for_each_output(list[i], grid, [&](int64_t tap, int64_t v) {
            float* to = sums.data_ptr<float>() + v * out;
            for (int64_t c = 0; c < out; ++c) to[c] += from[tap * out + c];
          });
        }
        result[b].view({out, voxels}).copy_(sums.t());
      }
    });
    return result;
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor& x = saved[0];
    const Tensor weight = saved[1].detach();
    const Tensor gradient = gradients[0].contiguous();
    const int64_t batch = x.size(0), in = x.size(1), grid = x.size(2), out = weight.size(0);
    const int64_t voxels = grid * grid * grid;
    const bool wants_x = context->needs_input_grad(0);
    const Tensor back_taps = weight.permute({2, 3, 4, 0, 1}).reshape({kNeighbours * out, in}).contiguous();
    Tensor x_gradient = wants_x ? torch::zeros_like(x) : Tensor();
    Tensor taps_gradient = torch::empty({batch, in, kNeighbours * out}, x.options());
    at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
      torch::NoGradGuard no_gradients;
      for (int64_t b = first; b < last; ++b) {
        const float* sample = x.data_ptr<float>() + b * in * voxels;
        const auto list = occupied_voxels(sample, in, voxels);
        const Tensor rows = gradient[b].view({out, voxels}).t().contiguous();  // (G^3, O)
        Tensor reached = torch::zeros({static_cast<int64_t>(list.size()), kNeighbours * out}, x.options());
        for (size_t i = 0; i < list.size(); ++i) {
          float* to = reached.data_ptr<float>() + static_cast<int64_t>(i) * kNeighbours * out;
          for_each_output(list[i], grid, [&](int64_t tap, int64_t v) {
            const float* from = rows.data_ptr<float>() + v * out;
            std::copy(from, from + out, to + tap * out);
          });
        }
        taps_gradient[b].copy_(voxel_rows(sample, in, voxels, list).t().mm(reached));
        if (!wants_x) continue;
        const Tensor row_gradient = reached.mm(back_taps);  // (V, C)
        float* into = x_gradient.data_ptr<float>() + b * in * voxels;
        for (size_t i = 0; i < list.size(); ++i) {
          const float* from = row_gradient.data_ptr<float>() + static_cast<int64_t>(i) * in;
          for (int64_t c = 0; c < in; ++c) into[c * voxels + list[i]] = from[c];
        }
      }
    });
    const Tensor weight_gradient = taps_gradient.sum(0).view({in, 3, 3, 3, out}).permute({4, 0, 1, 2, 3}).contiguous();
    return {x_gradient, weight_gradient, gradient.sum({0, 2, 3, 4})};
  }
};

}  // namespace

Tensor grid_conv3d(const Tensor& x, const Tensor& weight, const Tensor& bias) {
  if (!x.device().is_cpu() || x.scalar_type() != torch::kFloat32)
    return torch::conv3d(x, weight, bias, /*stride=*/1, /*padding=*/1);
  return GridConvolution::apply(x, weight, bias);
}

Tensor grid_conv3d_over(const Tensor& background, const Tensor& x, const Tensor& weight, const Tensor& bias) {
  const int64_t channels = x.size(1), grid = x.size(2);
  const Tensor constant = background.view({1, channels, 1, 1, 1});
  // A constant 3x3x3 cube has one voxel of every kind; the middle ones stand for all that are inside.
  Tensor pattern = torch::conv3d(constant.expand({1, channels, 3, 3, 3}), weight, {}, /*stride=*/1, /*padding=*/1);
  Tensor kind = torch::ones({grid}, torch::TensorOptions().dtype(torch::kInt64).device(x.device()));
  kind.slice(0, 0, 1).zero_();
  kind.slice(0, grid - 1).fill_(2);
  for (int64_t axis = 2; axis < 5; ++axis) pattern = pattern.index_select(axis, kind);
  return grid_conv3d(x - constant, weight, bias) + pattern;
}

}  // namespace inhabit::nn
