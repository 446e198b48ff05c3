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
  /// @param config its `abstraction` alone, and J and L
  explicit PointEncoderImpl(const Config& config);
  /// @return the input of every level, finest first, then the output of the last.
  std::vector<nn::PointFeatures> forward(const nn::PointFeatures& input);

  /// One level, from finer points to coarser ones.
  struct Level {
    std::vector<nn::PointVoxelConv> convolutions;  ///< on the finer points; may be none
    nn::SetAbstraction abstraction{nullptr};       ///< to the coarser ones
  };
  std::vector<Level> levels;            ///< finest first
  std::vector<int64_t> level_channels;  ///< features entering each level, then those leaving the last
};
TORCH_MODULE(PointEncoder);

/// Decoder half: levels of feature propagation and convolutions, back to the scene points.
struct PointDecoderImpl : torch::nn::Module {
  /// @param level_channels of the encoder, that of the finest level replaced by what is to be joined there.
  PointDecoderImpl(const Config& config, const std::vector<int64_t>& level_channels);
  /// @param levels as the encoder returned them, with what is to be used at either end put in.
  torch::Tensor forward(const std::vector<nn::PointFeatures>& levels);

  /// One level, from coarser points to finer ones.
  struct Level {
    nn::FeaturePropagation propagation{nullptr};   ///< to the finer points
    std::vector<nn::PointVoxelConv> convolutions;  ///< on these; may be none
  };
  std::vector<Level> levels;  ///< coarsest first
  int64_t channels = 0;       ///< features per scene point in the end
};
TORCH_MODULE(PointDecoder);

/// Predicts DCT coefficients of contact maps over past and future from those of the padded past (Eq. 6). Parameters
/// carry the released names.
struct ContactNetworkImpl : torch::nn::Module {
  /// Sizes J, L, hidden and the levels of the configuration.
  explicit ContactNetworkImpl(const Config& config);

  /// @param scene (B, N, 3) metres, origin at the root of the last observed frame.
  /// @param contact_dct (B, L*J, N), coefficient l of joint j in row l*J + j (see contact_features()).
  /// @param past (B, P, J, 3) world joints, same origin.
  /// @return (B, L*J, N) in the same layout.
  torch::Tensor forward(const torch::Tensor& scene, const torch::Tensor& contact_dct, const torch::Tensor& past);

  Config config;                      ///< what it was made with
  torch::nn::Linear x_enc{nullptr};   ///< a pose, 3 J numbers, to hidden
  torch::nn::GRU x_gru{nullptr};      ///< over the past; its last state is the code of the motion
  PointEncoder pointnet_sa{nullptr};  ///< scene points with the past's coefficients, down
  PointDecoder pointnet_fp{nullptr};  ///< up again, with the code of the motion
  torch::nn::Sequential out_mlp;      ///< a point's features to hidden, to L J coefficients
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

  Config config;                        ///< what it was made with
  bool with_contact;                    ///< sees contact points
  torch::nn::Linear x_enc{nullptr};     ///< a pose, 3 J numbers, to hidden
  torch::nn::Linear cont_enc{nullptr};  ///< a frame's contact points, 4 J numbers, to hidden
  torch::nn::Linear g_w4{nullptr};      ///< hidden to the DCT coefficients of the root path (Eq. 8)
  torch::nn::Linear out_enc{nullptr};   ///< a pose, the root's place and the frame's contact points to hidden (Eq. 9)
  torch::nn::Linear out_mlp{nullptr};   ///< hidden to the next pose
  torch::nn::GRU x_gru{nullptr};        ///< over the past
  torch::nn::GRU cont_gru{nullptr};     ///< over the contact points of the future
  torch::nn::Sequential g_w1;           ///< first layer of the root path's MLP
  torch::nn::Sequential g_w2;           ///< second
  torch::nn::Sequential g_w3;           ///< third
  torch::nn::GRUCell out_gru{nullptr};  ///< from one predicted pose to the next

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
