#pragma once
#include <torch/torch.h>

#include <string>
#include <vector>

#include "inhabit/forecast/network.h"

namespace inhabit::forecast {

/// Angular velocities (B, A, 3), radians a frame, in the window's axes, of the joints that have children, as they
/// rotate the bones to these from where they were a frame earlier: least squares over a joint's bones, the least
/// rotation where there is but one. @param before, now (B, J, 3) joints.
torch::Tensor angular_velocities(const torch::Tensor& before, const torch::Tensor& now);

/// Joints (B, T, 22, 3) of forward kinematics on the bones of `last` (B, 22, 3), as it stands: the root goes along
/// `path` (B, T, 3), and each of the 17 joints that have children rotates the bones to them by `rotations` (B, T, 17,
/// 3, 3), rotations in the window's axes since `last`. The lengths of bones, and the angles between those of one joint,
/// are those of `last`, whosever body that is.
torch::Tensor posed_from(const torch::Tensor& last, const torch::Tensor& path, const torch::Tensor& rotations);

/// On what contact points a forecast is conditioned, as the network sees it: (B, 2), whether there are any, and whether
/// they are predicted.
torch::Tensor contact_conditioning(int64_t batch, bool any, bool predicted);

/// Predicts how the person goes on from the last observed pose: displacements of the root and rotations of the joints
/// that forward kinematics poses on the person's own bones (posed_from). Not in the paper. Root velocity and angular
/// velocities of the last frame go on and die away; the network adds DCT coefficients over the future, through a gate
/// that is 0, and has slope 0, at the last observed frame. Its tokens are frames of past and future: what was observed,
/// then the continuation with the contact points; blocks mix tokens, then channels (MLP-Mixer; Tolstikhin et al. 2021).
struct ArticulatedNetworkImpl : torch::nn::Module {
  /// Sizes P, T and those of config.articulated.
  explicit ArticulatedNetworkImpl(const Config& config);

  /// @param past (B, P, 22, 3) joints, origin at the root of the last observed frame, who faces +Z in it.
  /// @param contact_points (B, T, 22, 4) position and 0/1; zeros where there are none.
  /// @param conditioning (B, 2) of contact_conditioning.
  MotionForecast forward(const torch::Tensor& past, const torch::Tensor& contact_points,
                         const torch::Tensor& conditioning);

  /// What the network has made of a past: how it goes on by itself, and the tokens behind the last block.
  struct Seen {
    torch::Tensor past;       ///< (B, P, 22, 3), the argument
    torch::Tensor path;       ///< (B, T, 3) of the continuation
    torch::Tensor rotations;  ///< (B, T, 17, 6) of the continuation
    torch::Tensor tokens;     ///< (B, S, width)
  };
  /// The first part of forward(), with the same arguments.
  Seen see(const torch::Tensor& past, const torch::Tensor& contact_points, const torch::Tensor& conditioning);
  /// The motion, where these DCT coefficients (B, coefficients, 3 + 6 * 17) are added to the continuation.
  MotionForecast go_on(const Seen& seen, const torch::Tensor& coefficients) const;
  /// The coefficients that forward() adds.
  torch::Tensor mean_coefficients(const torch::Tensor& tokens);

  /// Mixes tokens, then the channels of each, both added to what comes in. S tokens.
  struct Block {
    torch::nn::LayerNorm token_norm{nullptr};    ///< before the tokens are mixed
    torch::nn::LayerNorm channel_norm{nullptr};  ///< before the channels are
    torch::nn::Linear tokens{nullptr};           ///< S to S, of each channel
    torch::nn::Linear widen{nullptr};            ///< width to width
    torch::nn::Linear narrow{nullptr};           ///< width to width, after the nonlinearity

    /// Of S tokens, registered in `owner` by names that begin with `name`.
    Block(torch::nn::Module& owner, const std::string& name, int64_t count, int64_t width);
    /// @param x (B, S, width) @param dropout of what is added, where `training`
    torch::Tensor forward(const torch::Tensor& x, double dropout, bool training);
  };
  /// S, of past and future.
  static int64_t token_count(const Config& config);
  /// Numbers that are added in each frame: the root's 3 and 6 of each joint that rotates.
  static int64_t added_count();

  Config config;                            ///< what it was made with
  torch::nn::Linear motion_in{nullptr};     ///< poses and velocities of a token's frame to width
  torch::nn::Linear person_in{nullptr};     ///< the last observed pose and contact_conditioning to width
  torch::nn::Linear contact_in{nullptr};    ///< a frame's contact points to width
  torch::nn::Linear coefficients{nullptr};  ///< S tokens to DCT coefficients over the future
  torch::nn::Linear out{nullptr};           ///< width to the root's 3 and 6 numbers of each joint that rotates
  torch::nn::LayerNorm out_norm{nullptr};   ///< behind the last block
  std::vector<Block> blocks;                ///< one after the other
  torch::Tensor place;                      ///< (S, width) added to each token

 private:
  Seen continued(const torch::Tensor& past) const;
  torch::Tensor tokens(const torch::Tensor& past, const torch::Tensor& continued, const torch::Tensor& contact_points,
                       const torch::Tensor& conditioning);
  int64_t past_tokens_, future_tokens_;
  torch::Tensor gate_, from_dct_;  ///< (T, 1), (T, coefficients)
};
TORCH_MODULE(ArticulatedNetwork);

}  // namespace inhabit::forecast
