#pragma once
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/data/native.h"
#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/generate.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// A recording made ready: retargeted to the standard joints, resampled to 30 frames a second, moved up or down so that
/// the floor its feet stand on is y = 0, and cut into pieces of at most `seconds` that stay within `extent` metres.
/// Pieces under two seconds are dropped. Throws Error(subject, ...) for skeletons that cannot be retargeted.
std::vector<Clip> prepare_recording(const Clip& source, const std::string& subject, double seconds, double extent = 9);

/// A room around a motion, and the motion in it.
struct FittedRoom {
  Room room;
  Clip clip;         ///< rotated and moved into the room, with action, contact, hand_targets and object poses
  int seats = 0;     ///< put under the pelvis
  int supports = 0;  ///< put under hands
};

/// A furnished room that a prepared motion could have been recorded in: a seat of the right height under a pelvis that
/// rests low, tables and shelves under resting hands, walls around, and other furniture near the path that no part of
/// the body touches in any frame. Another draw from `random` gives another room. Nothing where the person sits but no
/// seat fits under them.
std::optional<FittedRoom> fit_room(const Clip& prepared, const BodyModel& body, std::mt19937_64& random);

struct FittingOptions {
  std::vector<std::string> train, test;  ///< recordings, any format inhabit reads
  uint64_t seed = 1;
  int rooms_per_clip = 3;
  double seconds = 12;      ///< longest piece of a recording
  ClipReadOptions reading;  ///< of every recording
  Progress progress;        ///< counts recordings
};

/// A native data set of fitted rooms. All pieces of one recording are in one split: `test` in test (where there are
/// none, the last tenth of three or more others), every tenth of the others in val, the rest in train. Throws Error
/// where nothing could be made of any recording.
Dataset fit_recordings(const std::string& folder, const FittingOptions& options);

}  // namespace inhabit
