#include "inhabit/interact/fast_control_network.h"

#include <algorithm>

namespace inhabit::interact {

using torch::Tensor;

namespace {

constexpr int64_t kUnits = kExpertColumns / 4;

PackedExperts packed_layer(const Tensor& weight, const Tensor& bias) {
  const Tensor w = weight.detach().to(torch::kCPU, torch::kFloat32).contiguous(),
               b = bias.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  return pack_experts(w.data_ptr<float>(), b.data_ptr<float>(), 1, w.size(0), w.size(1));
}

/// Rows of the gates i, f, g, o (4 width, ...) as blocks of 16 units' four gates, zeros beyond the last unit.
Tensor by_units(const Tensor& gates, int64_t width) {
  const int64_t blocks = (width + kUnits - 1) / kUnits;
  Tensor padded = torch::zeros({4, blocks * kUnits, gates.size(1)});
  padded.slice(1, 0, width) = gates.view({4, width, -1});
  return padded.view({4, blocks, kUnits, -1}).transpose(0, 1).reshape({blocks * kExpertColumns, -1});
}

}  // namespace

FastControlNetwork::FastControlNetwork(const ControlNetwork& network) {
  const torch::NoGradGuard no_gradients;
  const auto p = network->named_parameters();
  const auto layer = [&](const std::string& name) { return packed_layer(p[name + ".weight"], p[name + ".bias"]); };
  for (const int i : {0, 1}) {
    pose_encoder_[i] = layer("encoder1." + std::to_string(2 * i));
    control_encoder_[i] = layer("encoder2." + std::to_string(2 * i));
  }
  out_ = layer("fc");
  pose_ = pose_encoder_[0].in;
  control_ = control_encoder_[0].in;
  wide_ = pose_encoder_[0].out;
  width_ = out_.in;
  for (int64_t l = 0; l < network->h0.size(0); ++l) {
    const auto of = [&](const std::string& name) { return p["rnn." + name + "_l" + std::to_string(l)]; };
    const Tensor weight = torch::cat({of("weight_ih"), of("weight_hh")}, 1), bias = of("bias_ih") + of("bias_hh");
    lstm_.push_back(packed_layer(by_units(weight, width_), by_units(bias.unsqueeze(1), width_).squeeze(1)));
  }
  for (const Tensor& t : {network->h0, network->c0}) {
    const Tensor values = t.detach().to(torch::kCPU, torch::kFloat32).contiguous();
    start_.insert(start_.end(), values.data_ptr<float>(), values.data_ptr<float>() + values.numel());
  }
  for (const PackedExperts* part :
       {&pose_encoder_[0], &pose_encoder_[1], &control_encoder_[0], &control_encoder_[1], &out_})
    multiplications_ += part->numbers();
  for (const PackedExperts& part : lstm_) multiplications_ += part.numbers();
}

void FastControlNetwork::start(float* state) const { std::copy(start_.begin(), start_.end(), state); }

void FastControlNetwork::run_lstm(size_t layer, int64_t block, int64_t first_row, int64_t rows, float* state,
                                  Workspace& workspace) const {
  const PackedExperts& w = lstm_[layer];
  alignas(64) float gates[kExpertRows * kExpertColumns];
  expert_products(w, block, workspace.inputs[layer].data() + first_row * w.in, w.in, nullptr, 0, rows,
                  Activation::kNone, gates, kExpertColumns);
  std::vector<float>& next = workspace.inputs[layer + 1];
  const int64_t next_stride = layer + 1 < lstm_.size() ? lstm_[layer + 1].in : width_;
  const int64_t first = block * kUnits, units = std::min(kUnits, width_ - first);
  for (int64_t r = 0; r < rows; ++r) {
    float* hidden = state + (first_row + r) * state_size() + static_cast<int64_t>(layer) * width_ + first;
    float* cell = hidden + layers() * width_;
    float cells[kUnits] = {}, hiddens[kUnits];  // beside the last unit lies the next person's state
    std::copy_n(cell, units, cells);
    lstm_units(gates + r * kExpertColumns, cells, hiddens);
    std::copy_n(cells, units, cell);
    std::copy_n(hiddens, units, hidden);
    std::copy_n(hiddens, units, next.data() + (first_row + r) * next_stride + first);
  }
}

void FastControlNetwork::step(const float* pose, const float* control, int64_t rows, float* state, float* out,
                              Workspace& workspace) const {
  workspace.inputs.resize(lstm_.size() + 1);
  const auto grow = [&](std::vector<float>& to, int64_t columns) {
    if (to.size() < static_cast<size_t>(rows * columns)) to.resize(static_cast<size_t>(rows * columns));
  };
  grow(workspace.encoders, 2 * wide_);
  grow(workspace.inputs.back(), width_);
  for (size_t l = 0; l < lstm_.size(); ++l) {
    const int64_t in = lstm_[l].in;
    grow(workspace.inputs[l], in);
    for (int64_t r = 0; r < rows; ++r)
      std::copy_n(state + r * state_size() + static_cast<int64_t>(l) * width_, width_,
                  workspace.inputs[l].data() + (r + 1) * in - width_);
  }
  const int64_t chunks = (rows + kExpertRows - 1) / kExpertRows, blocks = pose_encoder_[0].blocks();
  WorkStages& work = workspace.stages;
  work.stages = 0;
  work.add(2 * blocks * chunks);
  work.add(2 * blocks * chunks);
  for (const PackedExperts& layer : lstm_) work.add(layer.blocks() * chunks);
  work.add(out_.blocks() * chunks);
  work.run(threads_for(rows * multiplications_), [&](int stage, int64_t number) {
    const int64_t first = number % chunks * kExpertRows, some = std::min(kExpertRows, rows - first);
    int64_t block = number / chunks;
    if (stage < 2) {
      const bool of_pose = block < blocks;
      if (!of_pose) block -= blocks;
      const int64_t column = (of_pose ? 0 : wide_) + block * kExpertColumns;
      const PackedExperts& layer = (of_pose ? pose_encoder_ : control_encoder_)[stage];
      float* hidden = workspace.encoders.data() + first * 2 * wide_;
      const float* in = of_pose ? pose + first * pose_ : control + first * control_;
      if (stage == 0)
        expert_products(layer, block, in, layer.in, nullptr, 0, some, Activation::kLeaky, hidden + column, 2 * wide_);
      else
        expert_products(layer, block, hidden + (of_pose ? 0 : wide_), 2 * wide_, nullptr, 0, some, Activation::kLeaky,
                        workspace.inputs[0].data() + first * lstm_[0].in + column, lstm_[0].in);
    } else if (stage < 2 + static_cast<int>(lstm_.size())) {
      run_lstm(static_cast<size_t>(stage - 2), block, first, some, state, workspace);
    } else {
      expert_products(out_, block, workspace.inputs.back().data() + first * width_, width_, nullptr, 0, some,
                      Activation::kNone, out + first * control_ + block * kExpertColumns, control_);
    }
  });
}

}  // namespace inhabit::interact
