#include "inhabit/scene/contact_map.h"

#include <ATen/Parallel.h>

#include <cstring>

#include "inhabit/error.h"

namespace inhabit {
namespace {

constexpr int kLongestAxis = 64;    // cells along an axis at most, so that far-flung points do not make a huge grid
constexpr double kSmallest = 1e-6;  // contact values below this are left at zero

/// Points sorted into the cells of a regular grid, coordinates apart.
struct Cells {
  std::array<float, 3> origin{};
  float size = 1;
  std::array<int, 3> count{};
  std::vector<int32_t> first;  ///< of every cell, and one past the last
  std::vector<int32_t> index;  ///< into the points as given
  std::array<std::vector<float>, 3> at;

  /// The cell at x = 0; those along x follow each other.
  size_t row(int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(count[1]) + static_cast<size_t>(y)) *
           static_cast<size_t>(count[0]);
  }
};

Cells sort_into_cells(const float* points, int64_t n, float size) {
  Cells cells;
  std::array<float, 3> upper{};
  for (size_t axis = 0; axis < 3; ++axis) {
    cells.origin[axis] = upper[axis] = points[axis];
    for (int64_t i = 0; i < n; ++i) {
      cells.origin[axis] = std::min(cells.origin[axis], points[3 * i + static_cast<int64_t>(axis)]);
      upper[axis] = std::max(upper[axis], points[3 * i + static_cast<int64_t>(axis)]);
    }
    size = std::max(size, (upper[axis] - cells.origin[axis]) / kLongestAxis * 1.0001F);
  }
  cells.size = size;
  for (size_t axis = 0; axis < 3; ++axis) {
    cells.count[axis] = std::clamp(static_cast<int>((upper[axis] - cells.origin[axis]) / size) + 1, 1, kLongestAxis);
  }
  const auto cell_of = [&](int64_t i) {
    std::array<int, 3> k{};
    for (size_t axis = 0; axis < 3; ++axis) {
      const float at = (points[3 * i + static_cast<int64_t>(axis)] - cells.origin[axis]) / size;
      k[axis] = at > 0 ? std::min(static_cast<int>(at), cells.count[axis] - 1) : 0;
    }
    return cells.row(k[1], k[2]) + static_cast<size_t>(k[0]);
  };
  cells.first.assign(cells.row(0, cells.count[2]) + 1, 0);
  for (int64_t i = 0; i < n; ++i) ++cells.first[cell_of(i) + 1];
  for (size_t c = 1; c < cells.first.size(); ++c) cells.first[c] += cells.first[c - 1];
  std::vector<int32_t> next(cells.first.begin(), cells.first.end() - 1);
  cells.index.resize(static_cast<size_t>(n));
  for (auto& axis : cells.at) axis.resize(static_cast<size_t>(n));
  for (int64_t i = 0; i < n; ++i) {
    const auto to = static_cast<size_t>(next[cell_of(i)]++);
    cells.index[to] = static_cast<int32_t>(i);
    for (size_t axis = 0; axis < 3; ++axis) cells.at[axis][to] = points[3 * i + static_cast<int64_t>(axis)];
  }
  return cells;
}

/// 2^x for x in [-126, 0], to 3e-7 relative: a polynomial for the fraction, the exponent bits for the rest. Plain
/// enough for the compiler to do several at once, which std::exp is not.
inline float exp2_negative(float x) {
  const int whole = static_cast<int>(x) - 1;
  const float f = x - static_cast<float>(whole);  // in (0, 1], for the cast rounds towards zero
  float p = 1.8775767e-3F;
  p = p * f + 8.9893397e-3F;
  p = p * f + 5.5826318e-2F;
  p = p * f + 2.4015361e-1F;
  p = p * f + 6.9315308e-1F;
  p = p * f + 9.9999994e-1F;
  const int32_t bits = (whole + 127) << 23;
  float scale;
  std::memcpy(&scale, &bits, sizeof(scale));
  return p * scale;
}

/// One row of a contact map, a joint at one time: `out` (N) is zero on entry.
void fill_row(const Cells& cells, const float* joint, float reach, float factor, std::vector<float>& values,
              float* out) {
  std::array<int, 3> low{}, high{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const float from = (joint[axis] - reach - cells.origin[axis]) / cells.size;
    const float to = (joint[axis] + reach - cells.origin[axis]) / cells.size;
    if (!(to >= 0) || !(from <= static_cast<float>(cells.count[axis]))) return;
    low[axis] = static_cast<int>(std::max(from, 0.F));
    high[axis] = std::min(static_cast<int>(to), cells.count[axis] - 1);
  }
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      const size_t row = cells.row(y, z);  // points follow each other as the cells do
      if (low[0] > high[0]) continue;
      const int32_t begin = cells.first[row + static_cast<size_t>(low[0])];
      const int32_t n = cells.first[row + static_cast<size_t>(high[0]) + 1] - begin;
      const float *px = cells.at[0].data() + begin, *py = cells.at[1].data() + begin, *pz = cells.at[2].data() + begin;
      float* value = values.data();
      for (int32_t i = 0; i < n; ++i) {
        const float dx = px[i] - joint[0], dy = py[i] - joint[1], dz = pz[i] - joint[2];
        const float exponent = (dx * dx + dy * dy + dz * dz) * factor;
        value[i] = exponent > -20.F ? exp2_negative(std::max(exponent, -20.F)) : 0.F;
      }
      const int32_t* index = cells.index.data() + begin;
      for (int32_t i = 0; i < n; ++i) out[index[i]] = value[i];
    }
  }
}

/// @param joints (R, 3), @param points (N, 3), both contiguous float on the CPU; @param out (R, N), zero.
void fast_contact_map(const torch::Tensor& joints, const torch::Tensor& points, double sigma, torch::Tensor out) {
  const int64_t n = points.size(0);
  if (n == 0 || joints.size(0) == 0) return;
  const double reach = sigma * std::sqrt(-2 * std::log(kSmallest));
  const auto factor = static_cast<float>(-0.5 / (sigma * sigma * M_LN2));
  const Cells cells = sort_into_cells(points.data_ptr<float>(), n, static_cast<float>(reach / 3));
  const float* joint = joints.data_ptr<float>();
  float* to = out.data_ptr<float>();
  at::parallel_for(0, joints.size(0), 64, [&](int64_t begin, int64_t end) {
    std::vector<float> values(static_cast<size_t>(n));
    for (int64_t r = begin; r < end; ++r) {
      fill_row(cells, joint + 3 * r, static_cast<float>(reach), factor, values, to + r * n);
    }
  });
}

void check_shapes(const torch::Tensor& joints, const torch::Tensor& points) {
  if (joints.dim() < 2 || joints.size(-1) != 3) throw Error("joints must be (..., J, 3)");
  const bool batched = points.dim() == 3;
  if ((points.dim() != 2 && !batched) || points.size(-1) != 3) throw Error("scene points must be (N, 3) or (B, N, 3)");
  if (batched && (joints.dim() < 3 || joints.size(0) != points.size(0))) {
    throw Error("joints and scene points must have the same batch size");
  }
}

}  // namespace

torch::Tensor distance_map(const torch::Tensor& joints, const torch::Tensor& points) {
  check_shapes(joints, points);
  std::vector<int64_t> shape = joints.sizes().vec();
  shape.back() = points.size(-2);
  // Distances one by one (mode 2): through dot products (x - p)^2 loses half its digits near contact.
  if (points.dim() == 2) return torch::cdist(joints.reshape({-1, 3}), points, 2.0, 2).view(shape);
  return torch::cdist(joints.reshape({joints.size(0), -1, 3}), points, 2.0, 2).view(shape);
}

torch::Tensor contact_map(const torch::Tensor& joints, const torch::Tensor& points, double sigma) {
  check_shapes(joints, points);
  const bool gradient = torch::GradMode::is_enabled() && (joints.requires_grad() || points.requires_grad());
  const bool plain = joints.is_cpu() && points.is_cpu() && joints.scalar_type() == torch::kFloat32 &&
                     points.scalar_type() == torch::kFloat32;
  if (gradient || !plain) return torch::exp(distance_map(joints, points).square() * (-0.5 / (sigma * sigma)));
  std::vector<int64_t> shape = joints.sizes().vec();
  shape.back() = points.size(-2);
  torch::NoGradGuard no_gradient;
  torch::Tensor out = torch::zeros(shape);
  if (out.numel() == 0) return out;
  const torch::Tensor from = joints.contiguous(), to = points.contiguous();
  if (points.dim() == 2) {
    fast_contact_map(from.view({-1, 3}), to, sigma, out.view({-1, to.size(0)}));
  } else {
    for (int64_t b = 0; b < to.size(0); ++b) {
      fast_contact_map(from[b].reshape({-1, 3}), to[b], sigma, out[b].view({-1, to.size(1)}));
    }
  }
  return out;
}

}  // namespace inhabit
