#include "inhabit/inbetween/fast_denoiser.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>

#include "inhabit/nn/mish.h"
#include "inhabit/nn/norm_kernel.h"
#include "inhabit/nn/parallel_chunks.h"
#include "inhabit/nn/row_layers.h"

namespace inhabit::inbetween {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

constexpr int64_t kEdge = kTaps / 2;  // rows of zeros before and behind every clip

/// Clips of a batch, a row of `channels` numbers each frame, with kEdge rows of zeros around each clip.
struct Rows {
  int64_t batch = 0, frames = 0, channels = 0;
  std::vector<float> data;

  void shape(int64_t new_batch, int64_t new_frames, int64_t new_channels) {
    if (batch == new_batch && frames == new_frames && channels == new_channels) return;
    batch = new_batch;
    frames = new_frames;
    channels = new_channels;
    data.assign(static_cast<size_t>(batch * pitch() * channels), 0.0F);
  }
  int64_t pitch() const { return frames + 2 * kEdge; }  ///< rows from one clip to the next
  float* clip(int64_t b) { return data.data() + (b * pitch() + kEdge) * channels; }
  const float* clip(int64_t b) const { return data.data() + (b * pitch() + kEdge) * channels; }
};

nn::RowLayer layer_of(const tn::Conv1d& conv) {
  return nn::row_layer_of_taps(conv->weight.permute({2, 1, 0}), conv->bias);
}

std::vector<float> numbers(const Tensor& t) {
  const Tensor x = t.detach().contiguous();
  return {x.data_ptr<float>(), x.data_ptr<float>() + x.numel()};
}

/// A convolution's group norm and, of the first of a block, the embedding's scale and shift.
struct Norm {
  std::vector<float> weight, bias;
  double eps = 0;
};

Norm norm_of(const tn::GroupNorm& norm) { return {numbers(norm->weight), numbers(norm->bias), norm->options.eps()}; }

/// Outputs of products before they are normed: row b * frames + t, padded columns.
struct Scratch {
  std::vector<float> data;
  std::vector<int32_t> from, to;

  float* rows(int64_t count, int64_t stride) {
    if (data.size() < static_cast<size_t>(count * stride)) data.resize(static_cast<size_t>(count * stride));
    return data.data();
  }
};

/// y[to(b, i)] = bias + the product of the `taps` rows of x from row `first` + i * step of each clip on (0 being the
/// clip's first frame), for `count` rows a clip. @param spread, offset to(b, i) = (b * count + i) * spread + offset
void multiply(const nn::RowLayer& p, const Rows& x, int64_t first, int64_t step, int64_t count, int64_t spread,
              int64_t offset, Scratch& scratch, float* y) {
  const int64_t total = x.batch * count, stride = p.w.stride();
  scratch.from.resize(static_cast<size_t>(total));
  scratch.to.resize(static_cast<size_t>(total));
  for (int64_t b = 0; b < x.batch; ++b) {
    for (int64_t i = 0; i < count; ++i) {
      const size_t r = static_cast<size_t>(b * count + i);
      scratch.from[r] = static_cast<int32_t>(b * x.pitch() / step + i);
      scratch.to[r] = static_cast<int32_t>(static_cast<int64_t>(r) * spread + offset);
    }
  }
  const float* source = x.data.data() + (kEdge + first) * x.channels;
  // Threads share the columns, so that each reads only its part of the weights; rows too where columns are few.
  const int64_t blocks = stride / nn::kColumnBlock, threads = at::get_num_threads();
  const int64_t parts = blocks % threads == 0 ? 1 : std::min(threads, std::max<int64_t>(1, total / 12));
  const int64_t rows_each = ((total + parts - 1) / parts + 5) / 6 * 6;  // the product goes by six rows
  nn::parallel_chunks(blocks * parts, [&](int64_t chunk) {
    const int64_t column = chunk / parts * nn::kColumnBlock, begin = std::min(total, chunk % parts * rows_each),
                  end = std::min(total, begin + rows_each);
    for (int64_t r = begin; r < end; ++r)
      std::copy_n(p.bias.data() + column, nn::kColumnBlock, y + scratch.to[static_cast<size_t>(r)] * stride + column);
    nn::accumulate_columns(p.w, column, column + nn::kColumnBlock, p.w.in, source, step * x.channels,
                           scratch.from.data() + begin, scratch.to.data() + begin, end - begin, y);
  });
}

/// out = mish(norm(y) * (1 + scale) + shift) + add, group by group.
/// @param y rows of `stride`. @param film (B, ...) scale and shift of this norm, `film_stride` apart, or nullptr.
/// @param add rows of `add_stride` for every clip, `add_pitch` apart, or nullptr.
void norm_mish(const Norm& norm, const float* y, int64_t stride, const float* film, int64_t film_stride,
               const float* add, int64_t add_stride, int64_t add_pitch, Rows& out) {
  const int64_t channels = out.channels, width = channels / kNormGroups, frames = out.frames;
  int64_t runs = 1;  // groups are dealt out in runs of at least 48 channels
  while (runs < kNormGroups && channels / (2 * runs) >= 48) runs *= 2;
  nn::parallel_chunks(out.batch * runs, [&](int64_t chunk) {
    const int64_t b = chunk / runs, first = chunk % runs * (channels / runs), columns = channels / runs;
    const float* x = y + b * frames * stride + first;
    std::vector<float> sums(static_cast<size_t>(columns)), scale(sums.size()), shift(sums.size());
    const auto mean_of = [&](int64_t from) {
      double sum = 0;
      for (int64_t c = from; c < from + width; ++c) sum += static_cast<double>(sums[static_cast<size_t>(c)]);
      return sum / static_cast<double>(width * frames);
    };
    nn::column_sums(x, stride, frames, columns, 0, false, sums.data());
    for (int64_t group = 0; group < columns; group += width) {
      const double mean = mean_of(group);
      nn::column_sums(x + group, stride, frames, width, static_cast<float>(mean), true, sums.data() + group);
      const double over = 1 / std::sqrt(mean_of(group) + norm.eps);
      for (int64_t c = group; c < group + width; ++c) {
        const size_t i = static_cast<size_t>(c), at = static_cast<size_t>(first + c);
        double a = over * static_cast<double>(norm.weight[at]);
        double s = static_cast<double>(norm.bias[at]) - mean * a;
        if (film != nullptr) {
          const double more = 1 + static_cast<double>(film[b * film_stride + first + c]);
          a *= more;
          s = s * more + static_cast<double>(film[b * film_stride + channels + first + c]);
        }
        scale[i] = static_cast<float>(a);
        shift[i] = static_cast<float>(s);
      }
    }
    nn::scaled_mish(x, stride, frames, columns, scale.data(), shift.data(),
                    add == nullptr ? nullptr : add + b * add_pitch + first, add_stride, out.clip(b) + first, channels);
  });
}

/// Rows of a product into columns of clips, from column `first` on.
void place(const float* y, int64_t stride, int64_t columns, Rows& out, int64_t first) {
  for (int64_t b = 0; b < out.batch; ++b)
    for (int64_t t = 0; t < out.frames; ++t)
      std::copy_n(y + (b * out.frames + t) * stride, columns, out.clip(b) + t * out.channels + first);
}

}  // namespace

struct FastDenoiser::Impl {
  struct Block {
    nn::RowLayer first, second, around;
    Norm first_norm, second_norm;
    int64_t out = 0, film = 0;  ///< channels; place of its scale and shift among all
    bool changes = false;       ///< channels, so that there is a product on the way round
    Rows inner, result;
  };
  struct Level {
    Block first, second;
    nn::RowLayer halve;      ///< of a level down
    nn::RowLayer even, odd;  ///< of a level up: frames 2 i and 2 i + 1
    Rows input;
  };

  explicit Impl(const Denoiser& of) : network(of) {
    TemporalUnet unet = network->unet;
    std::vector<Tensor> weights, biases;
    int64_t film = 0;
    const auto block = [&](TemporalBlock& from) {
      Block b;
      b.first = layer_of(from->first->conv);
      b.second = layer_of(from->second->conv);
      b.first_norm = norm_of(from->first->norm);
      b.second_norm = norm_of(from->second->norm);
      b.out = from->second->conv->weight.size(0);
      b.changes = !from->around.is_empty();
      if (b.changes) b.around = layer_of(from->around);
      b.film = film;
      film += 2 * b.out;
      weights.push_back(from->scale_shift->weight.detach());
      biases.push_back(from->scale_shift->bias.detach());
      return b;
    };
    for (auto& from : unet->downs) {
      Level level;
      level.first = block(from.first);
      level.second = block(from.second);
      if (!from.halve.is_empty()) level.halve = layer_of(from.halve);
      downs.push_back(std::move(level));
    }
    for (auto& from : unet->middle) middle.push_back(block(from));
    for (auto& from : unet->ups) {
      Level level;
      level.first = block(from.first);
      level.second = block(from.second);
      // (in, out, 4), stride 2, padding 1: frame 2 i sees i - 1 and i, frame 2 i + 1 sees i and i + 1.
      const Tensor w = from.twice->weight.permute({2, 0, 1});
      level.even = nn::row_layer_of_taps(torch::stack({w[3], w[1]}), from.twice->bias);
      level.odd = nn::row_layer_of_taps(torch::stack({w[2], w[0]}), from.twice->bias);
      ups.push_back(std::move(level));
    }
    last = layer_of(unet->last->conv);
    last_norm = norm_of(unet->last->norm);
    out = layer_of(unet->out_conv);
    film_weight = torch::cat(weights);
    film_bias = torch::cat(biases);
    features = unet->out_conv->weight.size(0);
  }

  const Rows& run(Block& block, const Rows& x, const Tensor& film) {
    const int64_t total = x.batch * x.frames, stride = block.first.w.stride(), film_stride = film.size(1);
    float* y = scratch.rows(2 * total, stride);
    float* beside = y + total * stride;
    block.inner.shape(x.batch, x.frames, block.out);
    block.result.shape(x.batch, x.frames, block.out);
    multiply(block.first, x, -kEdge, 1, x.frames, 1, 0, scratch, y);
    norm_mish(block.first_norm, y, stride, film.data_ptr<float>() + block.film, film_stride, nullptr, 0, 0,
              block.inner);
    multiply(block.second, block.inner, -kEdge, 1, x.frames, 1, 0, scratch, y);
    if (block.changes) {
      multiply(block.around, x, 0, 1, x.frames, 1, 0, scratch, beside);
      norm_mish(block.second_norm, y, stride, nullptr, 0, beside, stride, x.frames * stride, block.result);
    } else {
      norm_mish(block.second_norm, y, stride, nullptr, 0, x.clip(0), x.channels, x.pitch() * x.channels, block.result);
    }
    return block.result;
  }

  Tensor forward(const Tensor& input, const Tensor& embedding) {
    const Tensor c = nn::mish(network->unet->embed_out(nn::mish(network->unet->embed_in(embedding))));
    const Tensor film = torch::addmm(film_bias, c, film_weight.t());
    return through(input, film);
  }

  /// @param input (B, T, channels)
  Tensor through(const Tensor& input, const Tensor& film) {
    const int64_t batch = input.size(0), frames = input.size(1), padded = network->config.padded;
    if (frames != last_frames) start = Rows();  // zeros behind the clip again
    last_frames = frames;
    start.shape(batch, padded, input.size(2));
    for (int64_t b = 0; b < batch; ++b)
      std::copy_n(input.data_ptr<float>() + b * frames * start.channels, frames * start.channels, start.clip(b));

    const Rows* x = &start;
    for (size_t i = 0; i < downs.size(); ++i) {
      Level& level = downs[i];
      x = &run(level.second, run(level.first, *x, film), film);
      if (i + 1 == downs.size()) break;
      Rows& next = downs[i + 1].input;
      next.shape(batch, x->frames / 2, x->channels);
      const int64_t stride = level.halve.w.stride();
      float* y = scratch.rows(batch * next.frames, stride);
      multiply(level.halve, *x, -1, 2, next.frames, 1, 0, scratch, y);
      place(y, stride, next.channels, next, 0);
      x = &next;
    }
    for (Block& block : middle) x = &run(block, *x, film);
    for (size_t i = 0; i < ups.size(); ++i) {
      Level& level = ups[i];
      const Rows& left = downs[downs.size() - 1 - i].second.result;
      join(*x, left, level.input);
      x = &run(level.second, run(level.first, level.input, film), film);
      const int64_t stride = level.even.w.stride(), doubled = 2 * x->frames;
      float* y = scratch.rows(batch * doubled, stride);
      multiply(level.even, *x, -1, 1, x->frames, 2, 0, scratch, y);
      multiply(level.odd, *x, 0, 1, x->frames, 2, 1, scratch, y);
      twice.resize(ups.size());
      twice[i].shape(batch, doubled, x->channels);
      place(y, stride, x->channels, twice[i], 0);
      x = &twice[i];
    }
    const int64_t stride = last.w.stride();
    float* y = scratch.rows(batch * padded, std::max(stride, out.w.stride()));
    multiply(last, *x, -kEdge, 1, padded, 1, 0, scratch, y);
    end.shape(batch, padded, x->channels);
    norm_mish(last_norm, y, stride, nullptr, 0, nullptr, 0, 0, end);
    multiply(out, end, 0, 1, padded, 1, 0, scratch, y);
    return torch::from_blob(y, {batch, padded, out.w.stride()}, torch::kFloat32)
        .slice(1, 0, frames)
        .slice(2, 0, features)
        .transpose(1, 2)
        .contiguous();
  }

  /// x and what left the level of its length, side by side.
  static void join(const Rows& x, const Rows& left, Rows& both) {
    both.shape(x.batch, x.frames, x.channels + left.channels);
    for (int64_t b = 0; b < x.batch; ++b) {
      for (int64_t t = 0; t < x.frames; ++t) {
        float* row = both.clip(b) + t * both.channels;
        std::copy_n(x.clip(b) + t * x.channels, x.channels, row);
        std::copy_n(left.clip(b) + t * left.channels, left.channels, row + x.channels);
      }
    }
  }

  Denoiser network;
  std::vector<Level> downs, ups;
  std::vector<Block> middle;
  nn::RowLayer last, out;
  Norm last_norm;
  Tensor film_weight, film_bias;  ///< all blocks' scale and shift layers, one behind the other
  Rows start, end;
  std::vector<Rows> twice;
  Scratch scratch;
  int64_t features = 0, last_frames = 0;
};

FastDenoiser::FastDenoiser(const Denoiser& network) : impl_(std::make_unique<Impl>(network)) {}
FastDenoiser::~FastDenoiser() = default;
FastDenoiser::FastDenoiser(FastDenoiser&&) noexcept = default;
FastDenoiser& FastDenoiser::operator=(FastDenoiser&&) noexcept = default;

Tensor FastDenoiser::forward(const Tensor& x, const Tensor& mask, const Tensor& local, const Tensor& steps,
                             const Tensor& embedding) {
  const torch::NoGradGuard no_gradients;
  const Tensor input = torch::cat({x, mask, local}, 1).transpose(1, 2).contiguous();
  return impl_->forward(input, impl_->network->embed_steps(steps) + embedding);
}

Tensor FastDenoiser::guided(const Tensor& x, const Tensor& mask, const Tensor& local, int64_t t, const Tensor& scene,
                            const Tensor& shape, double guidance) {
  const torch::NoGradGuard no_gradients;
  const Tensor input = torch::cat({x, mask, local}, 1).transpose(1, 2).contiguous().repeat({2, 1, 1});
  const Tensor step = impl_->network->embed_steps(torch::full({1}, t, torch::kInt64));
  const std::vector<Tensor> both = impl_->forward(input, torch::cat({scene + shape, shape}) + step).chunk(2);
  return both[1] + guidance * (both[0] - both[1]);
}

Tensor FastDenoiser::residual(const Tensor& input, int64_t t, const Tensor& embedding) {
  const torch::NoGradGuard no_gradients;
  const torch::nn::Conv1d& stem = impl_->network->stem;
  const Tensor mixed = torch::nn::functional::linear(input.transpose(1, 2), stem->weight.squeeze(2), stem->bias);
  const Tensor step = impl_->network->embed_steps(torch::full({1}, t, torch::kInt64));
  return impl_->forward(mixed.contiguous(), step + embedding);
}

Tensor FastDenoiser::features() const {
  const Rows& end = impl_->end;
  Tensor out = torch::empty({end.batch, end.frames, end.channels});
  for (int64_t b = 0; b < end.batch; ++b)
    std::copy_n(end.clip(b), end.frames * end.channels, out.data_ptr<float>() + b * end.frames * end.channels);
  return out.slice(1, 0, impl_->last_frames).transpose(1, 2);
}

}  // namespace inhabit::inbetween
