#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/train/rate_schedule.h"

namespace inhabit::forecast {

/// A run of point-voxel convolutions of equal width.
struct PointVoxelSpec {
  int channels = 0;  ///< features that come out
  int blocks = 0;    ///< convolutions
  int grid = 0;      ///< voxels along each side

  bool operator==(const PointVoxelSpec&) const = default;  ///< compares all sizes
};

/// One level down: optional point-voxel convolutions, then `centres` points by furthest point sampling, each seeing the
/// first `neighbours` points within `radius` metres through a shared MLP.
struct AbstractionSpec {
  std::optional<PointVoxelSpec> convolution;  ///< none: the level begins with the sampling
  int centres = 0;                            ///< points that are left
  double radius = 0;                          ///< metres
  int neighbours = 0;                         ///< points that a centre sees at most
  std::vector<int> mlp;                       ///< widths of the shared MLP's layers

  bool operator==(const AbstractionSpec&) const = default;  ///< compares all sizes
};

/// One level up: features interpolated from the centres and joined to those of the level's points, a shared MLP, then
/// optional point-voxel convolutions.
struct PropagationSpec {
  std::vector<int> mlp;                       ///< widths of the shared MLP's layers
  std::optional<PointVoxelSpec> convolution;  ///< none: the level ends with the MLP

  bool operator==(const PropagationSpec&) const = default;  ///< compares all sizes
};

/// Everything that contact-aware forecasting must know to be built and run; it travels in a model file's metadata.
struct Config {
  std::string preset = "paper";   ///< what preset() it began as
  double rate = 30;               ///< frames a second
  int past = 30;                  ///< P, observed frames
  int future = 60;                ///< T, predicted frames
  int joints = 22;                ///< J
  int root = 0;                   ///< index of the root joint
  std::vector<int> hips;          ///< left and right hip: windows face +Z; empty: world axes, as in the release
  double sigma = 0.2;             ///< metres, width of the contact map (Eq. 2)
  int contact_coefficients = 20;  ///< L, DCT coefficients of a contact sequence
  int root_coefficients = 60;     ///< DCT coefficients of the root path
  int hidden = 128;               ///< width of the recurrent encoders, the root MLP and the contact network's head
  bool decode_from_past = false;  ///< released form: every decoded frame starts from the past-motion code instead of
                                  ///< the cell's own last state
  std::string decoder = "recurrent";  ///< the motion network: "recurrent", the paper's (Eq. 8-9), or "articulated"
  std::vector<AbstractionSpec> abstraction;  ///< levels of the contact network's encoder, finest first
  std::vector<PropagationSpec> propagation;  ///< levels of its decoder, coarsest first, as many

  /// Sizes of the articulated motion network (articulated_network.h).
  struct Articulated {
    int width = 192;                  ///< channels of a token
    int blocks = 6;                   ///< each mixes tokens, then channels
    int stride = 2;                   ///< frames from one token to the next
    int coefficients = 20;            ///< DCT coefficients of what is added to the continued pose
    double root_continuation = 0.5;   ///< seconds in which the root's last velocity dies away
    double pose_continuation = 0.15;  ///< the same of the joints' angular velocities
    double gate = 0.1;                ///< seconds in which the network's own part opens
    int hypotheses = 0;               ///< K, ways to go on (hypotheses.h); 0: the one forecast alone

    bool operator==(const Articulated&) const = default;  ///< compares all sizes
  } articulated;                                          ///< where `decoder` says so

  /// How the networks are used, and trained: what may be changed without new weights.
  struct Inference {
    double contact_threshold = 0.32;  ///< contact value above which a joint touches
    int points = 5000;                ///< N, scene points sampled
    double radius = 2.5;              ///< metres around the root at the last observed frame

    bool operator==(const Inference&) const = default;  ///< compares all settings
  } inference;                                          ///< in files beside the sizes, without a group of their own

  /// How the networks are trained. Defaults are the paper's (4.2).
  struct Training {
    int contact_steps = 0;         ///< optimiser steps of stage contact; 0: 50 epochs
    int motion_steps = 0;          ///< of stages motion, no_contact and the baselines; 0: 50 epochs
    int adapt_steps = 0;           ///< of stage adapt; 0: 10 epochs
    int hypotheses_steps = 6000;   ///< of stage hypotheses; 0: 50 epochs
    int contact_batch = 4;         ///< windows of a step of stage contact
    int motion_batch = 32;         ///< of the other stages
    double contact_rate = 5e-4;    ///< peak of the learning rate of stage contact
    double motion_rate = 1e-3;     ///< of the other stages
    int stride = 5;                ///< frames from one window to the next
    double root_weight = 1.0;      ///< lambda 1 (Eq. 13)
    double pose_weight = 1.0;      ///< lambda 2
    double contact_weight = 0.1;   ///< lambda 3
    double velocity_weight = 1.0;  ///< of the articulated network's velocity loss
    double recorded = 0;           ///< fraction of windows of recordings in a batch; 0: as many as the data hold
    bool mirror = false;   ///< motion networks see every other window in a mirror (the standard joints facing +Z alone)
    double stature = 0;    ///< motion networks see people and rooms up to this fraction larger or smaller
    double time_warp = 0;  ///< w: networks of motion see recordings 1 / (1 + w) to 1 + w times as fast
    RateSchedule schedule;  ///< of the learning rates
    double dropout = 0;     ///< in the blocks of the articulated network and of its hypotheses

    bool operator==(const Training&) const = default;  ///< compares all settings
  } training;                                          ///< not looked at in use

  /// Sizes of what the networks are compared with, by default their authors'.
  struct Baselines {
    int ltd_hidden = 256;     ///< LTD's width
    int ltd_blocks = 12;      ///< its residual blocks
    int hisrep_query = 10;    ///< HisRep: frames that are compared with earlier ones
    int hisrep_future = 10;   ///< frames predicted at a time
    int hisrep_hidden = 256;  ///< width
    int hisrep_blocks = 12;   ///< residual blocks
    int dmgnn_width = 32;     ///< DMGNN: width of its first layers; of the last eight times that
    int slt_goal = 512;       ///< SLT*: width of the networks of the goal and of the pose there
    int slt_path = 64;        ///< of the path's LSTM, each way
    int slt_pose = 256;       ///< of the poses' LSTM, each way

    bool operator==(const Baselines&) const = default;  ///< compares all sizes
  } baselines;                                          ///< not looked at in use

  /// P + T, of a window.
  int frames() const { return past + future; }
  /// What settings that say how trained networks are used begin with (nn/used_settings.h).
  static std::vector<std::string> used() { return {"points=", "radius=", "contact_threshold="}; }

  bool operator==(const Config&) const = default;  ///< compares all settings, the preset's name too
};

/// "paper": the paper's sizes. "compact": one that trains in under two hours on two CPU cores.
/// Throws Error for other names.
Config preset(const std::string& name);

/// All settings as a JSON object, nested by group; config_from_json reads it again.
std::string to_json(const Config& config);

/// @param subject named in errors (the file it came from). Unknown keys and impossible values are refused.
Config config_from_json(const std::string& text, const std::string& subject);

/// The config that the metadata of a file with released weights describes: sizes P, T, J, L, ... and the block lists.
Config released_config(const std::map<std::string, std::string>& metadata, const std::string& subject);

/// Sets fields from text, "training.motion_batch=64" each (io/config_fields.h).
void set_fields(Config& config, const std::vector<std::string>& settings);

/// Throws Error(subject, ...) unless sizes are positive and bounded and the block lists fit together.
void validate(const Config& config, const std::string& subject);

}  // namespace inhabit::forecast
