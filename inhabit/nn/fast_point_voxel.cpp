#include "inhabit/nn/fast_point_voxel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "inhabit/nn/parallel_chunks.h"
#include "inhabit/nn/point_ops.h"

namespace inhabit::nn {
namespace {

using torch::Tensor;

constexpr int64_t kTaps = 27;
constexpr int64_t kVoxelChunk = 1024;  // outputs whose rows stay in the second-level cache while all taps go by
constexpr int64_t kRowChunk = 64;
constexpr int64_t kCentreChunk = 8;

float leaky(float x) { return x > 0 ? x : static_cast<float>(kVoxelLeak) * x; }

int64_t chunks_of(int64_t count, int64_t size) { return (count + size - 1) / size; }

/// A grid with a border of one voxel, so that neighbours need no bounds.
struct PaddedGrid {
  explicit PaddedGrid(int64_t g) : grid(g), side(g + 2) {
    for (int64_t tap = 0; tap < kTaps; ++tap)
      offset[tap] = ((tap / 9 - 1) * side + (tap / 3 % 3 - 1)) * side + (tap % 3 - 1);
  }
  int64_t cells() const { return side * side * side; }
  int64_t place(int64_t voxel) const {
    return ((voxel / (grid * grid) + 1) * side + voxel / grid % grid + 1) * side + voxel % grid + 1;
  }
  bool inside(int64_t place) const {
    const int64_t x = place / (side * side), y = place / side % side, z = place % side;
    return x > 0 && y > 0 && z > 0 && x <= grid && y <= grid && z <= grid;
  }
  /// Which of the 27 kinds of voxel by its distance from the grid's faces.
  int8_t kind(int64_t place) const {
    const auto axis = [this](int64_t p) { return p == 1 ? 0 : p == grid ? 2 : 1; };
    return static_cast<int8_t>(axis(place / (side * side)) * 9 + axis(place / side % side) * 3 + axis(place % side));
  }

  int64_t grid, side;
  std::array<int64_t, kTaps> offset;
};

/// Places that a 3x3x3 kernel reaches from `places`, ascending.
std::vector<int32_t> dilate(const PaddedGrid& grid, const std::vector<int32_t>& places) {
  std::vector<char> reached(static_cast<size_t>(grid.cells()), 0);
  for (const int32_t place : places) {
    for (const int64_t offset : grid.offset) reached[place + offset] = 1;
  }
  std::vector<int32_t> result;
  for (int64_t place = 0; place < grid.cells(); ++place) {
    if (reached[place] != 0 && grid.inside(place)) result.push_back(static_cast<int32_t>(place));
  }
  return result;
}

/// Rows of `places` on the padded grid, -1 elsewhere.
std::vector<int32_t> row_map(const PaddedGrid& grid, const std::vector<int32_t>& places) {
  std::vector<int32_t> rows(static_cast<size_t>(grid.cells()), -1);
  for (size_t i = 0; i < places.size(); ++i) rows[places[i]] = static_cast<int32_t>(i);
  return rows;
}

TapPairs tap_pairs(const PaddedGrid& grid, const std::vector<int32_t>& input_rows,
                   const std::vector<int32_t>& outputs) {
  TapPairs pairs;
  const auto count = static_cast<int64_t>(outputs.size());
  // As many chunks of equal size as keep every thread busy to the end.
  const int64_t threads = at::get_num_threads();
  pairs.chunk = chunks_of(count, threads * chunks_of(count, threads * kVoxelChunk));
  pairs.begin.push_back(0);
  for (int64_t first = 0; first < count; first += pairs.chunk) {
    const int64_t last = std::min(count, first + pairs.chunk);
    for (const int64_t offset : grid.offset) {
      for (int64_t o = first; o < last; ++o) {
        const int32_t row = input_rows[outputs[o] + offset];
        if (row < 0) continue;
        pairs.from.push_back(row);
        pairs.to.push_back(static_cast<int32_t>(o));
      }
      pairs.begin.push_back(static_cast<int32_t>(pairs.from.size()));
    }
  }
  return pairs;
}

/// Adds one chunk's products of all taps.
void convolve_chunk(const std::vector<PackedMatrix>& taps, int64_t depth, const TapPairs& pairs, int64_t chunk,
                    const float* x, int64_t x_stride, float* y) {
  for (int64_t tap = 0; tap < kTaps; ++tap) {
    const int32_t first = pairs.begin[chunk * kTaps + tap], last = pairs.begin[chunk * kTaps + tap + 1];
    accumulate_rows(taps[tap], depth, x, x_stride, pairs.from.data() + first, pairs.to.data() + first, last - first, y);
  }
}

/// Calls work(rows, count, full) for chunks of rows that are equally deep, on all threads.
template <class Work>
void for_row_chunks(const Rows& x, const Work& work) {
  static thread_local std::vector<int32_t> all;
  if (!x.listed()) {
    all.resize(static_cast<size_t>(x.count));
    for (int64_t i = 0; i < x.count; ++i) all[i] = static_cast<int32_t>(i);
  }
  const std::vector<int32_t>& full = x.listed() ? x.full : all;
  const auto full_count = static_cast<int64_t>(full.size()), bare_count = static_cast<int64_t>(x.bare.size());
  const int64_t full_chunks = chunks_of(full_count, kRowChunk);
  const int32_t *full_rows = full.data(), *bare_rows = x.bare.data();
  parallel_chunks(full_chunks + chunks_of(bare_count, kRowChunk), [&](int64_t chunk) {
    const bool is_full = chunk < full_chunks;
    const int64_t first = (is_full ? chunk : chunk - full_chunks) * kRowChunk;
    work((is_full ? full_rows : bare_rows) + first, std::min(kRowChunk, (is_full ? full_count : bare_count) - first),
         is_full);
  });
}

void rectify(float* x, int64_t count) {
  for (int64_t i = 0; i < count; ++i) x[i] = x[i] > 0 ? x[i] : 0;
}

/// Runs `count` rows through layers with ReLU, back and forth between two buffers; returns where the result is.
float* through_layers(const std::vector<RowLayer>& layers, float* x, int64_t x_stride, int64_t count,
                      std::vector<float>& spare_a, std::vector<float>& spare_b) {
  bool first = true;
  for (const RowLayer& layer : layers) {
    std::vector<float>& spare = first ? spare_a : spare_b;
    first = !first;
    spare.resize(static_cast<size_t>(count * layer.stride()));
    apply(layer, x, x_stride, count, spare.data());
    rectify(spare.data(), count * layer.stride());
    x = spare.data();
    x_stride = layer.stride();
  }
  return x;
}

/// Layers of a shared MLP, batch norms folded.
std::vector<RowLayer> mlp_layers(const SharedMlp& mlp) {
  std::vector<RowLayer> layers;
  const auto modules = mlp->layers->children();
  for (size_t i = 0; i + 1 < modules.size(); i += 3) {
    const auto parameters = modules[i]->named_parameters();
    layers.push_back(row_layer(parameters["weight"], parameters["bias"], folded_norm(*modules[i + 1], kNormEps)));
  }
  return layers;
}

/// Input channels [first, last) of a layer, with its bias or without.
RowLayer input_slice(const RowLayer& layer, int64_t first, int64_t last, bool with_bias) {
  RowLayer part;
  part.w.in = last - first;
  part.w.out = layer.w.out;
  for (int64_t block = 0; block < layer.stride() / kColumnBlock; ++block) {
    const auto from = layer.w.data.begin() + (block * layer.w.in + first) * kColumnBlock;
    part.w.data.insert(part.w.data.end(), from, from + (last - first) * kColumnBlock);
  }
  part.bias = with_bias ? layer.bias : std::vector<float>(layer.bias.size(), 0.0F);
  return part;
}

}  // namespace

void Rows::resize(int64_t rows, int64_t channel_count) {
  count = rows;
  channels = channel_count;
  stride = padded_columns(channel_count);
  shallow = 0;
  full.clear();
  bare.clear();
  data.resize(static_cast<size_t>(count * stride));
}

GridPlan::GridPlan(const Tensor& cloud, int64_t grid_size, const std::vector<int32_t>& full)
    : grid(grid_size), points(cloud.size(1)) {
  const PaddedGrid padded(grid);
  const Tensor coordinates = voxel_coordinates(cloud, grid);
  const float* at = coordinates.data_ptr<float>();

  std::vector<int32_t> place_of(static_cast<size_t>(points));
  std::vector<int32_t> count(static_cast<size_t>(padded.cells()), 0);
  for (int64_t n = 0; n < points; ++n) {
    int64_t place = 0;
    for (int axis = 0; axis < 3; ++axis)
      place = place * padded.side + static_cast<int64_t>(std::nearbyint(at[3 * n + axis])) + 1;
    place_of[n] = static_cast<int32_t>(place);
    ++count[place];
  }
  std::vector<int32_t> places;
  voxel_begin.push_back(0);
  for (int64_t place = 0; place < padded.cells(); ++place) {
    if (count[place] == 0) continue;
    places.push_back(static_cast<int32_t>(place));
    voxel_begin.push_back(voxel_begin.back() + count[place]);
  }
  occupied = static_cast<int64_t>(places.size());
  const std::vector<int32_t> occupied_rows = row_map(padded, places);
  std::vector<int32_t> next(voxel_begin.begin(), voxel_begin.end() - 1);
  voxel_points.resize(static_cast<size_t>(points));
  for (int64_t n = 0; n < points; ++n) voxel_points[next[occupied_rows[place_of[n]]]++] = static_cast<int32_t>(n);
  voxel_full.assign(static_cast<size_t>(occupied), full.empty() ? 1 : 0);
  for (const int32_t n : full) voxel_full[occupied_rows[place_of[n]]] = 1;

  const std::vector<int32_t> reached_once = dilate(padded, places), reached_twice = dilate(padded, reached_once);
  once = static_cast<int64_t>(reached_once.size());
  twice = static_cast<int64_t>(reached_twice.size());
  std::vector<int32_t> full_rows = occupied_rows, bare_rows = occupied_rows;
  for (size_t i = 0; i < places.size(); ++i) (voxel_full[i] != 0 ? bare_rows : full_rows)[places[i]] = -1;
  first_full = tap_pairs(padded, full_rows, reached_once);
  first_bare = tap_pairs(padded, bare_rows, reached_once);
  second = tap_pairs(padded, row_map(padded, reached_once), reached_twice);

  unreached.assign(kTaps, 0);
  for (int64_t k = 0; k < kTaps; ++k) {
    const auto along = [this](int64_t axis_kind) { return axis_kind == 1 ? grid - 2 : int64_t{1}; };
    unreached[k] = along(k / 9) * along(k / 3 % 3) * along(k % 3);
  }
  kind.reserve(static_cast<size_t>(twice));
  for (const int32_t place : reached_twice) {
    kind.push_back(padded.kind(place));
    --unreached[kind.back()];
  }

  const std::vector<int32_t> twice_rows = row_map(padded, reached_twice);
  corners.resize(static_cast<size_t>(points * 8));
  corner_weights.resize(static_cast<size_t>(points * 8));
  for (int64_t n = 0; n < points; ++n) {
    for (int corner = 0; corner < 8; ++corner) {
      int64_t place = 0;
      float weight = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const float low = std::floor(at[3 * n + axis]), part = at[3 * n + axis] - low;
        const bool high = ((corner >> (2 - axis)) & 1) != 0;
        const int64_t cell = std::min(static_cast<int64_t>(low) + (high ? 1 : 0), grid - 1);
        place = place * padded.side + cell + 1;
        weight *= high ? part : 1 - part;
      }
      corners[8 * n + corner] = twice_rows[place];
      corner_weights[8 * n + corner] = weight;
    }
  }
}

FastPointVoxelConv::FastPointVoxelConv(const PointVoxelConv& layer)
    : grid_(layer->grid), in_(layer->convolutions[0]->weight.size(1)), out_(layer->convolutions[0]->weight.size(0)) {
  const int64_t stride = padded_columns(out_);
  std::vector<float> second_bias;
  for (int i = 0; i < 2; ++i) {
    const FoldedNorm norm = folded_norm(*layer->norms[i], kVoxelNormEps);
    const Tensor weight =
        (layer->convolutions[i]->weight.detach().to(torch::kCPU, torch::kFloat64) * norm.scale.view({out_, 1, 1, 1, 1}))
            .to(torch::kFloat32)
            .contiguous();  // (O, C, 27)
    const Tensor bias =
        (layer->convolutions[i]->bias.detach().to(torch::kCPU, torch::kFloat64) * norm.scale + norm.shift)
            .to(torch::kFloat32)
            .contiguous();
    const int64_t in = weight.size(1);
    auto& taps = i == 0 ? first_ : second_;
    for (int64_t tap = 0; tap < kTaps; ++tap)
      taps.push_back(pack_matrix(weight.data_ptr<float>() + tap, in, out_, kTaps, in * kTaps));
    auto& into = i == 0 ? first_bias_ : second_bias;
    into.assign(static_cast<size_t>(stride), 0.0F);
    std::copy_n(bias.data_ptr<float>(), out_, into.begin());
  }
  background_.resize(first_bias_.size());
  std::transform(first_bias_.begin(), first_bias_.end(), background_.begin(), leaky);

  // What the second convolution makes of a constant grid: each tap's part, less those that the zero padding cuts off.
  std::vector<std::vector<float>> of_tap;
  for (int64_t tap = 0; tap < kTaps; ++tap) {
    of_tap.emplace_back(static_cast<size_t>(stride), 0.0F);
    accumulate_rows(second_[tap], out_, background_.data(), stride, nullptr, nullptr, 1, of_tap.back().data());
  }
  for (int64_t kind = 0; kind < kTaps; ++kind) {
    std::vector<float> constant = second_bias;
    for (int64_t tap = 0; tap < kTaps; ++tap) {
      const auto cut = [](int64_t axis_kind, int64_t axis_tap) { return axis_kind != 1 && axis_kind == axis_tap; };
      if (cut(kind / 9, tap / 9) || cut(kind / 3 % 3, tap / 3 % 3) || cut(kind % 3, tap % 3)) continue;
      for (int64_t c = 0; c < out_; ++c) constant[c] += of_tap[tap][c];
    }
    constants_.insert(constants_.end(), constant.begin(), constant.end());
  }
  point_ = mlp_layers(layer->point_features).front();
  const auto gate = layer->gate->named_parameters();
  squeeze_ = row_layer(gate["fc.0.weight"], {});
  excite_ = row_layer(gate["fc.2.weight"], {});
}

void FastPointVoxelConv::operator()(const GridPlan& plan, const Rows& x, Rows& y) {
  const int64_t stride = padded_columns(out_), shallow = x.listed() ? x.shallow : in_;
  averages_.resize(static_cast<size_t>(plan.occupied * x.stride));
  parallel_chunks(chunks_of(plan.occupied, kRowChunk), [&](int64_t chunk) {
    for (int64_t v = chunk * kRowChunk; v < std::min(plan.occupied, (chunk + 1) * kRowChunk); ++v) {
      const int64_t depth = plan.voxel_full[v] != 0 ? in_ : shallow;
      float* into = averages_.data() + v * x.stride;
      std::fill_n(into, depth, 0.0F);
      for (int32_t i = plan.voxel_begin[v]; i < plan.voxel_begin[v + 1]; ++i) {
        const float* from = x.row(plan.voxel_points[i]);
        for (int64_t c = 0; c < depth; ++c) into[c] += from[c];
      }
      const float weight = 1.0F / static_cast<float>(plan.voxel_begin[v + 1] - plan.voxel_begin[v]);
      for (int64_t c = 0; c < depth; ++c) into[c] *= weight;
    }
  });

  once_.resize(static_cast<size_t>(plan.once * stride));
  parallel_chunks(chunks_of(plan.once, plan.first_full.chunk), [&](int64_t chunk) {
    const int64_t first = chunk * plan.first_full.chunk, last = std::min(plan.once, first + plan.first_full.chunk);
    for (int64_t v = first; v < last; ++v) std::copy_n(first_bias_.data(), stride, once_.data() + v * stride);
    convolve_chunk(first_, in_, plan.first_full, chunk, averages_.data(), x.stride, once_.data());
    convolve_chunk(first_, shallow, plan.first_bare, chunk, averages_.data(), x.stride, once_.data());
    for (int64_t v = first; v < last; ++v) {
      float* row = once_.data() + v * stride;
      for (int64_t c = 0; c < stride; ++c) row[c] = leaky(row[c]) - background_[c];
    }
  });

  twice_.resize(static_cast<size_t>(plan.twice * stride));
  const int64_t second_chunks = chunks_of(plan.twice, plan.second.chunk);
  sums_.assign(static_cast<size_t>(second_chunks * stride), 0.0F);
  parallel_chunks(second_chunks, [&](int64_t chunk) {
    const int64_t first = chunk * plan.second.chunk, last = std::min(plan.twice, first + plan.second.chunk);
    for (int64_t v = first; v < last; ++v)
      std::copy_n(constants_.data() + plan.kind[v] * stride, stride, twice_.data() + v * stride);
    convolve_chunk(second_, out_, plan.second, chunk, once_.data(), stride, twice_.data());
    float* sum = sums_.data() + chunk * stride;
    for (int64_t v = first; v < last; ++v) {
      float* row = twice_.data() + v * stride;
      for (int64_t c = 0; c < stride; ++c) {
        row[c] = leaky(row[c]);
        sum[c] += row[c];
      }
    }
  });

  std::vector<float> gate(static_cast<size_t>(stride)), squeezed(static_cast<size_t>(squeeze_.stride())),
      excited(static_cast<size_t>(excite_.stride()));
  const auto cells = static_cast<double>(grid_ * grid_ * grid_);
  for (int64_t c = 0; c < out_; ++c) {
    double total = 0;
    for (int64_t chunk = 0; chunk < second_chunks; ++chunk) total += sums_[chunk * stride + c];
    for (int64_t k = 0; k < kTaps; ++k)
      total += static_cast<double>(plan.unreached[k]) * leaky(constants_[k * stride + c]);
    gate[c] = static_cast<float>(total / cells);
  }
  apply(squeeze_, gate.data(), stride, 1, squeezed.data());
  rectify(squeezed.data(), squeeze_.stride());
  apply(excite_, squeezed.data(), squeeze_.stride(), 1, excited.data());
  for (int64_t c = 0; c < out_; ++c) gate[c] = 1.0F / (1.0F + std::exp(-excited[c]));

  y.resize(plan.points, out_);
  for_row_chunks(x, [&](const int32_t* rows, int64_t count, bool full) {
    for (int64_t i = 0; i < count; ++i) std::copy_n(point_.bias.data(), stride, y.row(rows[i]));
    accumulate_rows(point_.w, full ? in_ : shallow, x.data.data(), x.stride, rows, rows, count, y.data.data());
    std::vector<float> mixed(static_cast<size_t>(stride));
    for (int64_t i = 0; i < count; ++i) {
      const int64_t n = rows[i];
      std::fill(mixed.begin(), mixed.end(), 0.0F);
      for (int64_t corner = 8 * n; corner < 8 * n + 8; ++corner) {
        const float weight = plan.corner_weights[corner];
        const float* from = twice_.data() + plan.corners[corner] * stride;
        for (int64_t c = 0; c < stride; ++c) mixed[c] += weight * from[c];
      }
      float* into = y.row(n);
      for (int64_t c = 0; c < stride; ++c) into[c] = (into[c] > 0 ? into[c] : 0) + gate[c] * mixed[c];
    }
  });
}

FastSetAbstraction::FastSetAbstraction(const SetAbstraction& layer)
    : centres_(layer->centres),
      neighbours_(layer->neighbours),
      squared_radius_(static_cast<float>(layer->radius) * static_cast<float>(layer->radius)) {
  later_ = mlp_layers(layer->mlp);
  offset_ = input_slice(later_.front(), 0, 3, false);
  feature_ = input_slice(later_.front(), 3, later_.front().w.in, true);
  later_.erase(later_.begin());
}

Tensor FastSetAbstraction::operator()(const Tensor& points, const Rows& x, Rows& y) {
  const float* at = points.data_ptr<float>();
  const PointArrays cloud(at, x.count);
  std::vector<int64_t> chosen(static_cast<size_t>(centres_));
  furthest_points_of_cloud(cloud, centres_, chosen.data());
  Tensor centres = torch::empty({1, centres_, 3});
  float* centre = centres.data_ptr<float>();
  for (int64_t m = 0; m < centres_; ++m) std::copy_n(at + 3 * chosen[m], 3, centre + 3 * m);

  const int64_t stride = feature_.stride();
  per_point_.resize(static_cast<size_t>(x.count * stride));
  for_row_chunks(x, [&](const int32_t* rows, int64_t count, bool full) {
    for (int64_t i = 0; i < count; ++i) std::copy_n(feature_.bias.data(), stride, per_point_.data() + rows[i] * stride);
    accumulate_rows(feature_.w, full ? feature_.w.in : x.shallow, x.data.data(), x.stride, rows, rows, count,
                    per_point_.data());
  });

  y.resize(centres_, later_.empty() ? offset_.w.out : later_.back().w.out);
  parallel_chunks(chunks_of(centres_, kCentreChunk), [&](int64_t chunk) {
    static thread_local std::vector<float> around, spare_a, spare_b;
    static thread_local std::vector<int64_t> found;
    found.resize(static_cast<size_t>(neighbours_));
    around.resize(static_cast<size_t>(kCentreChunk * neighbours_ * stride));
    std::array<int64_t, kCentreChunk + 1> begin{};
    int64_t filled = 0, group = 0;
    for (int64_t m = chunk * kCentreChunk; m < std::min(centres_, (chunk + 1) * kCentreChunk); ++m, ++group) {
      begin[group] = filled;
      int64_t got = points_in_ball(cloud, centre + 3 * m, squared_radius_, neighbours_, found.data());
      if (got == 0) found[got++] = 0;
      for (int64_t k = 0; k < got; ++k, ++filled) {
        const int64_t n = found[k];
        const float offset[3] = {at[3 * n] - centre[3 * m], at[3 * n + 1] - centre[3 * m + 1],
                                 at[3 * n + 2] - centre[3 * m + 2]};
        const float* from = per_point_.data() + n * stride;
        float* into = around.data() + filled * stride;
        for (int64_t block = 0; block < stride; block += kColumnBlock) {
          const float* w = offset_.w.data.data() + 3 * block;
          for (int64_t c = 0; c < kColumnBlock; ++c) {
            const float sum = from[block + c] + offset[0] * w[c] + offset[1] * w[kColumnBlock + c] +
                              offset[2] * w[2 * kColumnBlock + c];
            into[block + c] = sum > 0 ? sum : 0;
          }
        }
      }
    }
    begin[group] = filled;
    const float* result = through_layers(later_, around.data(), stride, filled, spare_a, spare_b);
    for (int64_t g = 0; g < group; ++g) {
      float* into = y.row(chunk * kCentreChunk + g);
      std::copy_n(result + begin[g] * y.stride, y.stride, into);
      for (int64_t k = begin[g] + 1; k < begin[g + 1]; ++k) {
        const float* from = result + k * y.stride;
        for (int64_t c = 0; c < y.stride; ++c) into[c] = from[c] > into[c] ? from[c] : into[c];
      }
    }
  });
  return centres;
}

FastFeaturePropagation::FastFeaturePropagation(const FeaturePropagation& layer, int64_t coarse_channels) {
  later_ = mlp_layers(layer->mlp);
  carried_ = input_slice(later_.front(), 0, coarse_channels, false);
  own_ = input_slice(later_.front(), coarse_channels, later_.front().w.in, true);
  later_.erase(later_.begin());
}

void FastFeaturePropagation::operator()(const Tensor& coarse_points, const Rows& coarse, const Tensor& fine_points,
                                        const Rows& fine, int64_t first_channel, Rows& y) {
  const int64_t stride = own_.stride();
  // The first layer of an interpolation is the interpolation of the first layer.
  per_centre_.resize(static_cast<size_t>(coarse.count * stride));
  for_row_chunks(coarse, [&](const int32_t* rows, int64_t count, bool) {
    for (int64_t i = 0; i < count; ++i) std::fill_n(per_centre_.data() + rows[i] * stride, stride, 0.0F);
    accumulate_rows(carried_.w, carried_.w.in, coarse.data.data(), coarse.stride, rows, rows, count,
                    per_centre_.data());
  });
  const PointArrays cloud(coarse_points.data_ptr<float>(), coarse.count);
  const float* at = fine_points.data_ptr<float>();
  const int64_t terms = std::min<int64_t>(3, coarse.count);
  y.resize(fine.count, later_.empty() ? own_.w.out : later_.back().w.out);
  for_row_chunks(fine, [&](const int32_t* rows, int64_t count, bool full) {
    static thread_local std::vector<float> first, spare_a, spare_b;
    first.resize(static_cast<size_t>(count * stride));
    for (int64_t i = 0; i < count; ++i) {
      float distance[3], nearness[3], total = 0;
      int64_t index[3];
      three_nearest_points(cloud, at + 3 * rows[i], distance, index);
      for (int64_t k = 0; k < terms; ++k) total += nearness[k] = 1.0F / std::max(distance[k], 1e-10F);
      float* into = first.data() + i * stride;
      std::copy_n(own_.bias.data(), stride, into);
      for (int64_t k = 0; k < terms; ++k) {
        const float weight = nearness[k] / total;
        const float* from = per_centre_.data() + index[k] * stride;
        for (int64_t c = 0; c < stride; ++c) into[c] += weight * from[c];
      }
    }
    const int64_t depth = full ? own_.w.in : std::max<int64_t>(0, fine.shallow - first_channel);
    accumulate_rows(own_.w, depth, fine.data.data() + first_channel, fine.stride, rows, nullptr, count, first.data());
    rectify(first.data(), count * stride);
    const float* result = through_layers(later_, first.data(), stride, count, spare_a, spare_b);
    for (int64_t i = 0; i < count; ++i) std::copy_n(result + i * y.stride, y.stride, y.row(rows[i]));
  });
}

}  // namespace inhabit::nn
