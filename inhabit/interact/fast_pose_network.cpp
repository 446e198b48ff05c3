#include "inhabit/interact/fast_pose_network.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit::interact {

using torch::Tensor;

namespace {

Tensor plain_floats(const Tensor& t) { return t.detach().to(torch::kCPU, torch::kFloat32).contiguous(); }

/// @param weight (experts, out, in); @param bias (experts, out).
PackedExperts packed(const Tensor& weight, const Tensor& bias) {
  const Tensor w = plain_floats(weight), b = plain_floats(bias);
  return pack_experts(w.data_ptr<float>(), b.data_ptr<float>(), w.size(0), w.size(1), w.size(2));
}
PackedExperts packed(const torch::nn::Linear& linear) {
  return packed(linear->weight.unsqueeze(0), linear->bias.unsqueeze(0));
}

void softmax(float* x, int64_t count) {
  const float most = *std::max_element(x, x + count);
  float sum = 0;
  for (int64_t i = 0; i < count; ++i) sum += x[i] = std::exp(x[i] - most);
  for (int64_t i = 0; i < count; ++i) x[i] /= sum;
}

}  // namespace

FastPoseNetwork::FastPoseNetwork(const PoseNetwork& network) : sizes_(network->sizes) {
  using Store = Piece::Store;
  if (sizes_.experts > kExpertColumns) throw Error("PoseNet", "has more experts than the fast evaluation takes");
  // Encoders and the gating network side by side, each layer a stage; every network's rows in columns of their own, of
  // layers in turn two such.
  const auto chain = [&](const std::vector<torch::nn::Linear>& linears, int64_t from_column, Store last,
                         int64_t last_column, Activation last_activation) {
    Store from = Store::kInput;
    for (size_t i = 0; i < linears.size(); ++i) {
      Piece piece{packed(linears[i]), from, last, from_column, last_column, last_activation};
      if (i + 1 < linears.size()) {
        piece.to = Store::kLayers;
        piece.to_column = wide_;
        piece.activation = Activation::kElu;
        wide_ += piece.layer.out;
      }
      from = piece.to;
      from_column = piece.to_column;
      add(i, std::move(piece));
    }
  };
  int64_t input = 0;
  for (size_t i = 0; i < network->encoders.size(); ++i) {
    std::vector<torch::nn::Linear> linears;
    for (const auto& module : network->encoders[i]->children())
      if (auto linear = std::dynamic_pointer_cast<torch::nn::LinearImpl>(module)) linears.emplace_back(linear);
    chain(linears, input, Store::kCodes, code_, Activation::kElu);
    input += sizes_.inputs[i];
    code_ += sizes_.encoders[i];
  }
  const GatingNetwork& gating = network->gating;
  chain({gating->fc0, gating->fc1, gating->fc2}, sizes_.row - sizes_.gating, Store::kGates, 0, Activation::kNone);

  Store from = Store::kCodes;
  int64_t from_column = 0;
  const auto& experts = *network->experts;
  for (size_t i = 0; i < experts.weights.size(); ++i) {
    const bool last = i + 1 == experts.weights.size();
    Piece piece{packed(experts.weights[i], experts.biases[i]),
                from,
                last ? Store::kOutput : Store::kLayers,
                from_column,
                last ? 0 : wide_,
                last ? Activation::kNone : Activation::kElu,
                /*gated=*/true};
    if (!last) wide_ += piece.layer.out;
    from = piece.to;
    from_column = piece.to_column;
    add(stages_.size(), std::move(piece));
  }
  if (stages_.size() > WorkStages::kMost) throw Error("PoseNet", "has more layers than the fast evaluation takes");
}

void FastPoseNetwork::add(size_t stage, Piece piece) {
  if (stage >= stages_.size()) stages_.resize(stage + 1);
  Stage& to = stages_[stage];
  piece.first_block = to.empty() ? 0 : to.back().first_block + to.back().layer.blocks();
  multiplications_ += piece.layer.numbers();
  to.push_back(std::move(piece));
}

void FastPoseNetwork::run(const Piece& piece, int64_t block, int64_t first_row, int64_t rows, const float* x, float* y,
                          Workspace& workspace) const {
  using Store = Piece::Store;
  const auto row_of = [&](Store place) -> std::pair<float*, int64_t> {
    switch (place) {
      case Store::kCodes:
        return {workspace.codes.data(), code_};
      case Store::kGates:
        return {workspace.gates.data(), sizes_.experts};
      case Store::kOutput:
        return {y, sizes_.outputs};
      default:
        return {workspace.layers.data(), wide_};
    }
  };
  const bool from_input = piece.from == Store::kInput;
  const auto [source, source_stride] = row_of(piece.from);
  const int64_t in_stride = from_input ? sizes_.row : source_stride;
  const float* in = (from_input ? x : source) + first_row * in_stride + piece.from_column;
  const auto [target, out_stride] = row_of(piece.to);
  float* out = target + first_row * out_stride + piece.to_column + block * kExpertColumns;
  const float* gates = piece.gated ? workspace.gates.data() + first_row * sizes_.experts : nullptr;
  expert_products(piece.layer, block, in, in_stride, gates, sizes_.experts, rows, piece.activation, out, out_stride);
  if (piece.to == Store::kGates)
    for (int64_t r = 0; r < rows; ++r) softmax(out + r * out_stride, sizes_.experts);
}

void FastPoseNetwork::forward(const float* x, int64_t rows, float* y, Workspace& workspace) const {
  const auto grow = [&](std::vector<float>& to, int64_t columns) {
    if (to.size() < static_cast<size_t>(rows * columns)) to.resize(static_cast<size_t>(rows * columns));
  };
  grow(workspace.codes, code_);
  grow(workspace.layers, wide_);
  grow(workspace.gates, sizes_.experts);
  const int64_t chunks = (rows + kExpertRows - 1) / kExpertRows;
  WorkStages& work = workspace.stages;
  work.stages = 0;
  for (const Stage& stage : stages_) work.add((stage.back().first_block + stage.back().layer.blocks()) * chunks);
  work.run(threads_for(rows * multiplications_), [&](int stage, int64_t number) {
    const int64_t block = number / chunks, first = number % chunks * kExpertRows;
    const Stage& pieces = stages_[static_cast<size_t>(stage)];
    size_t i = pieces.size() - 1;
    while (block < pieces[i].first_block) --i;
    run(pieces[i], block - pieces[i].first_block, first, std::min(kExpertRows, rows - first), x, y, workspace);
  });
}

Tensor FastPoseNetwork::forward(const Tensor& x) const {
  if (x.dim() != 2 || x.size(1) != sizes_.row) throw Error("PoseNet", "its rows have the wrong size");
  const Tensor rows = plain_floats(x);
  Tensor y = torch::empty({x.size(0), sizes_.outputs});
  Workspace workspace;
  forward(rows.data_ptr<float>(), x.size(0), y.data_ptr<float>(), workspace);
  return y;
}

}  // namespace inhabit::interact
