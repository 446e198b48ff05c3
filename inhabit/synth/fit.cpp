#include "inhabit/synth/fit.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/touch_labels.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/scene/query.h"
#include "inhabit/synth/body_sweep.h"
#include "inhabit/synth/layout.h"
#include "inhabit/synth/passages.h"
#include "inhabit/synth/person.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kApart = 0.02;   // metres between the body and what it does not use
constexpr double kSink = -0.018;  // how far flesh may sink into what is sat on or touched

struct Span {
  int first = 0, last = 0;  // frames [first, last)
};

// Runs of at least `least` frames for which `holds`.
template <class Holds>
std::vector<Span> runs(int frames, int least, Holds holds) {
  std::vector<Span> out;
  for (int t = 0, first = -1; t <= frames; ++t) {
    const bool now = t < frames && holds(t);
    if (now && first < 0) first = t;
    if (!now && first >= 0) {
      if (t - first >= least) out.push_back({first, t});
      first = -1;
    }
  }
  return out;
}

// What the fitting asks of a clip, as plain numbers.
struct Motion {
  int frames = 0;
  std::vector<std::array<Vector3d, kStandardJoints>> joints;
  std::vector<std::array<double, kStandardJoints>> speed;

  explicit Motion(const Clip& clip) : frames(static_cast<int>(clip.frames())) {
    const torch::Tensor p = clip.joints.contiguous(), s = joint_speeds(clip).contiguous();
    const auto pa = p.accessor<float, 3>();
    const auto sa = s.accessor<float, 2>();
    joints.resize(static_cast<size_t>(frames));
    speed.resize(static_cast<size_t>(frames));
    for (int t = 0; t < frames; ++t)
      for (int j = 0; j < kStandardJoints; ++j) {
        joints[t][j] = {pa[t][j][0], pa[t][j][1], pa[t][j][2]};
        speed[t][j] = sa[t][j];
      }
  }
  // The direction the hips face, on the floor. Not heading(): on a seat the shoulders may turn away, and directions,
  // not angles, are added up.
  Vector2d facing(int t) const {
    const Vector3d right_to_left = joints[t][1] - joints[t][2];
    const Vector2d flat = on_ground(right_to_left.cross(Vector3d::UnitY()));
    return flat.norm() > 1e-6 ? Vector2d(flat.normalized()) : Vector2d(0, 1);
  }
};

BodySweep::Gaps gaps_with(double sink, std::initializer_list<int> sinking) {
  BodySweep::Gaps gaps;
  gaps.fill(kApart);
  for (const int joint : sinking) gaps[static_cast<size_t>(joint)] = sink;
  return gaps;
}

// A place where the person sits: frames, the level of the seat's top, where the pelvis rests and how it faces.
struct Rest {
  Span frames;
  double level = 0;
  Vector2d place;
  double yaw = 0;
  double rear = 0;  // metres from the pelvis back to the end of the trunk
};

std::vector<Rest> find_rests(const Motion& m, const BodySweep& sweep) {
  std::vector<double> heights;
  heights.reserve(static_cast<size_t>(m.frames));
  for (int t = 0; t < m.frames; ++t) heights.push_back(m.joints[t][0].y());
  const double leg = (m.joints[0][1] - m.joints[0][4]).norm() + (m.joints[0][4] - m.joints[0][7]).norm();
  const std::vector<Span> spans = runs(m.frames, static_cast<int>(0.4 * kSynthRate), [&](int t) {
    const Vector3d& pelvis = m.joints[t][0];
    const Vector3d ankles = (m.joints[t][7] + m.joints[t][8]) / 2;
    const double ahead = std::hypot(pelvis.x() - ankles.x(), pelvis.z() - ankles.z());
    return pelvis.y() < 0.75 * leg && pelvis.y() > 0.35 && m.speed[t][0] < 0.2 && ahead > 0.18;
  });
  std::vector<Rest> rests;
  for (const Span& span : spans) {
    Rest rest;
    rest.frames = span;
    Vector2d place(0, 0), facing(0, 0);
    for (int t = span.first; t < span.last; ++t) {
      const Vector3d thighs = (m.joints[t][4] + m.joints[t][5] - m.joints[t][1] - m.joints[t][2]) / 2;
      place += Vector2d(m.joints[t][0].x(), m.joints[t][0].z());
      facing += m.facing(t) + Vector2d(thighs.x(), thighs.z());
    }
    rest.place = place / (span.last - span.first);
    rest.yaw = heading_of(facing);
    const Vector3d ahead(std::sin(rest.yaw), 0, std::cos(rest.yaw));
    // The seat is as high as the lowest part of pelvis and thighs near the pelvis; its back is behind the trunk.
    rest.level = 1e9;
    for (const BodySweep::Ball& ball : sweep.balls()) {
      if (ball.frame < span.first || ball.frame >= span.last) continue;
      const Vector3d from(ball.center.x() - rest.place.x(), 0, ball.center.z() - rest.place.y());
      if (ball.joint <= 2 && from.norm() < 0.22) rest.level = std::min(rest.level, ball.center.y() - ball.radius);
      if (ball.joint == 0 || ball.joint == 3 || ball.joint == 6 || ball.joint == 9)
        rest.rear = std::max(rest.rear, ball.radius - from.dot(ahead));
    }
    if (rest.level < 0.28 || rest.level > 0.75) continue;
    auto same = std::find_if(rests.begin(), rests.end(), [&](const Rest& r) {
      return (r.place - rest.place).norm() < 0.2 && std::abs(r.level - rest.level) < 0.06;
    });
    if (same == rests.end()) {
      rests.push_back(rest);
    } else {
      same->level = std::min(same->level, rest.level);
      same->rear = std::max(same->rear, rest.rear);
    }
  }
  return rests;
}

// A seat under `rest`, or false where none fits.
bool add_seat(Layout& layout, const BodySweep& sweep, const Rest& rest, std::mt19937_64& random,
              BodySweep::Gaps& gaps) {
  gaps = gaps_with(kSink, {0, 1, 2, 3, 6, 9});
  const int favourite = uniform_int(random, 0, 3);
  for (int attempt = 0; attempt < 48; ++attempt) {
    // Kinds in turn from the favourite on; a stool, which has least to touch, ever more often.
    const int kind = attempt < 12 ? favourite : attempt < 32 ? uniform_int(random, 0, 3) : 2;
    Furniture seat = kind == 0   ? make_chair(random, rest.level)
                     : kind == 1 ? make_armchair(random, rest.level)
                     : kind == 2 ? make_stool(random, rest.level)
                                 : make_sofa(random, uniform_int(random, 2, 3), rest.level);
    std::vector<Surface> places;
    for (const Surface& s : seat.surfaces)
      if (s.kind == Surface::Kind::seat) places.push_back(s);
    const Surface& s = places[static_cast<size_t>(uniform_int(random, 0, static_cast<int>(places.size()) - 1))];
    const double yaw = rest.yaw + uniform(random, -0.1, 0.1);
    double z =
        seat.back_height > 0 ? seat.back_z + rest.rear + uniform(random, 0.0, 0.04) : uniform(random, -0.06, 0.02);
    const double x = s.center.x() + uniform(random, -0.03, 0.03);
    // The pelvis stays over the seat even where the trunk leans far back.
    z = std::min(z, s.center.z() + s.half_depth - 0.08);
    const Vector3d pelvis = Eigen::AngleAxisd(yaw, Vector3d::UnitY()) * Vector3d(x, 0, z);
    seat.place(rest.place.x() - pelvis.x(), rest.place.y() - pelvis.z(), yaw);
    if (sweep.touches(seat, gaps)) continue;
    if (layout.add({seat}, {})) return true;
  }
  return false;
}

// A hand that stays somewhere, away from the body.
struct HandRest {
  Span frames;
  Vector3d palm;   // middle of the hand, its height that of the lowest part
  double yaw = 0;  // from the body to the hand
};

std::vector<HandRest> find_hand_rests(const Motion& m, const BodySweep& sweep) {
  std::vector<HandRest> out;
  for (const int side : {0, 1}) {
    const int wrist = 20 + side;
    const std::vector<Span> spans = runs(m.frames, static_cast<int>(0.5 * kSynthRate), [&](int t) {
      const Vector3d& hand = m.joints[t][wrist];
      const Vector3d& pelvis = m.joints[t][0];
      const double away = std::hypot(hand.x() - pelvis.x(), hand.z() - pelvis.z());
      double to_leg = 1e9;
      for (const int j : {1, 2, 4, 5}) to_leg = std::min(to_leg, (hand - m.joints[t][j]).norm());
      return m.speed[t][wrist] < 0.12 && hand.y() > 0.5 && hand.y() < 1.5 && away > 0.28 && to_leg > 0.24 &&
             hand.y() < m.joints[t][15].y() - 0.1;
    });
    for (const Span& span : spans) {
      HandRest rest;
      rest.frames = span;
      Vector3d sum = Vector3d::Zero();
      double low = 1e9;
      int balls = 0;
      for (const BodySweep::Ball& ball : sweep.balls()) {
        if (ball.joint != wrist || ball.frame < span.first || ball.frame >= span.last) continue;
        sum += ball.center;
        low = std::min(low, ball.center.y() - ball.radius);
        ++balls;
      }
      if (balls == 0) continue;
      rest.palm = sum / balls;
      rest.palm.y() = low;
      const Vector3d& pelvis = m.joints[(span.first + span.last) / 2][0];
      rest.yaw = heading_of(on_ground(rest.palm - pelvis));
      out.push_back(rest);
    }
  }
  return out;
}

// A table or shelf under a resting hand, its front to the person.
bool add_support(Layout& layout, const BodySweep& sweep, const HandRest& rest, std::mt19937_64& random,
                 BodySweep::Gaps& gaps) {
  gaps = gaps_with(kSink, {20, 21});
  for (int attempt = 0; attempt < 24; ++attempt) {
    const bool table = rest.palm.y() < 0.98 && !(rest.palm.y() > 0.8 && chance(random, 0.5));
    Furniture piece = [&] {
      if (!table) return make_shelf(random, rest.palm.y());
      const double width = uniform(random, 0.45, 1.3), depth = uniform(random, 0.4, 0.8);
      return make_table(random, width, depth, rest.palm.y());
    }();
    const auto top = std::find_if(piece.surfaces.begin(), piece.surfaces.end(),
                                  [&](const Surface& s) { return std::abs(s.center.y() - rest.palm.y()) < 0.011; });
    if (top == piece.surfaces.end()) continue;
    const double x = top->center.x() + uniform(random, -0.8, 0.8) * (top->half_width - 0.06);
    const double z = top->center.z() + top->half_depth - uniform(random, 0.07, std::min(0.3, 1.6 * top->half_depth));
    const double yaw = rest.yaw + M_PI + uniform(random, -0.5, 0.5);
    const Vector3d hand = Eigen::AngleAxisd(yaw, Vector3d::UnitY()) * Vector3d(x, 0, z);
    piece.place(rest.palm.x() - hand.x(), rest.palm.z() - hand.z(), yaw);
    if (sweep.touches(piece, gaps)) continue;
    if (layout.add({piece}, {})) return true;
  }
  return false;
}

// Pieces right beside the path of the body, as furniture is in homes.
void add_near_path(Layout& layout, const Motion& m, std::mt19937_64& random) {
  const int pieces = uniform_int(random, 2, 5);
  for (int i = 0; i < pieces; ++i)
    for (int attempt = 0; attempt < 30; ++attempt) {
      const Vector3d& at = m.joints[static_cast<size_t>(uniform_int(random, 0, m.frames - 1))][0];
      const double direction = uniform(random, -M_PI, M_PI), distance = uniform(random, 0.4, 1.4);
      const int kind = uniform_int(random, 0, 4);
      const double width = uniform(random, 0.5, 1.4), depth = uniform(random, 0.4, 0.8);
      const double height = chance(random, 0.7) ? uniform(random, 0.70, 0.76) : uniform(random, 0.38, 0.46);
      Furniture piece = kind == 0   ? make_chair(random)
                        : kind == 1 ? make_stool(random)
                        : kind == 2 ? make_armchair(random)
                        : kind == 3 ? make_shelf(random)
                                    : make_table(random, width, depth, height);
      // Front to the path, roughly, square to the room more often than not.
      double yaw = direction + M_PI + uniform(random, -0.6, 0.6);
      if (kind >= 3 || chance(random, 0.5)) yaw = std::round(yaw / (M_PI / 2)) * (M_PI / 2);
      piece.place(at.x() + distance * std::sin(direction), at.z() + distance * std::cos(direction), yaw);
      if (layout.add({piece}, {})) break;
    }
}

// Seats and tables that could be used from a path that passes them, with free floor before them, so that a seat in
// reach does not say that somebody sits down: two to five along the path, and one more within 2.5 m of each of `used`,
// where they fit. Returns how many do.
int add_decoys(Layout& layout, const Motion& m, const std::vector<Vector2d>& used, std::mt19937_64& random) {
  constexpr double kFreeDepth = 0.5;  // metres of floor that somebody needs to sit down or to stand at a table
  int added = 0;
  const auto add_one = [&](const std::function<Vector2d()>& beside, double nearest, double farthest) {
    for (int attempt = 0; attempt < 40; ++attempt) {
      const Vector2d at = beside();
      const double direction = uniform(random, -M_PI, M_PI), distance = uniform(random, nearest, farthest);
      const int kind = uniform_int(random, 0, 4);
      const double width = uniform(random, 0.5, 1.4), depth = uniform(random, 0.4, 0.8);
      Furniture piece = kind == 0   ? make_chair(random)
                        : kind == 1 ? make_stool(random)
                        : kind == 2 ? make_armchair(random)
                        : kind == 3 ? make_sofa(random, uniform_int(random, 2, 3))
                                    : make_table(random, width, depth, uniform(random, 0.70, 0.76));
      const double yaw = direction + M_PI + uniform(random, -0.5, 0.5);
      piece.place(at.x() + distance * std::sin(direction), at.y() + distance * std::cos(direction), yaw);
      const Patch covered = footprint(piece);
      const Vector2d ahead(std::sin(yaw), std::cos(yaw));
      const Patch before{
          covered.center + ahead * (covered.half.y() + kFreeDepth / 2), {covered.half.x(), kFreeDepth / 2}, yaw};
      if (!layout.add({piece}, {before})) continue;
      ++added;
      return;
    }
  };
  const int pieces = uniform_int(random, 2, 5);
  for (int i = 0; i < pieces; ++i)
    add_one([&] { return on_ground(m.joints[static_cast<size_t>(uniform_int(random, 0, m.frames - 1))][0]); }, 0.6,
            1.4);
  for (const Vector2d& place : used) add_one([&] { return place; }, 0.9, 2.5);
  return added;
}

// Actions, contacts, hand targets and objects, from where the body is in the scene.
void annotate(Clip& clip, const Room& room, const BodyModel& body) {
  TouchLabels(room.scene(), body).label(clip);
  label_actions(clip);
  const int64_t T = clip.frames();
  clip.object_names.clear();
  std::vector<torch::Tensor> poses;
  for (size_t i = 0; i < room.furniture.size(); ++i) {
    clip.object_names.push_back(room.object_name(i));
    const Eigen::Isometry3d& pose = room.furniture[i].pose;
    poses.push_back(
        torch::tensor({static_cast<float>(pose.translation().x()), 0.F, static_cast<float>(pose.translation().z()), 0.F,
                       static_cast<float>(heading_of(on_ground(pose.linear().col(2)))), 0.F}));
  }
  clip.object_pose = poses.empty() ? torch::zeros({T, 0, 6}) : torch::stack(poses).expand({T, -1, -1}).contiguous();
}

}  // namespace

const std::vector<std::string>& fitted_actions() { return told_actions(); }

std::optional<FittedRoom> fit_room(const Clip& prepared, const BodyModel& body, std::mt19937_64& random,
                                   const ChordOptions& chords, Furnishing furnishing, double passages) {
  const bool decoys = furnishing == Furnishing::decoys;
  FittedRoom out;
  // Walls along the motion's long side, turned a little, any side first.
  double best = 1e9, yaw = 0;
  const torch::Tensor path = prepared.joints.index_select(2, torch::tensor({0, 2})).reshape({-1, 2});
  for (int i = 0; i < 18; ++i) {
    const double a = i * M_PI / 36;
    const torch::Tensor x = path.select(1, 0) * std::cos(a) + path.select(1, 1) * std::sin(a);
    const torch::Tensor z = path.select(1, 1) * std::cos(a) - path.select(1, 0) * std::sin(a);
    const double area = ((x.max() - x.min()) * (z.max() - z.min())).item<double>();
    if (area < best) best = area, yaw = a;
  }
  yaw += uniform_int(random, 0, 3) * M_PI / 2 + uniform(random, -0.15, 0.15);
  out.clip = transformed(prepared, {yaw});
  {
    const BodySweep around(out.clip, body);
    std::array<double, 4> free{};
    for (double& f : free)
      f = decoys                ? uniform(random, 1.0, 2.2)
          : chance(random, 0.4) ? uniform(random, 0.12, 0.5)
                                : uniform(random, 0.5, 1.8);
    Vector2d low = around.low() - Vector2d(free[0], free[1]), high = around.high() + Vector2d(free[2], free[3]);
    const Vector2d more = (Vector2d(3.5, 3.5) - (high - low)).cwiseMax(0);
    const double part_x = uniform(random, 0, 1), part_z = uniform(random, 0, 1);
    low -= more.cwiseProduct(Vector2d(part_x, part_z));
    high += more.cwiseProduct(Vector2d(1 - part_x, 1 - part_z));
    const Vector2d middle = (low + high) / 2;
    out.clip = transformed(out.clip, {0, {-middle.x(), 0, -middle.y()}});
    out.room.size = high - low;
  }
  out.room.height = uniform(random, 2.5, 2.9);
  paint(out.room, random);
  const BodySweep sweep(out.clip, body);
  const Motion motion(out.clip);
  Layout layout(out.room, add_walls(out.room, random));
  BodySweep::Gaps gaps = gaps_with(0, {});
  layout.require([&](const Furniture& piece) { return !sweep.touches(piece, gaps); });
  std::vector<Vector2d> used;
  for (const Rest& rest : find_rests(motion, sweep)) {
    if (!add_seat(layout, sweep, rest, random, gaps)) return std::nullopt;
    ++out.seats;
    used.push_back(rest.place);
  }
  for (const HandRest& rest : find_hand_rests(motion, sweep))
    if (chance(random, 0.8) && add_support(layout, sweep, rest, random, gaps)) {
      ++out.supports;
      used.push_back(on_ground(rest.palm));
    }
  gaps = gaps_with(0, {});
  if (decoys) {
    out.decoys = add_decoys(layout, motion, used, random);
  } else {
    out.passages = add_passages(layout, out.clip, sweep, passages, random);
    out.on_chords = add_on_chords(layout, out.clip, body, sweep, chords, random);
    add_near_path(layout, motion, random);
  }
  furnish(layout, random);
  annotate(out.clip, out.room, body);
  return out;
}

}  // namespace inhabit
