#pragma once
#include <torch/torch.h>

#include "inhabit/forecast/config.h"

namespace inhabit::forecast {

/// What SLT* says of the future, one part from each of its networks.
struct SltForecast {
  torch::Tensor goal;       ///< (B, 3) metres, the root in the last frame
  torch::Tensor goal_pose;  ///< (B, J, 3) joints relative to the root, in the last frame
  torch::Tensor path;       ///< (B, T, 3) metres, the root
  torch::Tensor local;      ///< (B, T, J, 3) joints relative to the root

  /// (B, T, J, 3) metres.
  torch::Tensor joints() const { return local + path.unsqueeze(2); }
};

/// SLT* (Wang et al. 2021, "Synthesizing Long-Term 3D Human Motion and Interaction in 3D Scenes", as the contact-aware
/// paper's appendix A.2.1 makes a forecast of it): where the person will be in the end, in which pose, by which path,
/// and the poses on it, from the observed motion and the scene's points. Each network takes what those before it
/// predict; all see one code of the points (PointNet) and one of the observed motion.
struct SltNetworkImpl : torch::nn::Module {
  /// J, P, T, `hidden` and baselines.slt_* of the configuration.
  explicit SltNetworkImpl(const Config& config);

  /// @param past (B, P, J, 3) world joints, origin at the root of the last observed frame. @param points (B, N, 3) of
  /// the scene, same origin.
  SltForecast forward(const torch::Tensor& past, const torch::Tensor& points);

  int root;                               ///< index of the root joint
  int64_t future;                         ///< T frames
  torch::nn::Linear past_in{nullptr};     ///< a pose, 3 J numbers, to hidden
  torch::nn::GRU past_gru{nullptr};       ///< over the past; its last state is the code of the motion
  torch::nn::Sequential scene_points;     ///< a point to 256 features, the largest of which are the scene's code
  torch::nn::Sequential goal_net;         ///< codes to the root in the last frame
  torch::nn::Sequential goal_pose_net;    ///< codes and the goal to the pose there
  torch::nn::LSTM path_lstm{nullptr};     ///< over the two ends of the path, both ways
  torch::nn::Linear path_scene{nullptr};  ///< the scene's code to 32 numbers
  torch::nn::Sequential path_net;         ///< what the LSTM says and the codes to T places of the root
  torch::nn::LSTM pose_lstm{nullptr};     ///< over the poses at the two ends, both ways
  torch::nn::Linear pose_scene{nullptr};  ///< the scene's code to 32 numbers
  torch::nn::Linear pose_path{nullptr};   ///< the path to 64 numbers
  torch::nn::Sequential pose_net;         ///< what the LSTM says, the codes and the path to T poses
};
TORCH_MODULE(SltNetwork);

}  // namespace inhabit::forecast
