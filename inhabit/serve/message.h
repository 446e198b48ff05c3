#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace inhabit::serve {

// What a page asks for. Places on the floor are (x, z), points (x, y, z), metres, world; headings radians from +Z
// towards +X; hands 0 left, 1 right.

/// To a place on the floor.
struct Walk {
  Eigen::Vector2d to;  ///< (x, z)
};
/// Sit down.
struct Sit {
  std::string chair;  ///< name of a seat
};
/// A contact of a hand on a seat, or none of that hand any more.
struct Touch {
  int hand = 0;                       ///< 0 left, 1 right
  std::optional<Eigen::Vector3d> at;  ///< nothing: the hand is free
  std::string chair;                  ///< empty: the seat that is sat on or walked to
};
/// ContactNet draws contacts of both hands.
struct Draw {};
struct Stand {};
/// Back to where everybody begins.
struct Restart {};
/// Keep frames for a file, from now on or no more.
struct Record {
  bool on = false;  ///< from now on
};
/// The system whose prediction is shown.
enum class Preview { forecast, futures };
/// Paint what is ahead, from now on or no more.
struct Look {
  Preview what = Preview::forecast;  ///< of which system
  bool on = false;                   ///< from now on
};
/// Move to a pose (poses.h) at a place by in-betweening.
struct Take {
  std::string pose;    ///< its name
  Eigen::Vector2d at;  ///< (x, z)
  double heading = 0;  ///< radians
};

/// Any one thing that a page asks for.
using Order = std::variant<Walk, Sit, Touch, Draw, Stand, Restart, Record, Look, Take>;

/// An order with its number.
struct Message {
  uint32_t number = 0;  ///< the page's own count, told back by frames
  Order order;          ///< what is to be done
};

/// A message's JSON (docs/live.md). Throws Error("message", ...) for anything else: no JSON, other types, numbers that
/// are not finite or over 1000 m, unknown orders.
Message parse_message(std::string_view text);

}  // namespace inhabit::serve
