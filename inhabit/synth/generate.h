#pragma once
#include <cstdint>
#include <string>

#include "inhabit/data/native.h"
#include "inhabit/progress.h"
#include "inhabit/synth/chords.h"

namespace inhabit {

/// How much is made.
struct GenerateOptions {
  int64_t clips = 100;     ///< of people
  uint64_t seed = 1;       ///< of everything
  double seconds = 12;     ///< length of each clip
  int clips_per_room = 4;  ///< one after the other, each a life of its own
  ChordOptions chords{0};  ///< pieces that are added to a clip's room, which then is its own
  double passages = 0;  ///< fraction of the places along walks that get a piece on either side, in rooms of their own
  Shard shard;          ///< of rooms, with all that happens in them
  Progress progress;    ///< counts clips; may be empty
};

/// A native data set of people who live in made-up rooms, in `folder`. Each clip and room draws from a seed of its own,
/// so the bytes do not depend on the number of threads (OpenMP, over clips), and motion not on chords and passages. A
/// room is in one split only: 8 of 10 in train, 1 in val, 1 in test; with 3 to 9 rooms the last two are val and test.
Dataset generate_rooms(const std::string& folder, const GenerateOptions& options);

/// "clips/000012.npz" from "clips/", 12 and ".npz".
std::string numbered(const std::string& prefix, int64_t number, const std::string& extension);

/// The split of room `index` of `rooms`.
std::string split_of_room(int64_t index, int64_t rooms);

}  // namespace inhabit
