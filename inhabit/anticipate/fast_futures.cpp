#include "inhabit/anticipate/fast_futures.h"

#include <ATen/Parallel.h>

#include <algorithm>

#include "inhabit/interruption.h"
#include "inhabit/nn/gru_kernel.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kFeatures = kFeatureCount;

/// Last state of a GRU over rows (t, F), from zero.
std::vector<float> encoded(const nn::RowGru& gru, const float* rows, int64_t frames) {
  std::vector<float> state(static_cast<size_t>(gru.hidden));
  nn::last_gru_state(gru, rows, frames, state.data());
  return state;
}

/// The intention decoder over the labels of several futures, a row each.
class LabelDecoder {
 public:
  LabelDecoder(const nn::RowGru& gru, const nn::RowLayer& out, int64_t rows)
      : gru_(gru),
        out_(out),
        rows_(rows),
        states_(floats(rows * gru.hidden)),
        recurrent_(floats(rows * gru.from_state.stride())),
        input_(floats(gru.from_input.stride())),
        logits_(floats(rows * out.stride())) {}

  /// A row begins with the observation's code.
  void start(int64_t row, const float* code) { std::copy_n(code, gru_.hidden, states_.data() + row * gru_.hidden); }
  /// (rows, logits_stride()) of the next labels; they may be changed.
  float* logits() {
    nn::apply(out_, states_.data(), gru_.hidden, rows_, logits_.data());
    return logits_.data();
  }
  int64_t logits_stride() const { return out_.stride(); }
  /// Goes on. @param labels one of each row, `stride` apart, of `count`
  void see(const int64_t* labels, int64_t stride, int64_t count) {
    nn::apply(gru_.from_state, states_.data(), gru_.hidden, rows_, recurrent_.data());
    label_.resize(static_cast<size_t>(count));
    for (int64_t r = 0; r < rows_; ++r) {
      std::fill(label_.begin(), label_.end(), 0.0F);
      label_[static_cast<size_t>(labels[r * stride])] = 1;
      gru_.input_gates(label_.data(), input_.data());
      float* state = states_.data() + r * gru_.hidden;
      nn::gru_update(gru_.hidden, input_.data(), recurrent_.data() + r * gru_.from_state.stride(), state, state);
    }
  }

 private:
  static std::vector<float> floats(int64_t count) { return std::vector<float>(static_cast<size_t>(count)); }

  const nn::RowGru& gru_;
  const nn::RowLayer& out_;
  int64_t rows_;
  std::vector<float> states_, recurrent_, input_, logits_, label_;
};

}  // namespace

FastFutures::FastFutures(const Networks& networks)
    : memory_(networks.memory), config_(networks.config), scale_(networks.scale) {
  if (config_.intention) {
    intention_encoder_ = nn::row_gru(*networks.intention->encoder);
    intention_decoder_ = nn::row_gru(*networks.intention->decoder);
    intention_out_ = nn::row_layer(networks.intention->out->weight, networks.intention->out->bias);
    const Tensor w = networks.pose->look_ahead->weight.detach().permute({2, 1, 0}).contiguous();
    const Tensor b = networks.pose->look_ahead->bias.detach().contiguous();
    look_ahead_.assign(w.data_ptr<float>(), w.data_ptr<float>() + w.numel());
    look_ahead_bias_.assign(b.data_ptr<float>(), b.data_ptr<float>() + b.numel());
  }
  pose_encoder_ = nn::row_gru(*networks.pose->encoder);
  for (size_t i = 0; i < 3; ++i) layers_[i] = nn::row_gru(*networks.pose->layers[i]);
  pose_out_ = nn::row_layer(networks.pose->out->weight, networks.pose->out->bias);
  const Tensor weight = networks.pose->pull.detach().sigmoid().contiguous();
  pull_.assign(weight.data_ptr<float>(), weight.data_ptr<float>() + weight.numel());
}

void FastFutures::draw_intention(const float* code, const float* gumbel, int64_t frames, int64_t* labels) const {
  const int64_t count = config_.labels;
  LabelDecoder decoder(intention_decoder_, intention_out_, 1);
  decoder.start(0, code);
  for (int64_t t = 0; t < frames; ++t, gumbel += count) {
    interruption_point();
    float* logits = decoder.logits();
    for (int64_t c = 0; c < count; ++c) logits[c] += gumbel[c];
    labels[t] = std::max_element(logits, logits + count) - logits;
    decoder.see(labels + t, 1, count);
  }
}

Followed FastFutures::follow(const Tensor& past, const FutureNoise& noise, int64_t frames) const {
  const Tensor choice = noise.choice.slice(1, 0, frames + config_.gamma - 1);
  if (!config_.intention) return memory_->follow(past, choice).to_network(scale_);
  const torch::NoGradGuard no_gradients;
  const Tensor seen = scale_.to_network(past).contiguous();
  const int64_t samples = choice.size(0);
  LabelDecoder decoder(intention_decoder_, intention_out_, samples);
  std::vector<float> code;
  for (int64_t s = 0; s < samples; ++s) {
    if (s < past.size(0)) code = encoded(intention_encoder_, seen[s].data_ptr<float>(), seen.size(1));
    decoder.start(s, code.data());
  }
  const auto scores = [&] {
    const Tensor logits = torch::from_blob(decoder.logits(), {samples, decoder.logits_stride()});
    return logits.slice(1, 0, config_.labels).log_softmax(1) * config_.inference.memory_label;
  };
  const auto see = [&](const Tensor& labels) {
    decoder.see(labels.data_ptr<int64_t>(), labels.stride(0), config_.labels);
  };
  return memory_->follow(past, choice, {}, scores, see).to_network(scale_);
}

void FastFutures::decode(const float* code, const float* z, const float* pose, const int64_t* labels,
                         const float* followed, const float* changes, int64_t samples, int64_t frames,
                         float* out) const {
  const int64_t hidden = config_.hidden, noise = config_.noise, words = frames + config_.gamma - 1,
                ahead = config_.intention ? config_.intention_features : 0,
                width = kFeatures * (followed != nullptr ? 2 : 1) + ahead;
  const auto rows = [&](int64_t columns) { return std::vector<float>(static_cast<size_t>(samples * columns)); };
  std::vector<float> x = rows(width), change = rows(pose_out_.stride()), input = rows(layers_[0].from_input.stride()),
                     recurrent = rows(layers_[0].from_state.stride()), states[3];
  for (auto& layer : states) layer = rows(hidden);
  for (int64_t s = 0; s < samples; ++s) {
    std::copy_n(pose, kFeatures, x.data() + s * width);
    for (auto& layer : states) {
      std::copy_n(code, hidden - noise, layer.data() + s * hidden);
      std::copy_n(z + s * noise, noise, layer.data() + (s + 1) * hidden - noise);
    }
  }
  for (int64_t t = 0; t < frames; ++t) {
    interruption_point();
    for (int64_t s = 0; s < samples && ahead > 0; ++s) {
      // One-hot labels pick columns of the temporal convolution.
      float* seen = x.data() + s * width + kFeatures;
      std::copy(look_ahead_bias_.begin(), look_ahead_bias_.end(), seen);
      const int64_t* label = labels + s * words + t;
      for (int64_t g = 0; g < config_.gamma; ++g) {
        const float* column = look_ahead_.data() + (g * config_.labels + label[g]) * ahead;
        for (int64_t i = 0; i < ahead; ++i) seen[i] += column[i];
      }
    }
    for (int64_t s = 0; s < samples && followed != nullptr; ++s) {
      const float *now = x.data() + s * width, *memory = followed + (s * words + t) * kFeatures;
      float* apart = x.data() + s * width + kFeatures + ahead;
      for (int64_t i = 0; i < kFeatures; ++i) apart[i] = memory[i] - now[i];
    }
    const float* below = x.data();
    int64_t below_stride = width;
    for (size_t i = 0; i < 3; ++i) {
      const nn::RowGru& gru = layers_[i];
      nn::apply(gru.from_input, below, below_stride, samples, input.data());
      nn::apply(gru.from_state, states[i].data(), hidden, samples, recurrent.data());
      for (int64_t s = 0; s < samples; ++s) {
        float* state = states[i].data() + s * hidden;
        nn::gru_update(hidden, input.data() + s * gru.from_input.stride(),
                       recurrent.data() + s * gru.from_state.stride(), state, state);
      }
      below = states[i].data();
      below_stride = hidden;
    }
    nn::apply(pose_out_, below, hidden, samples, change.data());
    for (int64_t s = 0; s < samples; ++s) {
      float *now = x.data() + s * width, *kept = out + (s * frames + t) * kFeatures;
      const float* y = change.data() + s * pose_out_.stride();
      const auto go_on = [&](int64_t i, float own_change, float target) {
        kept[i] = now[i] += y[i] + own_change + pull_[static_cast<size_t>(i)] * (y[kFeatures + i] + target - now[i]);
      };
      const int64_t at = (s * words + t) * kFeatures;
      for (int64_t i = 0; i < kFeatures; ++i)
        followed != nullptr ? go_on(i, changes[at + i], followed[at + i]) : go_on(i, 0, 0);
    }
  }
}

Futures FastFutures::forward(const Tensor& past, const FutureNoise& noise, int64_t frames) const {
  const torch::NoGradGuard no_gradients;
  const int64_t samples = noise.z.size(0), words = frames + config_.gamma - 1, observed = past.size(1);
  const bool shared = past.size(0) == 1;
  const Tensor seen = scale_.to_network(past).contiguous(), z = noise.z.contiguous();
  const Tensor gumbel = noise.gumbel.slice(1, 0, words).contiguous();
  Tensor x = torch::empty({samples, frames, kFeatures}), labels;
  Followed followed;
  if (memory_) {
    followed = follow(past, noise, frames);
    labels = config_.intention ? followed.labels : Tensor();
    followed.features = followed.features.contiguous();
    followed.changes = followed.changes.contiguous();
  } else if (config_.intention) {
    labels = torch::empty({samples, words}, torch::kInt64);
  }
  const auto rows_of = [&](int64_t s) { return seen.data_ptr<float>() + (shared ? 0 : s) * observed * kFeatures; };
  // Chunks as even as threads are; different observations one by one.
  const int64_t chunk = shared ? (samples + at::get_num_threads() - 1) / at::get_num_threads() : 1;
  std::vector<float> intention_code, pose_code;
  if (shared) {
    if (config_.intention && !memory_) intention_code = encoded(intention_encoder_, rows_of(0), observed);
    pose_code = encoded(pose_encoder_, rows_of(0), observed);
  }
  nn::parallel_chunks((samples + chunk - 1) / chunk, [&](int64_t c) {
    const int64_t first = c * chunk, some = std::min(chunk, samples - first);
    int64_t* drawn = config_.intention ? labels.data_ptr<int64_t>() + first * words : nullptr;
    if (config_.intention && !memory_) {
      const std::vector<float> code = shared ? intention_code : encoded(intention_encoder_, rows_of(first), observed);
      for (int64_t s = 0; s < some; ++s)
        draw_intention(code.data(), gumbel.data_ptr<float>() + (first + s) * words * config_.labels, words,
                       drawn + s * words);
    }
    const std::vector<float> code = shared ? pose_code : encoded(pose_encoder_, rows_of(first), observed);
    const auto of = [&](const Tensor& all) {
      return memory_ ? all.data_ptr<float>() + first * words * kFeatures : nullptr;
    };
    decode(code.data(), z.data_ptr<float>() + first * config_.noise, rows_of(first) + (observed - 1) * kFeatures, drawn,
           of(followed.features), of(followed.changes), some, frames, x.data_ptr<float>() + first * frames * kFeatures);
  });
  return {scale_.from_network(x), labels.defined() ? labels.slice(1, 0, frames) : labels};
}

}  // namespace inhabit::anticipate
