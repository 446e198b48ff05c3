#pragma once
#include <torch/torch.h>

#include <string>
#include <vector>

#include "inhabit/forecast/config.h"
#include "inhabit/nn/layers.h"

namespace inhabit::forecast {

/// Joints in the form the networks see: positions relative to the root, the root's own row holding its path.
/// (..., J, 3) world metres -> (..., J, 3).
torch::Tensor local_pose(const torch::Tensor& joints, int root);

/// Encoder half of the point-voxel network: levels of convolutions and set abstraction.
struct PointEncoderImpl : torch::nn::Module {
  explicit PointEncoderImpl(const Config& config);
  /// @return the input of every level, finest first, then the output of the last.
  std::vector<nn::PointFeatures> forward(const nn::PointFeatures& input);

  struct Level {
    std::vector<nn::PointVoxelConv> convolutions;
    nn::SetAbstraction abstraction{nullptr};
  };
  std::vector<Level> levels;
  std::vector<int64_t> level_channels;  ///< features entering each level, then those leaving the last
};
TORCH_MODULE(PointEncoder);

/// Decoder half: levels of feature propagation and convolutions, back to the scene points.
struct PointDecoderImpl : torch::nn::Module {
  /// @param level_channels of the encoder, that of the finest level replaced by what is to be joined there.
  PointDecoderImpl(const Config& config, const std::vector<int64_t>& level_channels);
  /// @param levels as the encoder returned them, with what is to be used at either end put in.
  torch::Tensor forward(const std::vector<nn::PointFeatures>& levels);

  struct Level {
    nn::FeaturePropagation propagation{nullptr};
    std::vector<nn::PointVoxelConv> convolutions;
  };
  std::vector<Level> levels;
  int64_t channels = 0;  ///< features per scene point in the end
};
TORCH_MODULE(PointDecoder);

/// Predicts DCT coefficients of contact maps over past and future from those of the padded past (Eq. 6). Parameters
/// carry the released names.
struct ContactNetworkImpl : torch::nn::Module {
  explicit ContactNetworkImpl(const Config& config);

  /// @param scene (B, N, 3) metres, origin at the root of the last observed frame.
  /// @param contact_dct (B, L*J, N), coefficient l of joint j in row l*J + j (see contact_features()).
  /// @param past (B, P, J, 3) world joints, same origin.
  /// @return (B, L*J, N) in the same layout.
  torch::Tensor forward(const torch::Tensor& scene, const torch::Tensor& contact_dct, const torch::Tensor& past);

  Config config;
  torch::nn::Linear x_enc{nullptr};
  torch::nn::GRU x_gru{nullptr};
  PointEncoder pointnet_sa{nullptr};
  PointDecoder pointnet_fp{nullptr};
  torch::nn::Sequential out_mlp;
};
TORCH_MODULE(ContactNetwork);

/// What the motion network predicts.
struct MotionForecast {
  torch::Tensor root_path;  ///< (B, P+T, 3) metres; the first P frames are the network's reconstruction of the past
  torch::Tensor local;      ///< (B, T, J, 3) relative to the root, as decoded; the root's own row means nothing
};

/// Predicts the root path (Eq. 8), then local poses frame by frame (Eq. 9), given past motion and contact points.
struct MotionNetworkImpl : torch::nn::Module {
  /// @param with_contact false builds the no-contact variant, which has no contact encoder.
  explicit MotionNetworkImpl(const Config& config, bool with_contact = true);

  /// @param past (B, P, J, 3) world joints, origin at the root of the last observed frame.
  /// @param contact_points (B, T, J, 4) position and 0/1; ignored (may be undefined) by the no-contact variant.
  MotionForecast forward(const torch::Tensor& past, const torch::Tensor& contact_points);

  Config config;
  bool with_contact;
  torch::nn::Linear x_enc{nullptr}, cont_enc{nullptr}, g_w4{nullptr}, out_enc{nullptr}, out_mlp{nullptr};
  torch::nn::GRU x_gru{nullptr}, cont_gru{nullptr};
  torch::nn::Sequential g_w1, g_w2, g_w3;
  torch::nn::GRUCell out_gru{nullptr};

 private:
  struct Codes {
    torch::Tensor local, past, root_path;  ///< (B, P, J*3), (B, hidden), (B, P+T, 3)
  };
  Codes encode(const torch::Tensor& past, const torch::Tensor& contact_points);
};
TORCH_MODULE(MotionNetwork);

/// World joints (B, T, J, 3) of a forecast: local poses moved along the future part of the root path.
torch::Tensor forecast_joints(const MotionForecast& forecast, int root);

}  // namespace inhabit::forecast
