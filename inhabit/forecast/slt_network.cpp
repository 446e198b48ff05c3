#include "inhabit/forecast/slt_network.h"

#include "inhabit/forecast/network.h"
#include "inhabit/nn/last_state.h"

namespace inhabit::forecast {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

// Widths of the released networks.
constexpr int64_t kPointWidths[] = {64, 128, 256};
constexpr int64_t kSceneCode = 32, kPathCode = 64;

/// Two layers that a vector is added to again behind them.
struct ResidualImpl : tn::Module {
  explicit ResidualImpl(int64_t width)
      : first(register_module("first", tn::Linear(width, width))),
        second(register_module("second", tn::Linear(width, width))) {}
  Tensor forward(const Tensor& x) {
    return x + torch::leaky_relu(second->forward(torch::leaky_relu(first->forward(x))));
  }
  tn::Linear first, second;
};
TORCH_MODULE(Residual);

tn::Sequential residual_layers(int64_t inputs, int64_t width, int64_t outputs) {
  return tn::Sequential(tn::Linear(inputs, width), Residual(width), Residual(width), tn::Linear(width, outputs));
}

tn::Sequential two_layers(int64_t inputs, int64_t width, int64_t outputs) {
  return tn::Sequential(tn::Linear(inputs, width), tn::ReLU(), tn::Linear(width, outputs));
}

tn::Sequential point_layers() {
  tn::Sequential out;
  int64_t inputs = 3;
  for (const int64_t outputs : kPointWidths) {
    if (inputs != 3) out->push_back(tn::ReLU());
    out->push_back(tn::Conv1d(tn::Conv1dOptions(inputs, outputs, 1)));
    out->push_back(tn::InstanceNorm1d(outputs));
    inputs = outputs;
  }
  return out;
}

tn::LSTM both_ways(int64_t inputs, int64_t hidden) {
  return tn::LSTM(tn::LSTMOptions(inputs, hidden).batch_first(true).bidirectional(true));
}

/// What an LSTM says at both ends (B, 2, inputs), in one row (B, 4 hidden).
Tensor of_ends(tn::LSTM& lstm, const Tensor& first, const Tensor& last) {
  return std::get<0>(lstm->forward(torch::stack({first, last}, 1))).flatten(1);
}

}  // namespace

SltNetworkImpl::SltNetworkImpl(const Config& config) : root(config.root), future(config.future) {
  const int64_t pose = int64_t{3} * config.joints, code = config.hidden, scene = kPointWidths[2];
  const Config::Baselines& b = config.baselines;
  const int64_t path_ends = int64_t{4} * b.slt_path, pose_ends = int64_t{4} * b.slt_pose;
  past_in = register_module("past_in", tn::Linear(pose, code));
  past_gru = register_module("past_gru", tn::GRU(tn::GRUOptions(code, code).batch_first(true)));
  scene_points = register_module("scene_points", point_layers());
  goal_net = register_module("goal_net", residual_layers(scene + code, b.slt_goal, 3));
  goal_pose_net = register_module("goal_pose_net", residual_layers(scene + code + 3, b.slt_goal, pose));
  path_lstm = register_module("path_lstm", both_ways(3, b.slt_path));
  path_scene = register_module("path_scene", tn::Linear(scene, kSceneCode));
  path_net = register_module("path_net", two_layers(path_ends + kSceneCode + code, path_ends, 3 * future));
  pose_lstm = register_module("pose_lstm", both_ways(pose, b.slt_pose));
  pose_scene = register_module("pose_scene", tn::Linear(scene, kSceneCode));
  pose_path = register_module("pose_path", tn::Linear(3 * future, kPathCode));
  pose_net =
      register_module("pose_net", two_layers(pose_ends + kSceneCode + kPathCode + code, pose_ends, pose * future));
}

SltForecast SltNetworkImpl::forward(const Tensor& past, const Tensor& points) {
  const int64_t frames = past.size(1), joints = past.size(2);
  const Tensor motion = nn::last_state(past_gru, past_in->forward(local_pose(past, root).flatten(2)));
  const Tensor scene = scene_points->forward(points.transpose(1, 2)).amax(2);
  const Tensor last = past.select(1, frames - 1), last_root = last.select(1, root);
  const Tensor codes = torch::cat({scene, motion}, 1);
  SltForecast out;
  out.goal = goal_net->forward(codes);
  const Tensor goal_pose = goal_pose_net->forward(torch::cat({codes, out.goal}, 1));
  const Tensor path =
      path_net->forward(torch::cat({of_ends(path_lstm, last_root, out.goal), path_scene->forward(scene), motion}, 1));
  const Tensor last_pose = (last - last_root.unsqueeze(1)).flatten(1);
  const Tensor poses = pose_net->forward(torch::cat(
      {of_ends(pose_lstm, last_pose, goal_pose), pose_scene->forward(scene), pose_path->forward(path), motion}, 1));
  out.path = path.view({-1, future, 3});
  // The root is where the path has it.
  Tensor others = torch::ones({joints, 1}, past.options());
  others[root] = 0;
  out.goal_pose = goal_pose.view({-1, joints, 3}) * others;
  out.local = poses.view({-1, future, joints, 3}) * others;
  return out;
}

}  // namespace inhabit::forecast
