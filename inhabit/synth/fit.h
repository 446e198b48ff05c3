#pragma once
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/data/native.h"
#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/chords.h"
#include "inhabit/synth/generate.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// A recording made ready: retargeted to the standard joints, resampled to 30 frames a second, moved up or down so that
/// the floor its feet stand on is y = 0, and cut into pieces of at most `seconds` that stay within `extent` metres.
/// Stretches in which a flat floor cannot be what the person is on are cut out: both balls of the feet higher than 12
/// cm for longer than a jump takes (0.7 s), or the body below the floor; and so are frames in which a joint accelerates
/// by more than 350 m/s^2, as where a file begins with a rest pose. Pieces under two seconds are dropped. Throws
/// Error(subject, ...) for skeletons that cannot be retargeted.
std::vector<Clip> prepare_recording(const Clip& source, const std::string& subject, double seconds, double extent = 9);

/// A room around a motion, and the motion in it.
struct FittedRoom {
  Room room;          ///< with all its furniture
  Clip clip;          ///< rotated and moved into the room, with action, contact, hand_targets and object poses
  int seats = 0;      ///< put under the pelvis
  int supports = 0;   ///< put under hands
  int passages = 0;   ///< pairs of pieces that the person walks between
  int on_chords = 0;  ///< put where the straight path between poses passes (chords.h)
  int decoys = 0;     ///< seats and tables that the person passes by
};

/// What a room tells of where the person in it goes.
enum class Furnishing {
  around,  ///< furniture stands around the path, on chords of it too, and walls may be close
  decoys,  ///< seats and tables to be used stand along all of the path with free floor before them, another near each
           ///< that is used; walls are at least 1 m away; there are no passages and nothing is on chords
};

/// What actions of fitted clips are called.
const std::vector<std::string>& fitted_actions();

/// A furnished room that a prepared motion could have been recorded in: a seat of the right height under a pelvis that
/// rests low, tables and shelves under resting hands, walls around, and other furniture near the path that no part of
/// the body touches in any frame, some of it on chords of the motion and on both sides of walks. Another draw from
/// `random` gives another room. Nothing where the person sits but no seat fits under them.
/// @param passages fraction of the places along walks that get a piece on either side; none among decoys
std::optional<FittedRoom> fit_room(const Clip& prepared, const BodyModel& body, std::mt19937_64& random,
                                   const ChordOptions& chords = {}, Furnishing furnishing = Furnishing::around,
                                   double passages = 0);

/// Which recordings get rooms, and of what kind.
struct FittingOptions {
  std::vector<std::string> train;  ///< recordings, any format inhabit reads
  std::vector<std::string> val;    ///< likewise
  std::vector<std::string> test;   ///< likewise
  uint64_t seed = 1;               ///< of the rooms
  int rooms_per_clip = 3;          ///< around each piece of a recording
  double seconds = 12;             ///< longest piece of a recording
  bool mirrored = true;            ///< every second room of a piece for training is around its mirror image
  double stretches = 0.5;  ///< fraction of the rooms for training that are around stretches of 4.1 to 5.5 s of a piece
  ChordOptions chords;     ///< pieces that stand on straight paths
  double passages = 0;     ///< fraction of the places along walks that get a piece on either side
  bool only_on_chords = false;  ///< rooms for training without a piece on a chord are left out
  bool decoys = false;          ///< rooms of validation and testing are furnished with decoys
  ClipReadOptions reading;      ///< of every recording
  Shard shard;                  ///< of recordings
  Progress progress;            ///< counts recordings
};

/// Adds what a user names (files, folders, patterns: motion_files) to options.train; what is in a folder called test,
/// to options.test. Names in options.val and options.test become their files likewise. Throws what motion_files throws.
void add_recordings(FittingOptions& options, const std::vector<std::string>& named);

/// A native data set of fitted rooms. All pieces of one recording are in one split, and so is all of one person where
/// `train`, `val` and `test` are given by person. Where there is no `test`, the last tenth of three or more others is
/// taken for it; where there is no `val`, every tenth of the others. Provenance says how many minutes were recorded,
/// and how many of them have a room at least. One of several recordings that cannot be used, or makes no clip, is left
/// out, with the reason in the provenance as "skipped"; what is implausible() of others is there as "doubts". Throws
/// Error where nothing could be made of any recording (of all shards).
Dataset fit_recordings(const std::string& folder, const FittingOptions& options);

}  // namespace inhabit
