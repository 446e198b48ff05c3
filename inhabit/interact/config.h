#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/train/rate_schedule.h"

namespace inhabit::interact {

/// Everything that human-chair interaction must know to be built, trained and run; it travels in a model file's
/// metadata. Defaults are the paper's (sec. 4.2-4.4, appendix 2), and the release's where the paper is silent.
struct Config {
  std::string preset = "paper";  ///< what preset() it began as
  double rate = 30;              ///< frames a second
  int joints = 22;               ///< j
  int past_keys = 6;             ///< keys of the time window before the present one
  int future_keys = 6;           ///< and after it
  int key_step = 5;              ///< frames from one key to the next
  int actions = 3;               ///< idle, walk, sit
  int ego_rings = 8;             ///< rings of the ego-centric grid, the empty innermost one counted (the release: 9)
  int ego_layers = 8;            ///< its layers (the release: 9)
  int chair_grid = 8;            ///< voxels along each side of the chair's box
  /// PoseNet is told where head, ankles and free palms of somebody who sits or stands about are a second later
  /// (habits.h). Not in the paper, whose people do nothing then that no contact asks for.
  bool seated_habits = false;

  // PoseNet (Table 5).
  std::vector<int> encoders = {512, 128, 256, 512, 128};  ///< widths for {J, T}, G, E, I, C
  int encoder_layers = 3;                                 ///< of each (the release: 2)
  int experts = 10;                                       ///< of the prediction network
  int hidden = 512;                                       ///< width of the prediction network
  int gating_hidden = 128;                                ///< width of the gating network

  // ControlNet and ContactNet.
  int control_encoder = 128;  ///< width of its two encoders
  int control_hidden = 512;   ///< width of its LSTM
  int control_layers = 2;     ///< layers of its LSTM
  int contact_hidden = 512;   ///< width of the encoder of the chair's grid
  int contact_code = 64;      ///< what it gives
  int contact_z = 6;          ///< numbers of ContactNet's z

  /// How the networks are trained.
  struct Training {
    int pose_steps = 0;              ///< optimiser steps of PoseNet and of each baseline; 0: 150 epochs
    int control_steps = 0;           ///< of ControlNet; 0: 150 epochs
    int contact_steps = 0;           ///< of ContactNet; 0: 150 epochs
    int batch = 32;                  ///< samples of a step; ControlNet's are sequences
    double pose_rate = 1e-4;         ///< peak of PoseNet's and the baselines' learning rate
    double control_rate = 1e-3;      ///< of ControlNet's
    double contact_rate = 1e-3;      ///< of ContactNet's
    double pose_decay = 0.0025;      ///< PoseNet's weight decay (AdamW)
    int rollout_steps = 0;           ///< of PoseNet on its own rollouts, after stage pose; 0: 150 epochs
    int rollout_frames = 8;          ///< that each of them lasts
    double rollout_rate = 1e-4;      ///< learning rate
    double rollout_average = 0.999;  ///< decay of the weights' moving average in it
    double rollout_hand_weight = 1;  ///< of the wrists' numbers in its loss, against 1 of the others
    double warmup = 0;               ///< of the steps, in which the rate rises from 0
    double pose_floor = 0.05;        ///< of the peak, which PoseNet's cosine ends at
    double control_floor = 0.005;    ///< of the peak, which ControlNet's ends at
    double contact_floor = 1;        ///< of the peak, which ContactNet's ends at: its rate stays
    double dropout = 0.3;            ///< PoseNet's and the baselines'
    double sense_noise = 0;          ///< fraction of PoseNet's samples whose occupancies are disturbed (SenseNoise)
    bool mirrored = true;            ///< the data's mirror image is learned from too
    int control_frames = 60;         ///< of a sequence for ControlNet
    double trajectory_weight = 0.1;  ///< lambda 1 (Eq. 2)
    double phase_weight = 0.02;      ///< lambda 2
    double straight_weight = 2;      ///< lambda 3: the hand's path against the straight line
    double first_point_weight = 5;   ///< of the path's first point, which the next straight line starts from
    double sampling_from = 0.2;      ///< fraction of the steps up to which ControlNet always sees the true hand
    double sampling_to = 0.667;      ///< and from which on always its own; in between more and more often (linear)
    double contact_beta = 0.1;       ///< of the KL divergence (Eq. 4)

    /// Of PoseNet's learning rate.
    RateSchedule pose_schedule() const { return {warmup, pose_floor}; }
    /// Of ControlNet's.
    RateSchedule control_schedule() const { return {warmup, control_floor}; }
    /// Of ContactNet's.
    RateSchedule contact_schedule() const { return {warmup, contact_floor}; }
    bool operator==(const Training&) const = default;  ///< compares all settings
  } training;                                          ///< not looked at in use

  /// How motion and contacts are generated.
  struct Inference {
    /// Weight of its correction that PoseNet's goals take while the person stands idle (the release: 0.1; 0.25 and 0.9
    /// below). With more than 0 a goal that has just come into sight is corrected away before anybody sets off for it.
    double goal_idle = 0;
    double goal_walk = 0;       ///< likewise while they walk
    double goal_sit = 0;        ///< likewise while they sit
    double contact_spread = 1;  ///< deviation of ContactNet's z (the release: 2)

    bool operator==(const Inference&) const = default;  ///< compares all settings
  } inference;                                          ///< not looked at in training

  /// What the networks are compared with: NSM is a PoseNet, SAMP has these sizes of its own.
  struct Baselines {
    int samp_z = 64;               ///< numbers of its z
    int samp_hidden = 512;         ///< width of its encoders and of its prediction network
    int samp_code = 64;            ///< what its encoder of the chair's grid gives
    int samp_experts = 12;         ///< of its prediction network
    int samp_gating_hidden = 256;  ///< the second layer of its gating network
    double samp_beta = 0.1;        ///< of the KL divergence

    bool operator==(const Baselines&) const = default;  ///< compares all settings
  } baselines;                                          ///< sizes of SAMP

  int keys() const { return past_keys + 1 + future_keys; }  ///< of the time window (tau)
  int future_points() const { return future_keys + 1; }     ///< present and future keys (tau+)
  /// Numbers of ControlNet's control signal: points of two hands and their phases at the present and future keys.
  int64_t control_size() const { return int64_t{2} * future_points() * 4; }
  int64_t pose_size() const { return int64_t{3} * joints; }  ///< ControlNet's joint positions
  /// Points of the ego-centric grid: rings z = 0, 1, ... of round(2 pi z) points in each layer.
  int64_t ego_points() const;
  /// Numbers of the chair's grid: a position and a value for each voxel.
  int64_t chair_size() const { return int64_t{4} * chair_grid * chair_grid * chair_grid; }
  /// What settings that say how trained networks are used begin with (nn/used_settings.h).
  static std::vector<std::string> used() { return {"inference."}; }

  bool operator==(const Config&) const = default;  ///< compares all settings, the preset's name too
};

/// "paper": the paper's sizes. "compact": one that trains on a CPU. Throws Error for other names.
Config preset(const std::string& name);

/// All settings as a JSON object, nested by group; config_from_json reads it again.
std::string to_json(const Config& config);

/// Fields that `text` leaves out keep their defaults. @param subject named in errors. Unknown keys and impossible
/// values are refused.
Config config_from_json(const std::string& text, const std::string& subject);

/// Sets fields from text, "training.batch=64" each (io/config_fields.h).
void set_fields(Config& config, const std::vector<std::string>& settings);

/// Throws Error(subject, ...) unless sizes are positive, bounded and fit together.
void validate(const Config& config, const std::string& subject);

}  // namespace inhabit::interact
