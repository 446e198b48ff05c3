#pragma once
#include <string>

namespace inhabit::anticipate {

/// Everything that intention-driven anticipation must know to be built, trained and run; it travels in a model file's
/// metadata. Defaults are the paper's where it names a value.
struct Config {
  double rate = 25;        ///< frames a second
  int observed = 50;       ///< t, frames; a shorter observation is led in by its first frame
  int future = 50;         ///< T - t in training; any horizon can be asked for
  int label_frames = 250;  ///< future labels that the intention decoder is trained on, where a recording has so many
  int gamma = 10;          ///< frames that the intention is read ahead, the current one among them (Eq. 6)
  int rec_frames = 15;     ///< tau_rec: the reconstruction loss fades to zero over so many frames; 0: it never fades
  int kappa = 8;           ///< frames of a motion word (Eq. 9)
  int labels = 8;          ///< |C|, intention labels
  int clusters = 24;       ///< pose clusters that cycles are found among
  bool naive_clusters = false;  ///< the labels are pose clusters themselves
  bool intention = true;        ///< the pose decoder sees the intention
  bool label_adversary = true;  ///< Eq. 5
  bool pose_adversary = true;   ///< Eq. 7
  int intention_hidden = 96;    ///< width of the intention encoder and decoder
  int hidden = 160;             ///< width of the pose decoder's three layers
  int noise = 24;               ///< length of z; h_p fills the rest of `hidden`
  int intention_features = 16;  ///< channels of the temporal convolution f
  int adversary_hidden = 256;
  int adversary_frames = 10;       ///< frames that the pose adversary sees at once
  double label_temperature = 1;    ///< of the draw of labels; under 1 likely ones are drawn more often than they are
  double adversary_weight = 0.03;  ///< of the pose adversary in the generator's loss
  double label_adversary_weight = 0.1;  ///< of the label adversary
  double diversity_weight = 0.05;       ///< of the pull between futures of one observation
  int seq2seq_hidden = 256;             ///< residual sequence-to-sequence GRU (the original: 1024)
  int ltd_past = 25;                    ///< trajectory dependencies: frames seen
  int ltd_future = 25;                  ///< frames predicted at a time
  int ltd_hidden = 128;                 ///< (the original: 256)
  int ltd_blocks = 6;                   ///< residual blocks (the original: 12)

  bool operator==(const Config&) const = default;
};

std::string to_json(const Config& config);

/// Fields that `text` leaves out keep their defaults. @param subject named in errors. Unknown keys and impossible
/// values are refused.
Config config_from_json(const std::string& text, const std::string& subject);

/// Sets one field from text, "gamma=5". Throws Error naming the setting for unknown keys and values of another type;
/// whether they fit together is for validate() to say when all are set.
void set_field(Config& config, const std::string& setting);

/// Throws Error(subject, ...) unless sizes are positive, bounded and fit together.
void validate(const Config& config, const std::string& subject);

}  // namespace inhabit::anticipate
