#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "inhabit/train/rate_schedule.h"

namespace inhabit::inbetween {

/// Numbers a frame that in-betweening works on: [0, 3) root translation, [3, 9) root orientation 6D, [9, 135) 21 body
/// rotations 6D, [135, 201) 22 joint positions.
inline constexpr int64_t kFeatureCount = 201;
/// Mask channels of a model that takes partial key poses: root translation, root orientation, body rotations, 22
/// joints.
inline constexpr int64_t kMaskChannels = 25;
/// Body-shape features: five distances between joints, two thicknesses.
inline constexpr int64_t kShapeFeatures = 7;
/// Channels that the offsets of a key frame's anchors become.
inline constexpr int64_t kLocalChannels = 32;

/// Transformer over the occupancy seen from above: patches of `patch` x `patch` columns.
struct SceneEncoderSpec {
  int patch = 12;       ///< columns of 0.1 m along a side of a patch; divides `side`
  int width = 1024;     ///< numbers of a token
  int depth = 6;        ///< transformer layers
  int heads = 16;       ///< attention heads of a layer
  int head_width = 64;  ///< numbers of a query, key or value of one head
  int mlp = 2048;       ///< hidden numbers of a layer's two-layer perceptron
  int side = 48;        ///< cells of 0.1 m along x and along z that are seen; a multiple of 4

  int64_t height() const { return side / 2; }                ///< cells upwards
  bool operator==(const SceneEncoderSpec&) const = default;  ///< compares all sizes
};

/// Everything that scene-aware in-betweening must know to be built, trained and run; it travels in a model file's
/// metadata. Defaults are the paper's (Table 5).
struct Config {
  std::string preset = "paper";              ///< what preset() it began as; "released": read from released weights
  double rate = 30;                          ///< frames a second
  int frames = 121;                          ///< N, frames of a clip
  int padded = 128;                          ///< frames that the U-Net sees, zeros behind the clip
  int width = 256;                           ///< of the embedding, and of the U-Net where the multiplier is 1
  std::vector<int> multipliers{2, 2, 2, 2};  ///< one level of the U-Net each, the next with half the frames
  SceneEncoderSpec scene_encoder;            ///< sizes of what sees the occupancy; not used without global_scene
  int anchors = 64;                          ///< points on the body's surface with an offset to the scene
  int diffusion_steps = 1000;                ///< T
  int t_star = 0;  ///< T*: keys inside the clip are imputed at steps t >= T* (0: at every one; noise-aware: 20)
  bool global_scene = true;   ///< the occupancy is seen (Table 1)
  bool local_scene = true;    ///< the offsets at key frames are seen (Table 1)
  bool body_shape = true;     ///< the body-shape features are seen (Table 8)
  bool keys_seen = true;      ///< false: trained without keys; sampling puts them into what is predicted (MDM)
  bool partial_keys = false;  ///< keys may constrain parts of a pose: kMaskChannels channels of mask instead of one

  /// The denoiser also sees the interpolated baseline of the keys and predicts the difference from it, so that a short
  /// training need not learn to interpolate first. (Not in the paper.)
  bool from_interpolation = false;
  /// The interpolated baseline goes around obstacles between the keys (obstacle_detours.h), also where scene_dropout or
  /// guidance hide the scene from the network. (Not in the paper.)
  bool around_obstacles = false;

  /// The denoiser works on residual motion (residual.h) and sees the scene at every frame (scene_probe.h), in place of
  /// features in the canonical frame, occupancy and offsets. (Not in the paper.)
  bool residual = false;

  /// Residual motion is told along the detours of its baseline (detour_legs.h). Models of before do not.
  bool along_detours = false;

  /// How the denoiser is trained.
  struct Training {
    int steps = 20000;            ///< updates of the weights, in stage "denoiser"
    int batch = 32;               ///< the paper's: 256
    double learning_rate = 4e-4;  ///< the paper's 1e-4 goes with batches of 256 and many more steps
    double weight_decay = 1e-2;   ///< AdamW's, in all stages
    double average = 0.9995;   ///< decay of the weights' moving average; the paper's 0.9999 averages over as many steps
                               ///< as a short run has in all
    int stride = 30;           ///< frames from one window to the next
    bool bfloat16 = false;     ///< the network's products are made in bfloat16 (nn/bfloat16.h)
    double joints_weight = 2;  ///< lambda of Eq. 2
    double velocity_weight = 10;  ///< lambda of Eq. 3
    double feet_weight = 0;       ///< of the motion of feet that stand still in truth (not in the paper)
    double rest_rotation = 0;     ///< degrees that joints' rest frames are rotated by (not in the paper)
    double scene_dropout = 0.1;   ///< probability of a sample without the global scene, for guidance
    // Of residual motion alone:
    double recorded = 0.6;          ///< fraction of a batch that is recorded motion, where there is some
    double time_warp = 0;           ///< w: recorded motion goes 1 / (1 + w) to 1 + w times as fast
    double blocked = 0.4;           ///< fraction of windows whose baseline goes through obstacles, where it can be had
    double way_around = 0.5;        ///< fraction of windows whose baseline goes around obstacles
    double walked = 0;              ///< fraction of these detours that are those which were walked; the others are A*'s
    double sliding_weight = 0;      ///< of feet that go while they are low (residual_losses.h), in stage "deployed"
    double swinging_weight = 0;     ///< of feet that go faster than the truth's ever do (the same), in stage "deployed"
    double noisy = 0;               ///< fraction of windows with noisy keys; 0: the model takes none
    double penetration_weight = 1;  ///< of body points inside obstacles
    double clearance_weight = 0;    ///< of roots nearer to obstacles than the true one, in stage "deployed"
    double noisiest = 0.2;  ///< fraction of windows at one of the noisiest tenth of the steps, in stage "denoiser":
                            ///< where motion that keys leave open is decided
    double far_keys = 0.5;  ///< fraction of windows whose keys are 30 to 120 frames apart, beside those of `blocked`
    int deployed_steps = 8000;             ///< of stage "deployed", half as many windows in each, sampled twice
    double deployed_learning_rate = 1e-4;  ///< peak of the learning rate in stage "deployed"
    int path_steps = 8000;                 ///< of stage "path"
    int path_batch = 48;                   ///< floors of a step of it
    double path_learning_rate = 1e-3;      ///< its peak
    int contact_steps = 2000;              ///< of stage "contacts", half as many windows in each
    double contact_learning_rate = 1e-3;   ///< its peak
    RateSchedule schedule;                 ///< of the learning rates

    bool operator==(const Training&) const = default;  ///< compares all settings
  } training;                                          ///< how the denoiser is trained

  /// How motion is sampled where Options say nothing else.
  struct Inference {
    double guidance = 2.5;    ///< w
    int steps = 2;            ///< evaluations of the denoiser: those that stage "deployed" trains
    bool noisy_keys = false;  ///< whole keys are noisy where nobody says how much (Options::noise)

    bool operator==(const Inference&) const = default;  ///< compares all settings
  } inference;                                          ///< how motion is sampled

  /// Whether the level of noise on the keys can be told (Options::noise).
  bool takes_noise() const { return residual && training.noisy > 0; }
  /// M, channels of the key mask.
  int64_t mask_channels() const { return partial_keys ? kMaskChannels : 1; }
  /// What settings that say how trained networks are used begin with (nn/used_settings.h).
  static std::vector<std::string> used() { return {"inference.", "t_star="}; }

  bool operator==(const Config&) const = default;  ///< compares all settings, the preset's name too
};

/// "compact": residual motion, small enough to be trained and used on a CPU. "paper": the paper's. "features": the
/// paper's features at the compact sizes, from the interpolated baseline; with t_star it is what inbetween-noisy is.
/// Throws Error for other names.
Config preset(const std::string& name);

/// All settings as a JSON object, nested by group; config_from_json reads it again.
std::string to_json(const Config& config);

/// Fields that `text` leaves out keep their defaults. @param subject named in errors. Unknown keys and impossible
/// values are refused.
Config config_from_json(const std::string& text, const std::string& subject);

/// The config that the metadata of a file with released weights describes: latent_dim, dim_mults, vit, frames, ...
Config released_config(const std::map<std::string, std::string>& metadata, const std::string& subject);

/// Sets fields from text, "training.batch=64" each (io/config_fields.h).
void set_fields(Config& config, const std::vector<std::string>& settings);

/// Throws Error(subject, ...) unless sizes are positive, bounded and fit together.
void validate(const Config& config, const std::string& subject);

/// Throws Error(file, ...) unless the model cleans noisy keys by itself (t_star of models of features,
/// inference.noisy_keys of residual motion).
void require_noise_aware(const Config& config, const std::string& file);

}  // namespace inhabit::inbetween
