#include "inhabit/forecast/fast_motion_network.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/dct.h"
#include "inhabit/nn/gru_kernel.h"

namespace inhabit::forecast {

using torch::Tensor;

namespace {

nn::RowLayer linear(const torch::nn::Linear& layer) { return nn::row_layer(layer->weight, layer->bias); }

void tanh_in_place(std::vector<float>& x) {
  for (float& value : x) value = std::tanh(value);
}

}  // namespace

FastMotionNetwork::FastMotionNetwork(const MotionNetwork& network)
    : config_(network->config),
      with_contact_(network->with_contact),
      encode_past_(linear(network->x_enc)),
      decode_in_(linear(network->out_enc)),
      decode_out_(linear(network->out_mlp)),
      past_gru_(nn::row_gru(*network->x_gru)),
      decode_gru_(nn::row_gru(*network->out_gru)),
      padded_dct_(padded_dct_matrix(config_.past, config_.future, config_.root_coefficients)),
      idct_(idct_matrix(config_.frames(), config_.root_coefficients)) {
  if (with_contact_) {
    encode_contact_ = linear(network->cont_enc);
    contact_gru_ = nn::row_gru(*network->cont_gru);
  }
  for (const torch::nn::Sequential& block : {network->g_w1, network->g_w2, network->g_w3}) {
    const auto modules = block->children();
    for (size_t i = 0; i + 1 < modules.size(); i += 3) {
      const auto p = modules[i]->named_parameters();
      path_layers_.push_back(nn::row_layer(p["weight"], p["bias"], nn::folded_norm(*modules[i + 1], nn::kNormEps)));
    }
  }
  path_layers_.push_back(linear(network->g_w4));
}

void FastMotionNetwork::run(const float* past_local, const float* path_dct, const float* contact_points,
                            float* root_path, float* local) const {
  const int64_t hidden = config_.hidden, pose = config_.joints * 3, touch = with_contact_ ? config_.joints * 4 : 0;
  const int64_t path_inputs = config_.root_coefficients * 3, wide = path_layers_.front().stride();
  std::vector<float> code(static_cast<size_t>(hidden));
  nn::last_gru_state(encode_past_, past_gru_, past_local, config_.past, code.data());

  // Root path: a residual MLP on its padded DCT coefficients.
  std::vector<float> input(path_dct, path_dct + path_inputs);
  input.insert(input.end(), code.begin(), code.end());
  if (with_contact_) {
    input.resize(input.size() + static_cast<size_t>(hidden));
    nn::last_gru_state(encode_contact_, contact_gru_, contact_points, config_.future,
                       input.data() + path_inputs + hidden);
  }
  std::vector<float> h(static_cast<size_t>(wide)), a(static_cast<size_t>(wide)), b(static_cast<size_t>(wide));
  nn::apply(path_layers_[0], input.data(), path_layers_[0].w.in, 1, h.data());
  tanh_in_place(h);
  for (const size_t layer : {size_t{1}, size_t{3}}) {
    nn::apply(path_layers_[layer], h.data(), wide, 1, a.data());
    tanh_in_place(a);
    nn::apply(path_layers_[layer + 1], a.data(), wide, 1, b.data());
    tanh_in_place(b);
    for (int64_t i = 0; i < hidden; ++i) h[i] += b[i];
  }
  std::vector<float> coefficients(static_cast<size_t>(path_layers_.back().stride()));
  nn::apply(path_layers_.back(), h.data(), wide, 1, coefficients.data());
  for (int64_t i = 0; i < path_inputs; ++i) coefficients[i] += path_dct[i];
  const float* basis = idct_.data_ptr<float>();
  for (int64_t t = 0; t < config_.frames(); ++t) {
    float sum[3] = {0, 0, 0};
    for (int64_t l = 0; l < config_.root_coefficients; ++l) {
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += basis[t * config_.root_coefficients + l] * coefficients[3 * l + axis];
    }
    std::copy_n(sum, 3, root_path + 3 * t);
  }

  // Local poses, frame by frame.
  std::vector<float> seen(static_cast<size_t>(pose + 3 + touch)), encoded(static_cast<size_t>(decode_in_.stride())),
      input_gates(static_cast<size_t>(decode_gru_.from_input.stride())),
      state_gates(static_cast<size_t>(decode_gru_.from_state.stride())),
      change(static_cast<size_t>(decode_out_.stride())), state = code;
  std::copy_n(past_local + (config_.past - 1) * pose, pose, seen.data());
  decode_gru_.state_gates(code.data(), state_gates.data());
  for (int64_t t = 0; t < config_.future; ++t) {
    std::copy_n(root_path + 3 * (config_.past + t), 3, seen.data() + pose);
    if (with_contact_) std::copy_n(contact_points + t * touch, touch, seen.data() + pose + 3);
    nn::apply(decode_in_, seen.data(), decode_in_.w.in, 1, encoded.data());
    decode_gru_.input_gates(encoded.data(), input_gates.data());
    if (!config_.decode_from_past && t > 0) decode_gru_.state_gates(state.data(), state_gates.data());
    nn::gru_update(decode_gru_.hidden, input_gates.data(), state_gates.data(),
                   config_.decode_from_past ? code.data() : state.data(), state.data());
    nn::apply(decode_out_, state.data(), hidden, 1, change.data());
    for (int64_t i = 0; i < pose; ++i) seen[i] += change[i];
    std::copy_n(seen.data(), pose, local + t * pose);
  }
}

MotionForecast FastMotionNetwork::forward(const Tensor& past, const Tensor& contact_points) const {
  torch::NoGradGuard no_gradients;
  const int64_t joints = config_.joints;
  if (past.dim() != 4 || past.sizes().slice(1) != at::IntArrayRef({config_.past, joints, 3}) ||
      (with_contact_ && (!contact_points.defined() ||
                         contact_points.sizes() != at::IntArrayRef({past.size(0), config_.future, joints, 4}))))
    throw Error("forecast network: past or contact_points has the wrong shape");
  const auto plain = [](const Tensor& x) { return x.detach().to(torch::kCPU, torch::kFloat32).contiguous(); };
  const int64_t batch = past.size(0);
  const Tensor world = plain(past), poses = local_pose(world, config_.root).contiguous();
  const Tensor path_dct = padded_dct_.matmul(world.select(2, config_.root)).contiguous();  // (B, coefficients, 3)
  const Tensor touched = with_contact_ ? plain(contact_points) : Tensor();
  MotionForecast forecast{torch::empty({batch, config_.frames(), 3}), torch::empty({batch, config_.future, joints, 3})};
  at::parallel_for(0, batch, 1, [&](int64_t first, int64_t last) {
    for (int64_t b = first; b < last; ++b)
      run(poses.data_ptr<float>() + b * config_.past * joints * 3,
          path_dct.data_ptr<float>() + b * config_.root_coefficients * 3,
          with_contact_ ? touched.data_ptr<float>() + b * config_.future * joints * 4 : nullptr,
          forecast.root_path.data_ptr<float>() + b * config_.frames() * 3,
          forecast.local.data_ptr<float>() + b * config_.future * joints * 3);
  });
  return forecast;
}

}  // namespace inhabit::forecast
