#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/data/native.h"
#include "inhabit/synth/chair_life.h"
#include "inhabit/synth/generate.h"

namespace inhabit {

/// How much is made, and of whom.
struct ChairsOptions {
  double minutes = 180;  ///< of motion
  int subjects = 6;      ///< people
  int64_t chairs = 240;  ///< fewer where there are fewer clips; of twelve two are for testing and one for validation
  double linger = 0;  ///< seconds that half of the people stand about at most before they set off, and after they have
                      ///< walked off. 0: none of them for long
  std::vector<std::string> parts;  ///< of seat_part_names() that hands take hold of, each as often; empty: what people
                                   ///< do on such a seat
  std::vector<std::string> kinds;  ///< of chair_kinds(); empty: all, in the proportions of draw_chair
  uint64_t seed = 1;               ///< of everything
  Shard shard;                     ///< of clips
  Progress progress;               ///< counts clips; may be empty
};

/// A native data set of people who walk up to chairs and sit on them, in `folder`: the composition of the COUCH data
/// set (right hand 17.3, left hand 14.0, both hands 28.9, no contact 17.4, free interaction 15.2, locomotion 7.2 % of
/// the minutes), clips of 12 to 24 s, starts 1 to 5 m from the chair in every direction. Each chair stands in a scene
/// of its own, a floor and in a third of them one or two pieces in the way, and is in one split only. Every clip draws
/// from a seed of its own, so the bytes do not depend on the number of threads (OpenMP, over clips); nothing is kept of
/// a clip that is written.
Dataset generate_chairs(const std::string& folder, const ChairsOptions& options);

/// What DatasetClip::source tells about a clip made here: "subject_2/right_hand/chair_000017".
struct ChairSource {
  int subject = 0;                                    ///< number of the person
  Interaction interaction = Interaction::no_contact;  ///< what the hands do
  int64_t chair = 0;                                  ///< number of the chair
};
/// "subject_0/INTERACTION/chair_000": what DatasetClip::source of a chairs data set says.
std::string source_text(const ChairSource& source);
/// Throws Error(text, ...) where it is none of a chairs data set.
ChairSource parse_chair_source(const std::string& text);

/// The split of chair `index`.
std::string split_of_chair(int64_t index);

/// A straight chair, an armchair, a stool, a sofa, a bed, an office chair or a closed seat of random size, seats 0.38
/// to 0.55 m high, of sofas from 0.33 and of beds from 0.36.
Furniture draw_chair(std::mt19937_64& random);
/// The kinds of these: "chair", "armchair", "stool", "sofa", "bed", "office_chair", "solid_chair".
const std::vector<std::string>& chair_kinds();
/// Such a chair, of one of `kinds` (empty: all), at a place near the middle of a floor without walls, sometimes with
/// other pieces around it.
Room make_chair_room(std::mt19937_64& random, const std::vector<std::string>& kinds = {});

}  // namespace inhabit
