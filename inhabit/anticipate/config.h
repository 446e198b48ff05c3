#pragma once
#include <string>
#include <vector>

#include "inhabit/train/rate_schedule.h"

namespace inhabit::anticipate {

/// Everything that intention-driven anticipation must know to be built, trained and run; it travels in a model file's
/// metadata. Defaults are the paper's where it names a value.
struct Config {
  std::string preset = "compact";  ///< what preset() it began as
  double rate = 25;                ///< frames a second
  int observed = 50;               ///< t, frames; a shorter observation is left-padded with its first frame
  int future = 50;                 ///< T - t in training; any horizon can be asked for
  int gamma = 10;                  ///< frames that the intention is read ahead, the current one among them (Eq. 6)
  int kappa = 8;                   ///< frames of a motion word (Eq. 9)
  int labels = 8;                  ///< |C|, intention labels
  int clusters = 24;               ///< pose clusters that cycles are found among
  bool naive_clusters = false;     ///< the labels are pose clusters themselves
  bool released = false;           ///< networks, labels and losses of the authors' training code (released_networks.h)
  bool intention = true;           ///< the pose decoder sees the intention
  bool memory = true;              ///< futures go on from recorded motion (motion_memory.h)
  int intention_hidden = 96;       ///< width of the intention encoder and decoder
  int hidden = 160;                ///< width of the pose decoder's three layers
  int noise = 24;                  ///< length of z; h_p fills the rest of `hidden`
  int intention_features = 16;     ///< channels of the temporal convolution f

  /// How the networks are trained.
  struct Training {
    int folds = 0;    ///< over 0: recordings are left out by turns, one fold in each training (data/motion_set.h), and
    int fold = 0;     ///< this one in this; the test split is not opened (`eval anticipate --split left-out`)
    int steps = 400;  ///< updates of the weights
    int batch = 32;   ///< windows of a step
    double learning_rate = 3e-4;  ///< its peak
    double average = 0.995;       ///< decay of the weights' moving average: discriminators make weights sway
    int label_frames = 600;       ///< future labels that the intention decoder sees, where a recording has so many
    int rec_frames = 15;  ///< tau_rec: the reconstruction loss fades to zero over so many frames; 0: it never fades
    bool label_discriminator = true;          ///< Eq. 5
    bool pose_discriminator = true;           ///< Eq. 7
    int discriminator_hidden = 256;           ///< width of both discriminators' layers
    int discriminator_frames = 10;            ///< frames that the pose discriminator sees at once
    double pose_discriminator_weight = 0.01;  ///< of its part of the generator loss
    double label_discriminator_weight = 0.1;  ///< likewise
    double diversity_weight = 0.05;           ///< of the loss on futures of one observation that are alike
    double plausibility_weight = 3;           ///< of 1 - NDMS beside other recordings (plausibility_loss.h)
    RateSchedule schedule;                    ///< of the learning rates

    bool operator==(const Training&) const = default;  ///< compares all settings
  } training;                                          ///< not looked at in use

  /// How futures are drawn.
  struct Inference {
    double label_temperature = 1;    ///< without memory: under 1 likely labels are drawn more often than they are
    double memory_distance = 0.003;  ///< metres, MotionMemory::Choice; in training as well
    double memory_typical = 80;      ///< likewise
    double memory_within = 0.02;     ///< metres, likewise
    double memory_stay = 100;        ///< frames, likewise
    double memory_warp = 0.05;       ///< likewise
    double memory_label = 1;         ///< weight of the labels' log-probabilities in the choice

    bool operator==(const Inference&) const = default;  ///< compares all settings
  } inference;                                          ///< the memory's are looked at in training as well

  /// Sizes, their authors' by default, and training of what the networks are compared with.
  struct Baselines {
    int steps = 2000;             ///< updates of each network's weights
    double learning_rate = 1e-3;  ///< its peak
    int seq2seq_hidden = 1024;    ///< residual sequence-to-sequence GRU
    int ltd_past = 25;            ///< LTD: frames seen
    int ltd_future = 25;          ///< frames predicted at a time
    int ltd_hidden = 256;         ///< width
    int ltd_blocks = 12;          ///< residual blocks
    int hisrep_query = 10;        ///< HisRep: frames that are compared with earlier ones
    int hisrep_future = 10;       ///< frames predicted at a time
    int hisrep_hidden = 256;      ///< width
    int hisrep_blocks = 12;       ///< residual blocks
    int vae_hidden = 128;         ///< VAE and DLow: width of their GRUs
    int vae_latent = 128;         ///< length of z
    int dlow_samples = 50;        ///< DLow: futures of one draw
    int dlow_batch = 8;           ///< windows of a step, with so many futures each
    int mix_hidden = 1024;        ///< Mix-and-Match: width, of which half is the future's
    int mix_latent = 64;          ///< length of its z
    int grammar_hidden = 256;     ///< Grammar: width, of its non-terminals too
    int grammar_rules = 256;      ///< production rules
    int grammar_rollouts = 4;     ///< futures of each observation in training

    bool operator==(const Baselines&) const = default;  ///< compares all settings
  } baselines;                                          ///< not looked at in use

  /// What settings that say how trained networks are used begin with (nn/used_settings.h).
  static std::vector<std::string> used() { return {"inference."}; }

  bool operator==(const Config&) const = default;  ///< compares all settings, the preset's name too
};

/// "compact": one that trains in half an hour on two CPU cores. "paper": the networks, labels and losses of the
/// authors' training code at their sizes. Throws Error for other names.
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

}  // namespace inhabit::anticipate
