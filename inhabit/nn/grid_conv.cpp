#include "inhabit/nn/grid_conv.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace inhabit::nn {
namespace {

using torch::Tensor;

constexpr int kNeighbours = 27;

/// Voxels of one sample that hold anything (flat, ascending), and their features (V, C).
struct Occupied {
  std::vector<int32_t> voxels;
  Tensor rows;
};

/// @param x (C, G^3). Voxels whose channels are all zero hold nothing.
Occupied occupied_of_grid(const float* x, int64_t channels, int64_t voxels) {
  std::vector<char> full(voxels, 0);
  for (int64_t c = 0; c < channels; ++c) {
    const float* row = x + c * voxels;
    for (int64_t v = 0; v < voxels; ++v) full[v] |= static_cast<char>(row[v] != 0.0F);
  }
  Occupied out;
  for (int64_t v = 0; v < voxels; ++v) {
    if (full[v] != 0) out.voxels.push_back(static_cast<int32_t>(v));
  }
  out.rows = torch::empty({static_cast<int64_t>(out.voxels.size()), channels});
  float* to = out.rows.data_ptr<float>();
  for (size_t i = 0; i < out.voxels.size(); ++i) {
    for (int64_t c = 0; c < channels; ++c) to[i * channels + c] = x[c * voxels + out.voxels[i]];
  }
  return out;
}

/// Rows of the voxels that points lie in, by point, and the voxels as above.
struct PointRows {
  std::vector<int32_t> voxels, row_of_point;

  PointRows(const int64_t* voxel_of_point, int64_t points, int64_t voxel_count) {
    std::vector<int32_t> row(voxel_count, -1);
    for (int64_t n = 0; n < points; ++n) row[voxel_of_point[n]] = 0;
    for (int64_t v = 0; v < voxel_count; ++v) {
      if (row[v] < 0) continue;
      row[v] = static_cast<int32_t>(voxels.size());
      voxels.push_back(static_cast<int32_t>(v));
    }
    row_of_point.reserve(points);
    for (int64_t n = 0; n < points; ++n) row_of_point.push_back(row[voxel_of_point[n]]);
  }
};

constexpr int64_t kBlock = 16;  // channels of a row that are visited together: a line of the cache

/// rows (V, C) += weight[n] x[:, n] at the row of each point. @param x (C, N).
void average_points(const PointRows& at, const float* weight, const float* x, int64_t channels, float* rows) {
  const auto points = static_cast<int64_t>(at.row_of_point.size());
  for (int64_t first = 0; first < channels; first += kBlock) {
    const int64_t last = std::min(channels, first + kBlock);
    for (int64_t n = 0; n < points; ++n) {
      float* row = rows + at.row_of_point[n] * channels;
      for (int64_t c = first; c < last; ++c) row[c] += weight[n] * x[c * points + n];
    }
  }
}

/// Its adjoint: x (C, N) = weight[n] times the row of each point.
void spread_rows(const PointRows& at, const float* weight, const float* rows, int64_t channels, float* x) {
  const auto points = static_cast<int64_t>(at.row_of_point.size());
  for (int64_t first = 0; first < channels; first += kBlock) {
    const int64_t last = std::min(channels, first + kBlock);
    for (int64_t n = 0; n < points; ++n) {
      const float* row = rows + at.row_of_point[n] * channels;
      for (int64_t c = first; c < last; ++c) x[c * points + n] = weight[n] * row[c];
    }
  }
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

/// Weights (O, C, 3, 3, 3) as (C, 27 O) and as (27 O, C).
Tensor taps_of(const Tensor& weight) {
  return weight.detach().permute({1, 2, 3, 4, 0}).reshape({weight.size(1), kNeighbours * weight.size(0)}).contiguous();
}
Tensor back_taps_of(const Tensor& weight) {
  return weight.detach().permute({2, 3, 4, 0, 1}).reshape({kNeighbours * weight.size(0), weight.size(1)}).contiguous();
}
/// The gradient of the weights from that of taps_of(), by sample.
Tensor weight_gradient_of(const Tensor& taps_gradient, int64_t out) {
  return taps_gradient.sum(0).view({taps_gradient.size(1), 3, 3, 3, out}).permute({4, 0, 1, 2, 3}).contiguous();
}

/// (O, G^3) convolution of occupied voxels.
Tensor convolve(const std::vector<int32_t>& voxels, const Tensor& rows, const Tensor& taps, const Tensor& offset,
                int64_t grid) {
  const int64_t out = offset.size(0);
  const Tensor products = rows.mm(taps);                 // (V, 27 O)
  Tensor sums = offset.repeat({grid * grid * grid, 1});  // (G^3, O)
  for (size_t i = 0; i < voxels.size(); ++i) {
    const float* from = products.data_ptr<float>() + static_cast<int64_t>(i) * kNeighbours * out;
    for_each_output(voxels[i], grid, [&](int64_t tap, int64_t v) {
      float* to = sums.data_ptr<float>() + v * out;
      for (int64_t c = 0; c < out; ++c) to[c] += from[tap * out + c];
    });
  }
  return sums.t();
}

/// (V, 27 O): the output's gradient (O, G^3) where each tap of each occupied voxel reaches it.
Tensor reached_gradient(const std::vector<int32_t>& voxels, const Tensor& gradient, int64_t grid) {
  const int64_t out = gradient.size(0);
  const Tensor rows = gradient.t().contiguous();
  Tensor reached = torch::zeros({static_cast<int64_t>(voxels.size()), kNeighbours * out}, gradient.options());
  for (size_t i = 0; i < voxels.size(); ++i) {
    float* to = reached.data_ptr<float>() + static_cast<int64_t>(i) * kNeighbours * out;
    for_each_output(voxels[i], grid, [&](int64_t tap, int64_t v) {
      const float* from = rows.data_ptr<float>() + v * out;
      std::copy(from, from + out, to + tap * out);
    });
  }
  return reached;
}

/// (B, O, G, G, G) sample by sample. @param occupied_of(b) the occupied `voxels` of a sample and their `rows`.
template <class OccupiedOf>
Tensor convolve_samples(int64_t batch, int64_t grid, const Tensor& weight, const Tensor& bias,
                        const OccupiedOf& occupied_of) {
  const int64_t out = weight.size(0);
  const Tensor taps = taps_of(weight), offset = bias.detach().contiguous();
  Tensor result = torch::empty({batch, out, grid, grid, grid}, taps.options());
  at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
    torch::NoGradGuard no_gradients;
    for (int64_t b = first; b < last; ++b) {
      const auto full = occupied_of(b);
      result[b].view({out, -1}).copy_(convolve(full.voxels, full.rows, taps, offset, grid));
    }
  });
  return result;
}

/// The gradients of weights and bias, and of the inputs: spread(b, occupied_of(b), gradient of its rows (V, C)).
/// @param gradient (B, O, G, G, G) of the output.
template <class OccupiedOf, class Spread>
std::pair<Tensor, Tensor> back_through_samples(const Tensor& gradient, const Tensor& weight, bool wants_inputs,
                                               const OccupiedOf& occupied_of, const Spread& spread) {
  const int64_t batch = gradient.size(0), out = gradient.size(1), grid = gradient.size(2), in = weight.size(1);
  const Tensor back_taps = back_taps_of(weight);
  Tensor taps_gradient = torch::empty({batch, in, kNeighbours * out}, gradient.options());
  at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
    torch::NoGradGuard no_gradients;
    for (int64_t b = first; b < last; ++b) {
      const auto full = occupied_of(b);
      const Tensor reached = reached_gradient(full.voxels, gradient[b].view({out, -1}), grid);
      taps_gradient[b].copy_(full.rows.t().mm(reached));
      if (wants_inputs) spread(b, full, reached.mm(back_taps));
    }
  });
  return {weight_gradient_of(taps_gradient, out), gradient.sum({0, 2, 3, 4})};
}

struct GridConvolution : torch::autograd::Function<GridConvolution> {
  /// @param x (B, C, G, G, G), contiguous.
  static auto occupied_of(const Tensor& x) {
    return [&x, in = x.size(1), voxels = x.size(2) * x.size(3) * x.size(4)](int64_t b) {
      return occupied_of_grid(x.data_ptr<float>() + b * in * voxels, in, voxels);
    };
  }

  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& given, const Tensor& weight,
                        const Tensor& bias) {
    const Tensor x = given.detach().contiguous();
    context->save_for_backward({x, weight});
    return convolve_samples(x.size(0), x.size(2), weight, bias, occupied_of(x));
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &x = saved[0], &weight = saved[1];
    const bool wants_x = context->needs_input_grad(0);
    Tensor x_gradient = wants_x ? torch::zeros_like(x) : Tensor();
    const auto spread = [&](int64_t b, const Occupied& full, const Tensor& row_gradient) {
      const int64_t in = x.size(1), voxels = x.size(2) * x.size(3) * x.size(4);
      float* into = x_gradient.data_ptr<float>() + b * in * voxels;
      for (size_t i = 0; i < full.voxels.size(); ++i) {
        const float* from = row_gradient.data_ptr<float>() + static_cast<int64_t>(i) * in;
        for (int64_t c = 0; c < in; ++c) into[c * voxels + full.voxels[i]] = from[c];
      }
    };
    const auto [weight_gradient, bias_gradient] =
        back_through_samples(gradients[0].contiguous(), weight, wants_x, occupied_of(x), spread);
    return {x_gradient, weight_gradient, bias_gradient};
  }
};

/// The same of points that are averaged into voxels: no grid of inputs is ever stored.
struct PointConvolution : torch::autograd::Function<PointConvolution> {
  struct Averaged : PointRows {
    Tensor rows;
  };

  /// @param x (B, C, N) of the points, @param index, point_weight (B, N) the voxel of each and its weight there;
  /// contiguous.
  static auto averaged_of(const Tensor& x, const Tensor& index, const Tensor& point_weight, int64_t voxels) {
    return [&, voxels](int64_t b) {
      const int64_t in = x.size(1), points = x.size(2);
      Averaged full{{index.data_ptr<int64_t>() + b * points, points, voxels}, {}};
      full.rows = torch::zeros({static_cast<int64_t>(full.voxels.size()), in});
      average_points(full, point_weight.data_ptr<float>() + b * points, x.data_ptr<float>() + b * in * points, in,
                     full.rows.data_ptr<float>());
      return full;
    };
  }

  static Tensor forward(torch::autograd::AutogradContext* context, const SparseMap& average, const Tensor& given,
                        const Tensor& weight, const Tensor& bias) {
    const Tensor x = given.detach().contiguous(), index = average.index.contiguous(),
                 point_weight = average.weight.contiguous();
    context->save_for_backward({x, weight, index, point_weight});
    const int64_t grid = std::llround(std::cbrt(static_cast<double>(average.inputs)));
    return convolve_samples(x.size(0), grid, weight, bias, averaged_of(x, index, point_weight, average.inputs));
  }

  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &x = saved[0], &weight = saved[1], &index = saved[2], &point_weight = saved[3];
    const Tensor gradient = gradients[0].contiguous();
    const bool wants_x = context->needs_input_grad(0);
    Tensor x_gradient = wants_x ? torch::empty_like(x) : Tensor();
    const auto spread = [&](int64_t b, const Averaged& full, const Tensor& row_gradient) {
      const int64_t in = x.size(1), points = x.size(2);
      spread_rows(full, point_weight.data_ptr<float>() + b * points, row_gradient.data_ptr<float>(), in,
                  x_gradient.data_ptr<float>() + b * in * points);
    };
    const int64_t voxels = gradient.size(2) * gradient.size(3) * gradient.size(4);
    const auto [weight_gradient, bias_gradient] =
        back_through_samples(gradient, weight, wants_x, averaged_of(x, index, point_weight, voxels), spread);
    return {Tensor(), x_gradient, weight_gradient, bias_gradient};
  }
};

}  // namespace

Tensor grid_conv3d(const Tensor& x, const Tensor& weight, const Tensor& bias) {
  if (!x.device().is_cpu() || x.scalar_type() != torch::kFloat32)
    return torch::conv3d(x, weight, bias, /*stride=*/1, /*padding=*/1);
  return GridConvolution::apply(x, weight, bias);
}

Tensor grid_conv3d_of_points(const SparseMap& average, const Tensor& x, const Tensor& weight, const Tensor& bias) {
  if (x.device().is_cpu() && x.scalar_type() == torch::kFloat32)
    return PointConvolution::apply(average, x, weight, bias);
  const int64_t grid = std::llround(std::cbrt(static_cast<double>(average.inputs)));
  return torch::conv3d(scatter(average, x).view({x.size(0), x.size(1), grid, grid, grid}), weight, bias, /*stride=*/1,
                       /*padding=*/1);
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
