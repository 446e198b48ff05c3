#include "inhabit/serve/character.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inhabit/error.h"
#include "inhabit/interact/contact_surface.h"
#include "inhabit/math/heading.h"

namespace inhabit::serve {
namespace {

using Eigen::Vector2d;

constexpr size_t kPast = 75;         // frames that are remembered: 2.5 s
constexpr int kBlend = 10;           // frames in which a motion takes over
constexpr double kBeforeSeat = 0.9;  // metres before a seat that people stand up to
constexpr double kOnSeat = 0.3;      // metres from the nearest place of a seat, aside and up: a pelvis that is on it
constexpr int kStop = 16;            // frames in which somebody who walks comes to stand
constexpr double kThere = 0.06, kPassed = 0.6;  // metres from a place: there; where walking past it is noticed
constexpr double kMoves = 0.05;                 // metres ahead: of who walks at all
constexpr double kAside = 0.15;                 // metres that coming to stand may lead aside
constexpr int kSits = 2;                        // Frame::action
constexpr double kNear = 0.15;                  // metres: nobody turns for a path that short

Vector2d root_of(const Frame& frame) { return {frame.trans.x(), frame.trans.z()}; }

}  // namespace

Character::Character(std::shared_ptr<const World> world) : world_(std::move(world)) { restart(); }

void Character::restart() {
  leave_motion();
  past_.clear();
  blending_ = kBlend;
  become(frame_of(world_->person, 0));
}

void Character::become(const Frame& frame) {
  contacts_ = {};
  reach_soon_ = senses_ = false;
  walking_to_.reset();
  walking_.reset();
  frame_ = frame;
  Clip start = interact::clip_of({pose_of(frame)}, world_->person, 30);
  live_ = std::make_unique<interact::LivePerson>(world_->interactor.engine(), start);
}

void Character::leave_motion() {
  if (motion_.empty()) return;
  motion_.clear();
  at_ = 0;
  become(frame_);
}

void Character::walk(const Vector2d& to) {
  if ((to.array() < world_->low.array()).any() || (to.array() > world_->high.array()).any())
    throw Error("place", "is outside the scene");
  if (!world_->free_at(to)) throw Error("place", "is taken: nobody can stand there");
  leave_motion();
  contacts_ = {};
  const Vector2d line = to - root_of(frame_);
  const Eigen::Vector3f ahead = frame_.rotation[0] * Eigen::Vector3f::UnitZ();
  go_to(to, heading_of(line.norm() < kNear ? Vector2d(ahead.x(), ahead.z()) : line));
}

void Character::blend_from_here() {
  left_from_ = frame_;
  blending_ = 0;
}

/// Somebody who comes to stand is told something else.
void Character::walk_on() {
  if (!walking_) return;
  if (2 * stopping_ < kStop) live_ = std::move(walking_);
  walking_.reset();
  blend_from_here();
}

void Character::go_to(const Vector2d& place, double heading) {
  walk_on();
  // The networks have only seen people who sense a chair: without one nobody sets off.
  if (!senses_ && !world_->seats.empty()) {
    const Vector2d here = root_of(frame_);
    const auto far = [&](const Seat& seat) { return (on_ground(seat.chair.seat()) - here).norm(); };
    const auto nearest = std::min_element(world_->seats.begin(), world_->seats.end(),
                                          [&](const Seat& a, const Seat& b) { return far(a) < far(b); });
    live_->sit_on(nearest->chair, world_->around, {});
    senses_ = true;
  }
  live_->walk_to(place, heading);
  walking_to_.reset();
  if (live_->blocked()) throw Error("place", "cannot be walked to: there is no route");
  walking_to_ = place;
}

/// Who comes to their place stands still from now on: half a second in which one who walks on becomes one who stands,
/// as far ahead as walking at half the speed leads.
void Character::stop_at_place() {
  if (!walking_to_ || past_.size() < 4) return;
  const Eigen::Vector3f ahead = (frame_.trans - past_[past_.size() - 4].trans) / 4.F * (kStop / 2.F);
  const Vector2d here = root_of(frame_), left = *walking_to_ - here;
  const Vector2d stride(ahead.x(), ahead.z());
  const double step = stride.norm();
  const bool here_now = left.norm() < kThere;
  if (!here_now && (step < kMoves || left.norm() > kPassed || left.dot(stride) > step * step)) return;
  Frame there = frame_;
  Vector2d aside = left - stride;  // that the path misses the place by
  aside *= std::min(1.0, kAside / std::max(aside.norm(), 1e-6));
  there.trans += Eigen::Vector3f(ahead.x(), 0, ahead.z()) + Eigen::Vector3d(aside.x(), 0, aside.y()).cast<float>();
  auto walking = std::move(live_);
  const Frame now = frame_;
  become(there);
  frame_ = now;
  walking_ = std::move(walking);
  stopping_ = 0;
}

const Seat& Character::seat_for(const std::string& chair) const {
  if (!chair.empty()) return world_->seat(chair);
  if (contacts_.chair.empty()) throw Error("contact", "needs a chair: click on one first");
  return world_->seat(contacts_.chair);
}

void Character::sit(const std::string& chair) {
  const Seat& seat = world_->seat(chair);
  leave_motion();
  walk_on();
  contacts_ = {chair, {}};
  live_->sit_on(seat.chair, world_->around, {});
  senses_ = true;
  walking_to_.reset();
  if (live_->blocked()) {
    contacts_ = {};
    throw Error(chair, "cannot be walked up to: there is no route");
  }
}

void Character::touch(const Touch& touch) {
  const auto hand = static_cast<size_t>(touch.hand);
  if (!touch.at) {
    contacts_.at[hand].reset();
    reach_soon_ = !contacts_.chair.empty();
    return;
  }
  const Seat& seat = seat_for(touch.chair);
  const Eigen::Vector3d on =
      interact::contact_on_surface(seat.chair, seat.surface, world_->person.skeleton, touch.hand, *touch.at);
  if (seat.chair.name != contacts_.chair) sit(seat.chair.name);
  contacts_.at[hand] = on;
  reach_soon_ = true;
}

void Character::draw() {
  const Seat& seat = seat_for("");
  interact::HandContacts drawn;
  // A draw may have no contact of either hand that is on the chair and within reach.
  for (int attempt = 0; attempt < 8 && !drawn[0] && !drawn[1]; ++attempt) {
    drawn = world_->interactor.draw_contacts(seat.chair, 1, ++draws_)[0];
    for (int hand = 0; hand < 2; ++hand) {
      auto& contact = drawn[static_cast<size_t>(hand)];
      if (!contact) continue;
      try {
        contact = interact::contact_on_surface(seat.chair, seat.surface, world_->person.skeleton, hand, *contact);
      } catch (const Error&) {
        contact.reset();
      }
    }
  }
  if (!drawn[0] && !drawn[1]) throw Error(seat.chair.name, "no contact on it was drawn");
  contacts_.at = drawn;
  reach_soon_ = true;
}

void Character::stand() {
  if (!motion_.empty()) return leave_motion();  // upright again from the pose that is held
  if (contacts_.chair.empty()) throw Error("stand", "nobody sits");
  const interact::Chair& chair = world_->seat(contacts_.chair).chair;
  const Vector2d seat = on_ground(chair.seat());
  const double heading = chair.heading();
  // Ahead where that is free, else aside.
  for (const double aside : {0.0, 0.4, -0.4, 0.8, -0.8})
    for (const double far : {kBeforeSeat, 0.7, 1.2}) {
      const Vector2d place = seat + far * ahead_of(heading + aside);
      if (!world_->free_at(place)) continue;
      contacts_ = {};
      return go_to(place, heading + aside);
    }
  throw Error(chair.name, "has no free floor before it to stand on");
}

void Character::play(const Clip& motion) {
  std::vector<Frame> frames;
  for (int64_t t = 0; t < motion.frames(); ++t) frames.push_back(frame_of(motion, t));
  contacts_ = {};
  walking_to_.reset();
  walking_.reset();
  blend_from_here();
  motion_ = std::move(frames);
  at_ = 0;
}

void Character::reach() {
  if (contacts_.chair.empty()) return;
  constexpr double kOn = std::numeric_limits<double>::infinity();  // whoever gave contacts in the page takes them away
  live_->reach_for(contacts_.at, kOn);
  reach_soon_ = false;
}

bool Character::seated() const {
  if (contacts_.chair.empty() || frame_.action != kSits) return false;
  const Eigen::Vector3d off = world_->seat(contacts_.chair).chair.off(live_->state().position[0].cast<double>());
  return on_ground(off).norm() < kOnSeat && off.y() < kOnSeat;
}

/// One frame of the networks.
void Character::live_step() {
  if (reach_soon_) reach();
  live_->step();
  frame_ = frame_of(live_->pose());
  if (walking_) {
    walking_->step();
    const double u = ++stopping_ / static_cast<double>(kStop);
    frame_ = blended(frame_of(walking_->pose()), frame_, u * u * (3 - 2 * u));
    if (stopping_ == kStop) walking_.reset();
  }
  const interact::State& state = live_->state();
  const auto& weights = state.now().action;
  frame_.action = static_cast<uint8_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  for (size_t hand = 0; hand < 2; ++hand) {
    frame_.reaching[hand] = state.wanted[hand];
    frame_.contact[hand] = state.contact[hand];
  }
}

void Character::step() {
  ++index_;
  if (playing()) {
    frame_ = motion_[at_++];
  } else if (motion_.empty()) {
    live_step();
    stop_at_place();
  }
  if (blending_ < kBlend) frame_ = blended(left_from_, frame_, ++blending_ / (kBlend + 1.0));
  past_.push_back(frame_);
  if (past_.size() > kPast) past_.pop_front();
}

Status Character::status() const {
  Status out;
  out.index = index_;
  out.filling = playing();
  if (!motion_.empty()) return out;
  out.seated = seated();
  for (int hand = 0; hand < 2; ++hand)
    if (contacts_.at[static_cast<size_t>(hand)])
      out.distance[static_cast<size_t>(hand)] = static_cast<float>(live_->contact_distance(hand).value_or(-1));
  return out;
}

Clip Character::recent(double seconds) const {
  const auto count = static_cast<size_t>(std::lround(30 * seconds));
  std::vector<Frame> frames(past_.end() - static_cast<int64_t>(std::min(count, past_.size())), past_.end());
  if (frames.empty()) frames.push_back(frame_);
  frames.insert(frames.begin(), count > frames.size() ? count - frames.size() : 0, frames.front());
  return clip_of(frames, world_->person);
}

}  // namespace inhabit::serve
