#include "inhabit/inbetween/temporal_unet.h"

#include "inhabit/nn/mish.h"

namespace inhabit::inbetween {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

tn::Conv1d conv1d(int64_t in, int64_t out, int64_t taps, int64_t stride = 1) {
  return tn::Conv1d(tn::Conv1dOptions(in, out, taps).stride(stride).padding(taps / 2));
}

template <class Layer>
void start_at_zero(Layer& layer) {
  tn::init::zeros_(layer->weight);
  tn::init::zeros_(layer->bias);
}

/// A module without a part of its own, for the names of the release.
std::shared_ptr<tn::Module> folder(tn::Module& parent, const std::string& name) {
  return parent.register_module(name, std::make_shared<tn::Module>());
}

}  // namespace

ConvNormImpl::ConvNormImpl(int64_t in, int64_t out) {
  conv = register_module("0", conv1d(in, out, kTaps));
  norm = register_module("2", tn::GroupNorm(kNormGroups, out));
}

TemporalBlockImpl::TemporalBlockImpl(int64_t in, int64_t out, int64_t embedding) {
  const auto blocks = folder(*this, "blocks");
  first = folder(*blocks, "0")->register_module("block1", ConvNorm(in, out));
  second = folder(*blocks, "1")->register_module("block", ConvNorm(out, out));
  scale_shift = folder(*this, "time_mlp")->register_module("1", tn::Linear(embedding, 2 * out));
  if (in != out) around = register_module("residual_conv", conv1d(in, out, 1));
  start_at_zero(second->conv);
  start_at_zero(scale_shift);
}

Tensor TemporalBlockImpl::forward(const Tensor& x, const Tensor& embedding) {
  const std::vector<Tensor> c = scale_shift(embedding).unsqueeze(2).chunk(2, 1);
  const Tensor inner = second(nn::mish(first(x) * (1 + c[0]) + c[1]));
  return nn::mish(inner) + (around.is_empty() ? x : around(x));
}

TemporalUnetImpl::TemporalUnetImpl(int64_t in, int64_t out, int64_t width, const std::vector<int>& multipliers) {
  std::vector<int64_t> widths{in};
  for (const int m : multipliers) widths.push_back(width * m);
  const size_t levels = multipliers.size();

  const auto time = folder(*this, "time_mlp");
  embed_in = time->register_module("0", tn::Linear(width, 4 * width));
  embed_out = time->register_module("2", tn::Linear(4 * width, width));
  const auto down_list = folder(*this, "downs"), up_list = folder(*this, "ups");
  for (size_t i = 0; i < levels; ++i) {
    const auto parts = folder(*down_list, std::to_string(i));
    Down level;
    level.first = parts->register_module("0", TemporalBlock(widths[i], widths[i + 1], width));
    level.second = parts->register_module("1", TemporalBlock(widths[i + 1], widths[i + 1], width));
    if (i + 1 < levels)
      level.halve = folder(*parts, "3")->register_module("conv", conv1d(widths[i + 1], widths[i + 1], 3, 2));
    downs.push_back(level);
  }
  for (int i = 0; i < 2; ++i)
    middle[i] =
        register_module("mid_block" + std::to_string(i + 1), TemporalBlock(widths[levels], widths[levels], width));
  for (size_t i = 0; i + 1 < levels; ++i) {
    const auto parts = folder(*up_list, std::to_string(i));
    const int64_t from = widths[levels - i], to = widths[levels - i - 1];
    Up level;
    level.first = parts->register_module("0", TemporalBlock(2 * from, to, width));
    level.second = parts->register_module("1", TemporalBlock(to, to, width));
    level.twice =
        folder(*parts, "3")
            ->register_module("conv", tn::ConvTranspose1d(tn::ConvTranspose1dOptions(to, to, 4).stride(2).padding(1)));
    ups.push_back(level);
  }
  const auto end = folder(*this, "final_conv");
  last = folder(*end, "0")->register_module("block", ConvNorm(widths[1], widths[1]));
  out_conv = end->register_module("1", conv1d(widths[1], out, 1));
  start_at_zero(out_conv);
}

Tensor TemporalUnetImpl::forward(Tensor x, const Tensor& embedding) {
  return out_conv(features(std::move(x), embedding));
}

Tensor TemporalUnetImpl::features(Tensor x, const Tensor& embedding) {
  const Tensor c = nn::mish(embed_out(nn::mish(embed_in(embedding))));
  std::vector<Tensor> left;
  for (Down& level : downs) {
    x = level.second(level.first(x, c), c);
    left.push_back(x);
    if (!level.halve.is_empty()) x = level.halve(x);
  }
  for (TemporalBlock& block : middle) x = block(x, c);
  for (Up& level : ups) {
    x = level.twice(level.second(level.first(torch::cat({x, left.back()}, 1), c), c));
    left.pop_back();
  }
  return nn::mish(last(x));
}

}  // namespace inhabit::inbetween
