#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "inhabit/interact/config.h"

namespace inhabit::interact {

/// Where a part stands in a vector of features.
struct Span {
  int64_t first = 0;  ///< number of its first
  int64_t size = 0;   ///< how many numbers
  /// One past the last.
  int64_t end() const { return first + size; }
};

/// The window of time that State holds: what Config's window must be for features to be built.
inline constexpr int kPastKeys = 6,                          ///< keys before the present
    kFutureKeys = 6,                                         ///< keys after it
    kKeys = kPastKeys + 1 + kFutureKeys,                     ///< all of them
    kKeyStep = 5;                                            ///< frames from key to key
inline constexpr int kNow = kPastKeys * kKeyStep,            ///< the present's place among the samples
    kSamples = (kKeys - 1) * kKeyStep + 1;                   ///< of one sample a frame
inline constexpr int kJoints = 22,                           ///< the standard ones
    kActions = 3;                                            ///< idle, walk, sit
inline constexpr int kFuturePoints = kFutureKeys + 1;        ///< the present key and those after it
inline constexpr std::array<size_t, 2> kHandOrder = {1, 0};  ///< vectors have the right hand first
inline constexpr int kContacts = 5;                          ///< pelvis, right and left wrist, right and left ankle
inline constexpr int kAheadSize = 18;                        ///< of State::ahead as PoseNet sees it

/// PoseNet's input, all in the axes of the present root (Place). Hands: right, then left.
struct InputLayout {
  Span joints;       ///< joint: position 3, forward 3, up 3, velocity 3 (metres a second)
  Span trajectory;   ///< key: root's position x z, direction x z, idle walk sit
  Span goals;        ///< key: position 3, direction 3, idle walk sit
  Span ego;          ///< layer, ring, point: occupancy
  Span chair;        ///< voxel: position 3, value
  Span hands;        ///< hand, key: palm less contact 3; zeros without one
  Span hand_phases;  ///< key, hand
  Span ahead;        ///< with Config::seated_habits kAheadSize (build_input), else none
  Span gating;       ///< key: 3 x 2 of actions, 3 x 6 of goal actions (build_input)
  int64_t size = 0;  ///< numbers in all
};
/// Where each part of PoseNet's input stands with these settings.
InputLayout input_layout(const Config& config);

/// PoseNet's output: the next frame in the axes of the present root.
struct OutputLayout {
  Span joints;         ///< as in the input
  Span future_joints;  ///< joint: the same positions in the axes of the root one second later
  Span trajectory;     ///< as in the input, at the present and future keys of the next frame
  Span goal_root;      ///< the same keys: root's position x z and direction x z in the axes of that key's goal
  Span goals;          ///< as in the input
  Span contacts;       ///< kContacts
  Span phases;         ///< cycles from the present frame to the next frame's present and future keys
  int64_t size = 0;    ///< numbers in all
};
/// Where each part of PoseNet's output stands with these settings.
OutputLayout output_layout(const Config& config);

/// Throws Error(subject, ...) where the configuration's window, joints or actions are others than State holds.
void require_window(const Config& config, const std::string& subject);

}  // namespace inhabit::interact
