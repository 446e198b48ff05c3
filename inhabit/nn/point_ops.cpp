#include "inhabit/nn/point_ops.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <cmath>
#include <limits>
#include <vector>

#include "inhabit/nn/point_kernel.h"

namespace inhabit::nn {
namespace {

using torch::Tensor;

constexpr float kLeastSquaredDistance = 1e-10F;

bool loops_apply(const Tensor& x) { return x.device().is_cpu(); }

// Rows of features are independent, so threads take rows; work below this many element visits stays on one thread.
int64_t row_grain(int64_t visits_per_row) { return std::max<int64_t>(1, 16384 / std::max<int64_t>(1, visits_per_row)); }

template <class T>
void gather_rows(const T* x, const int64_t* index, const T* weight, T* out, int64_t channels, int64_t inputs,
                 int64_t outputs, int64_t terms, int64_t first_row, int64_t last_row) {
  for (int64_t row = first_row; row < last_row; ++row) {
    const int64_t b = row / channels;
    const T* source = x + row * inputs;
    const int64_t* at = index + b * outputs * terms;
    T* target = out + row * outputs;
    if (weight == nullptr) {
      for (int64_t i = 0; i < outputs; ++i) {
        T sum = 0;
        for (int64_t k = 0; k < terms; ++k) sum += source[at[i * terms + k]];
        target[i] = sum;
      }
    } else {
      const T* w = weight + b * outputs * terms;
      for (int64_t i = 0; i < outputs; ++i) {
        T sum = 0;
        for (int64_t k = 0; k < terms; ++k) sum += w[i * terms + k] * source[at[i * terms + k]];
        target[i] = sum;
      }
    }
  }
}

template <class T>
void scatter_rows(const T* x, const int64_t* index, const T* weight, T* out, int64_t channels, int64_t inputs,
                  int64_t outputs, int64_t terms, int64_t first_row, int64_t last_row) {
  for (int64_t row = first_row; row < last_row; ++row) {
    const int64_t b = row / channels;
    const T* source = x + row * outputs;
    const int64_t* at = index + b * outputs * terms;
    const T* w = weight == nullptr ? nullptr : weight + b * outputs * terms;
    T* target = out + row * inputs;
    for (int64_t i = 0; i < outputs; ++i) {
      for (int64_t k = 0; k < terms; ++k)
        target[at[i * terms + k]] += w == nullptr ? source[i] : w[i * terms + k] * source[i];
    }
  }
}

Tensor gather_plain(const Tensor& x, const Tensor& index, const Tensor& weight) {
  const int64_t batch = x.size(0), channels = x.size(1), inputs = x.size(2), outputs = index.size(1),
                terms = index.size(2);
  if (!loops_apply(x)) {
    Tensor picked = x.gather(2, index.view({batch, 1, outputs * terms}).expand({batch, channels, outputs * terms}))
                        .view({batch, channels, outputs, terms});
    if (weight.defined()) picked = picked * weight.to(x.scalar_type()).unsqueeze(1);
    return picked.sum(3);
  }
  const Tensor source = x.contiguous();
  Tensor out = torch::empty({batch, channels, outputs}, x.options());
  AT_DISPATCH_FLOATING_TYPES(x.scalar_type(), "gather_plain", [&] {
    const Tensor w = weight.defined() ? weight.to(x.scalar_type()).contiguous() : Tensor();
    const scalar_t* weights = w.defined() ? w.data_ptr<scalar_t>() : nullptr;
    at::parallel_for(0, batch * channels, row_grain(outputs * terms), [&](int64_t first, int64_t last) {
      gather_rows<scalar_t>(source.data_ptr<scalar_t>(), index.data_ptr<int64_t>(), weights, out.data_ptr<scalar_t>(),
                            channels, inputs, outputs, terms, first, last);
    });
  });
  return out;
}

Tensor scatter_plain(const Tensor& x, const Tensor& index, const Tensor& weight, int64_t inputs) {
  const int64_t batch = x.size(0), channels = x.size(1), outputs = index.size(1), terms = index.size(2);
  Tensor out = torch::zeros({batch, channels, inputs}, x.options());
  if (!loops_apply(x)) {
    Tensor spread = x.unsqueeze(3).expand({batch, channels, outputs, terms});
    if (weight.defined()) spread = spread * weight.to(x.scalar_type()).unsqueeze(1);
    return out.scatter_add(2, index.view({batch, 1, outputs * terms}).expand({batch, channels, outputs * terms}),
                           spread.reshape({batch, channels, outputs * terms}));
  }
  const Tensor source = x.contiguous();
  AT_DISPATCH_FLOATING_TYPES(x.scalar_type(), "scatter_plain", [&] {
    const Tensor w = weight.defined() ? weight.to(x.scalar_type()).contiguous() : Tensor();
    const scalar_t* weights = w.defined() ? w.data_ptr<scalar_t>() : nullptr;
    at::parallel_for(0, batch * channels, row_grain(outputs * terms), [&](int64_t first, int64_t last) {
      scatter_rows<scalar_t>(source.data_ptr<scalar_t>(), index.data_ptr<int64_t>(), weights, out.data_ptr<scalar_t>(),
                             channels, inputs, outputs, terms, first, last);
    });
  });
  return out;
}

// Each is the other's gradient.
struct GatherFunction : torch::autograd::Function<GatherFunction> {
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& x, const SparseMap& map) {
    context->save_for_backward({map.index, map.weight});
    context->saved_data["inputs"] = x.size(2);
    return gather_plain(x, map.index, map.weight);
  }
  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradient) {
    const auto saved = context->get_saved_variables();
    return {scatter_plain(gradient[0], saved[0], saved[1], context->saved_data["inputs"].toInt()), Tensor()};
  }
};

struct ScatterFunction : torch::autograd::Function<ScatterFunction> {
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& x, const SparseMap& map) {
    context->save_for_backward({map.index, map.weight});
    return scatter_plain(x, map.index, map.weight, map.inputs);
  }
  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradient) {
    const auto saved = context->get_saved_variables();
    return {gather_plain(gradient[0], saved[0], saved[1]), Tensor()};
  }
};

/// (B, M, N) squared distances from centres to points.
Tensor squared_distances(const Tensor& points, const Tensor& centres) {
  const auto axis = [&](int64_t i) {
    return (centres.select(2, i).unsqueeze(2) - points.select(2, i).unsqueeze(1)).square();
  };
  return axis(0) + axis(1) + axis(2);
}

}  // namespace

Tensor gather(const SparseMap& map, const Tensor& x) { return GatherFunction::apply(x, map); }

Tensor scatter(const SparseMap& map, const Tensor& x) { return ScatterFunction::apply(x, map); }

Tensor voxel_coordinates(const Tensor& points, int64_t grid) {
  torch::NoGradGuard no_gradients;
  const Tensor centred = points - points.mean(1, true);
  // A cloud of one place would divide by zero: any positive scale puts it in the middle.
  const Tensor scale = centred.square().sum(2, true).sqrt().amax(1, true).mul(2).clamp_min(1e-30);
  return ((centred / scale + 0.5) * static_cast<double>(grid)).clamp(0.0, static_cast<double>(grid - 1)).contiguous();
}

SparseMap voxel_average(const Tensor& coordinates, int64_t grid) {
  torch::NoGradGuard no_gradients;
  const Tensor nearest = coordinates.round().to(torch::kInt64);
  const Tensor voxel = ((nearest.select(2, 0) * grid + nearest.select(2, 1)) * grid + nearest.select(2, 2));
  const int64_t voxels = grid * grid * grid;
  Tensor count = torch::zeros({coordinates.size(0), voxels}, coordinates.options());
  count.scatter_add_(1, voxel, torch::ones_like(voxel, coordinates.options()));
  return {voxel.unsqueeze(2).contiguous(), count.gather(1, voxel).reciprocal().unsqueeze(2).contiguous(), voxels};
}

SparseMap voxel_interpolation(const Tensor& coordinates, int64_t grid) {
  torch::NoGradGuard no_gradients;
  const Tensor low = coordinates.floor();
  const Tensor part = coordinates - low;
  const Tensor from = low.to(torch::kInt64);
  const Tensor to = (from + 1).clamp_max(grid - 1);  // at the border the weight of `to` is 0
  std::vector<Tensor> index, weight;
  for (int corner = 0; corner < 8; ++corner) {
    Tensor place = torch::zeros_like(from.select(2, 0));
    Tensor product = torch::ones_like(part.select(2, 0));
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = ((corner >> (2 - axis)) & 1) != 0;
      place = place * grid + (high ? to : from).select(2, axis);
      product = product * (high ? part.select(2, axis) : 1 - part.select(2, axis));
    }
    index.push_back(place);
    weight.push_back(product);
  }
  return {torch::stack(index, 2), torch::stack(weight, 2), grid * grid * grid};
}

Tensor furthest_points(const Tensor& points, int64_t count) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = points.size(0), total = points.size(1);
  if (!loops_apply(points)) {
    Tensor distance = torch::full({batch, total}, std::numeric_limits<float>::max(), points.options());
    Tensor last = torch::zeros({batch}, points.options().dtype(torch::kInt64));
    std::vector<Tensor> chosen{last};
    for (int64_t i = 1; i < count; ++i) {
      const Tensor from = select_points(points, last.unsqueeze(1));
      distance = torch::minimum(distance, squared_distances(points, from).squeeze(1));
      last = distance.argmax(1);
      chosen.push_back(last);
    }
    return torch::stack(chosen, 1);
  }
  const Tensor source = points.contiguous();
  Tensor chosen = torch::empty({batch, count}, torch::kInt64);
  at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
    for (int64_t b = first; b < last; ++b)
      furthest_points_of_cloud(PointArrays(source.data_ptr<float>() + b * total * 3, total), count,
                               chosen.data_ptr<int64_t>() + b * count);
  });
  return chosen;
}

Tensor ball_neighbours(const Tensor& points, const Tensor& centres, double radius, int64_t neighbours) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = points.size(0), total = points.size(1), count = centres.size(1);
  const auto reach = static_cast<float>(radius) * static_cast<float>(radius);
  if (!loops_apply(points)) {
    const Tensor order = torch::arange(total, points.options().dtype(torch::kInt64));
    const Tensor inside = squared_distances(points, centres) < reach;
    const Tensor rank = torch::where(inside, order, torch::full_like(order, total));
    Tensor found = std::get<0>(rank.topk(std::min(neighbours, total), 2, false, true));
    if (found.size(2) < neighbours)
      found = torch::cat({found, torch::full({batch, count, neighbours - found.size(2)}, total, found.options())}, 2);
    const Tensor nearest = found.slice(2, 0, 1);
    const Tensor fill = torch::where(nearest == total, torch::zeros_like(nearest), nearest);
    return torch::where(found == total, fill, found).contiguous();
  }
  const Tensor source = points.contiguous(), target = centres.contiguous();
  Tensor found = torch::zeros({batch, count, neighbours}, torch::kInt64);
  for (int64_t b = 0; b < batch; ++b) {
    const PointArrays cloud(source.data_ptr<float>() + b * total * 3, total);
    at::parallel_for(0, count, row_grain(total), [&](int64_t first, int64_t last) {
      for (int64_t m = b * count + first; m < b * count + last; ++m) {
        int64_t* out = found.data_ptr<int64_t>() + m * neighbours;
        const int64_t got = points_in_ball(cloud, target.data_ptr<float>() + m * 3, reach, neighbours, out);
        if (got > 0) std::fill(out + got, out + neighbours, out[0]);
      }
    });
  }
  return found;
}

SparseMap nearest_interpolation(const Tensor& points, const Tensor& centres) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = points.size(0), total = points.size(1), count = centres.size(1);
  const int64_t terms = std::min<int64_t>(3, count);
  Tensor distance, index;
  if (!loops_apply(points)) {
    std::tie(distance, index) = squared_distances(centres, points).topk(terms, 2, false, true);
  } else {
    const Tensor source = points.contiguous(), target = centres.contiguous();
    distance = torch::empty({batch, total, terms});
    index = torch::empty({batch, total, terms}, torch::kInt64);
    for (int64_t b = 0; b < batch; ++b) {
      const PointArrays cloud(target.data_ptr<float>() + b * count * 3, count);
      at::parallel_for(0, total, row_grain(count), [&](int64_t first, int64_t last) {
        for (int64_t n = b * total + first; n < b * total + last; ++n) {
          float best[3];
          int64_t at[3];
          three_nearest_points(cloud, source.data_ptr<float>() + n * 3, best, at);
          std::copy_n(best, terms, distance.data_ptr<float>() + n * terms);
          std::copy_n(at, terms, index.data_ptr<int64_t>() + n * terms);
        }
      });
    }
  }
  const Tensor nearness = distance.clamp_min(kLeastSquaredDistance).reciprocal();
  return {index, (nearness / nearness.sum(2, true)).contiguous(), count};
}

Tensor select_points(const Tensor& points, const Tensor& index) {
  return points.gather(1, index.unsqueeze(2).expand({index.size(0), index.size(1), 3}));
}

}  // namespace inhabit::nn
