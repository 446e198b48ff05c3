#include "inhabit/synth/chords.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;

constexpr double kClear = 0.045;         // metres that a piece stays away from the body's true path
constexpr double kApartFromSkin = 0.04;  // of the body's capsules, whose skin is up to 3 cm further out
constexpr double kMeets = 0.05;          // metres that the body on the chord is in it
constexpr double kLeastDetour = 0.08;    // metres between joints on the chord and the true ones: less leaves no room
constexpr double kHighest = 1.9;         // metres: what is higher passes above furniture
constexpr int kBalls = 200;              // of a chord that are looked at
constexpr int kAttempts = 40;            // for each chord

/// A piece that can stand in somebody's way at the height of `ball`; larger ones first.
Furniture obstacle(const BodySweep::Ball& ball, int attempt, std::mt19937_64& random) {
  const double height = ball.center.y() - ball.radius;
  const int kind = attempt < kAttempts / 2 ? uniform_int(random, 0, 6) : uniform_int(random, 4, 6);
  const double width = uniform(random, 0.4, 1.3), depth = uniform(random, 0.35, 0.7);
  switch (kind) {
    case 0:
      return chance(random, 0.5) ? make_chair(random) : make_armchair(random);
    case 1:
      return make_table(random, width, depth, height > 0.4 ? uniform(random, 0.70, 0.76) : uniform(random, 0.38, 0.5));
    case 2: {
      Furniture shelf = make_shelf(random);
      shelf.rescale({uniform(random, 0.4, 1.0), 1, 1});
      return shelf;
    }
    case 3:
      return make_stool(random);
    case 4:
      return make_box(random);
    case 5:
      return make_plant(random);
    default:
      return make_post(random);
  }
}

/// The nearest part of the true path to a ball, of what is lower than `top`: where its skin is on the floor plan, the
/// direction from it to the ball, and the metres between it and the ball's centre.
struct Nearest {
  Vector2d skin, away;
  double gap = 1e9;
};
Nearest nearest_part(const BodySweep& sweep, const BodySweep::Ball& from, double top) {
  Nearest out;
  const Vector2d at = on_ground(from.center);
  for (const BodySweep::Ball& ball : sweep.balls()) {
    if (ball.center.y() - ball.radius > top) continue;
    const Vector2d between = at - on_ground(ball.center);
    const double gap = between.norm() - ball.radius;
    if (gap >= out.gap) continue;
    out.gap = gap;
    out.away = between.normalized();
    out.skin = on_ground(ball.center) + ball.radius * out.away;
  }
  return out;
}

/// A ball of a chord that is off the true path.
struct Place {
  const BodySweep::Ball* ball;
  double free;  // metres that the path to it leaves for a piece that the ball meets
};

/// Of balls drawn from a chord those that leave room for a piece, if only a low one.
std::vector<Place> places_on(const BodySweep& chord, const BodySweep& sweep, std::mt19937_64& random) {
  std::vector<Place> out;
  for (int i = 0; i < kBalls; ++i) {
    const auto draw = static_cast<size_t>(uniform_int(random, 0, static_cast<int>(chord.balls().size()) - 1));
    const BodySweep::Ball& ball = chord.balls()[draw];
    const double low = ball.center.y() - ball.radius;
    if (low > kHighest) continue;
    const double free = nearest_part(sweep, ball, low + 0.1).gap + std::max(0.0, ball.radius - kMeets) - kClear;
    if (free > 0) out.push_back({&ball, free});
  }
  return out;
}

/// Puts `piece` beside the true path, reaching towards it, where `ball` of the chord passes. False where there is no
/// room for that.
bool put_before(Furniture& piece, const BodySweep& sweep, const BodySweep::Ball& ball, std::mt19937_64& random) {
  const Eigen::AlignedBox3d box = piece.bounds();
  if (ball.center.y() - ball.radius > box.max().y()) return false;
  const Nearest near = nearest_part(sweep, ball, box.max().y());
  const double most = near.gap + std::max(0.0, ball.radius - kMeets);  // from the skin to the piece
  if (most < kClear) return false;
  const double draw = uniform(random, 0, 1), gap = kClear + draw * draw * (most - kClear);
  const double jitter = chance(random, 0.5) ? 0 : uniform(random, -0.4, 0.4);
  const double along = uniform(random, -0.7, 0.7) * box.max().x();
  const Vector2d middle =
      near.skin + near.away * (gap + box.max().z()) + along * Vector2d(near.away.y(), -near.away.x());
  piece.place(middle.x(), middle.y(), heading_of(-near.away) + jitter);
  return true;
}

/// A piece on the chord from the first to the last pose of `true_path`; false where none fits.
bool block_chord(Layout& layout, const Clip& true_path, const BodyModel& body, const BodySweep& sweep,
                 std::mt19937_64& random) {
  PoseTrack track = pose_track(true_path);
  interpolate_between(track, 0, track.frames() - 1);
  Clip straight = person_of(true_path);
  set_pose(straight, track);
  if ((straight.joints - true_path.joints).norm(2, 2).max().item<double>() < kLeastDetour) return false;
  const BodySweep chord(straight, body);
  BodySweep::Gaps meets, apart;
  meets.fill(-kMeets);
  apart.fill(kApartFromSkin);
  const std::vector<Place> places = places_on(chord, sweep, random);
  if (places.empty()) return false;
  double all = 0;
  for (const Place& place : places) all += place.free;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    // The farther off the true path, the more often.
    double draw = uniform(random, 0, all);
    auto place = places.begin();
    while (place + 1 != places.end() && draw > place->free) draw -= (place++)->free;
    Furniture piece = obstacle(*place->ball, attempt, random);
    if (put_before(piece, sweep, *place->ball, random) && chord.touches(piece, meets) && !sweep.touches(piece, apart) &&
        layout.add({piece}, {}))
      return true;
  }
  return false;
}

}  // namespace

void check_chords(const ChordOptions& options) {
  if (!(options.tried >= 0 && options.tried <= 1)) throw Error("the fraction of chords", "is not from 0 to 1");
  if (options.shortest < 2 || options.longest < options.shortest)
    throw Error("the lengths of chords", "are not two numbers of frames, at least 2 and in order");
}

int add_on_chords(Layout& layout, const Clip& clip, const BodyModel& body, const BodySweep& sweep,
                  const ChordOptions& options, std::mt19937_64& random) {
  const auto frames = static_cast<int>(clip.frames());
  int pieces = 0;
  for (int first = 0; first + options.shortest < frames;) {
    // Even in the logarithm: as many chords of 30 to 60 frames as of 60 to 120.
    const double length =
        options.shortest * std::pow(static_cast<double>(options.longest) / options.shortest, uniform(random, 0, 1));
    const int last = std::min(frames - 1, first + static_cast<int>(std::lround(length)));
    if (chance(random, options.tried))
      pieces += block_chord(layout, slice(clip, first, last + 1), body, sweep, random) ? 1 : 0;
    first += std::max(1, (last - first) / 2);
  }
  return pieces;
}

}  // namespace inhabit
