#include "inhabit/synth/passages.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;

constexpr double kWalks = 0.5;               // metres a second of the root over the floor
constexpr double kSpan = 0.25;               // seconds before and after a place that tell the direction of travel
constexpr double kBetween = 1.2;             // metres of path from place to place
constexpr double kApartFromCapsules = 0.04;  // metres; skin is up to 3 cm further out
constexpr double kApartFromHands = 0.065;    // metres, of the capsules of hands: thumbs stick out by 6 cm
constexpr double kNarrowest = 0.2;           // metres from the root's path to a piece: legs alone
constexpr double kWidest = 0.6;              // the same: arms held out
constexpr double kGapStep = 0.01;            // metres
constexpr double kMoreRoom = 0.15;           // metres, at most
constexpr double kAskew = 0.15;              // radians from the direction of travel, at most
constexpr int kPassageAttempts = 6;          // for each place

/// A piece to walk past: low and high ones, deep and thin ones.
Furniture flank(std::mt19937_64& random) {
  switch (uniform_int(random, 0, 3)) {
    case 0: {
      Furniture shelf = make_shelf(random);
      shelf.rescale({uniform(random, 0.4, 1.0), 1, 1});
      return shelf;
    }
    case 1: {
      const double width = uniform(random, 0.4, 1.0), depth = uniform(random, 0.4, 0.6),
                   height = uniform(random, 0.7, 0.95);
      return make_table(random, width, depth, height);
    }
    case 2: {  // as wide as a sideboard, and often as high as a hanging hand
      Furniture chest = make_box(random);
      const double wider = uniform(random, 1, 2), higher = uniform(random, 1, 1.6);
      chest.rescale({wider, higher, 1});
      return chest;
    }
    default:
      return make_screen(random);
  }
}

/// `piece` on one side (1: left, -1: right) of `at`, as near as the body lets it, and `more` metres beyond that.
std::optional<Furniture> beside(Furniture piece, const BodySweep& sweep, const Vector2d& at, double heading, int side,
                                double more) {
  BodySweep::Gaps apart;
  apart.fill(kApartFromCapsules);
  apart[20] = apart[21] = kApartFromHands;
  const double half = piece.bounds().sizes().x() / 2;
  const auto place = [&](double gap) {
    const Vector2d middle = at + side * (gap + half) * left_of(heading);
    piece.place(middle.x(), middle.y(), heading);
  };
  for (double gap = kNarrowest; gap <= kWidest; gap += kGapStep) {
    place(gap);
    if (sweep.touches(piece, apart)) continue;
    place(gap + more);
    if (sweep.touches(piece, apart)) return {};  // there it stands in another part of the path
    return piece;
  }
  return {};
}

}  // namespace

void check_passages(double tried) {
  if (!(tried >= 0 && tried <= 1)) throw Error("the fraction of passages", "is not from 0 to 1");
}

int add_passages(Layout& layout, const Clip& clip, const BodySweep& sweep, double tried, std::mt19937_64& random) {
  if (tried == 0) return 0;  // nothing is drawn: rooms without passages stay the same
  const torch::Tensor path = clip.root_path().to(torch::kFloat64).contiguous();
  const auto root = path.accessor<double, 2>();
  const auto at = [&](int64_t t) { return Vector2d(root[t][0], root[t][2]); };
  const int64_t span = std::max<int64_t>(1, std::lround(kSpan * clip.rate));
  const double window = 2 * static_cast<double>(span) / clip.rate;  // seconds
  int passages = 0;
  double walked = uniform(random, 0, kBetween);
  for (int64_t t = span; t + span < clip.frames(); ++t) {
    walked += (at(t) - at(t - 1)).norm();
    const Vector2d travelled = at(t + span) - at(t - span);
    if (walked < kBetween || travelled.norm() < kWalks * window) continue;
    walked = 0;
    if (!chance(random, tried)) continue;
    for (int attempt = 0; attempt < kPassageAttempts; ++attempt) {
      const double heading = heading_of(travelled) + uniform(random, -kAskew, kAskew), draw = uniform(random, 0, 1);
      const double more = draw * draw * kMoreRoom;  // little, more often than not
      const Furniture piece = flank(random);
      const auto left = beside(piece, sweep, at(t), heading, 1, more);
      const auto right = beside(piece, sweep, at(t), heading, -1, more);
      if (!left || !right || !layout.add({*left, *right}, {})) continue;
      ++passages;
      break;
    }
  }
  return passages;
}

}  // namespace inhabit
