#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"
#include "inhabit/interact/settle.h"

namespace inhabit::serve {

/// A pose as it is kept and sent.
struct Frame {
  std::array<Eigen::Quaternionf, kStandardJoints> rotation;                                  ///< relative to the parent
  Eigen::Vector3f trans = Eigen::Vector3f::Zero();                                           ///< metres, as Clip::trans
  std::array<Eigen::Vector3f, 2> contact{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  ///< left, right, world
  std::array<bool, 2> reaching{};  ///< the hand is on its way to, or at, its contact
  uint8_t action = 0;              ///< idle, walk, sit
};

/// A frame of an interaction's pose, without contacts and action.
Frame frame_of(const interact::SettledPose& pose);
/// The pose of a frame in double precision, without contacts and action.
interact::SettledPose pose_of(const Frame& frame);
/// A frame of a clip on the standard skeleton with rotations.
Frame frame_of(const Clip& clip, int64_t index);
/// Frames as a motion at 30 frames a second, with hand targets and actions.
Clip clip_of(const std::vector<Frame>& frames, const Clip& person);
/// A pose between two: `weight` of the second, 0 to 1.
Frame blended(const Frame& from, const Frame& to, double weight);

// What is sent, little-endian; rotations as x y z w of 1/32767 each, 16 bits.

/// What is told beside a pose.
struct Status {
  bool seated = false;                    ///< the pelvis is on a seat
  bool recording = false;                 ///< frames are kept for a file
  bool filling = false;                   ///< moved by in-betweening
  uint32_t index = 0;                     ///< frames since the connection began
  uint32_t number = 0;                    ///< of the last message that the frame knows of
  std::array<float, 2> distance{-1, -1};  ///< metres from palms to contacts; negative: none
};

/// 208 bytes: u8 1, u8 flags (seated 1, recording 2, filling 4, left hand reaching 8, right 16), u8 action, u8 0, u32
/// index, u32 number, f32 left and right distance, f32[3] translation, i16[22][4].
std::string pose_bytes(const Frame& frame, const Status& status);

/// A pose that is painted as a see-through body.
struct Ghost {
  float seconds = 0;  ///< ahead of now
  uint8_t track = 0;  ///< which of several futures
  Frame frame;        ///< its pose
};

/// u8 2, u8 kind (0 forecast, 1 futures, 2 the pose that is moved to), u16 count, then 196 bytes for each: f32 seconds,
/// u8 track, u8[3] 0, f32[3] translation, i16[22][4].
std::string ghost_bytes(int kind, const std::vector<Ghost>& ghosts);

}  // namespace inhabit::serve
