#include "inhabit/interact/live_person.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/interact/advance.h"
#include "inhabit/interact/guide.h"
#include "inhabit/interact/habits.h"
#include "inhabit/interact/labels.h"
#include "inhabit/interact/recording.h"
#include "inhabit/interact/route.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/synth/posing.h"

namespace inhabit::interact {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kIdleAction = 0, kWalkAction = 1, kSitAction = 2;
constexpr int kSoon = 5;            // frames: hands leave for their contacts when sitting down begins this soon
constexpr double kReachTime = 1.4;  // that people take to a contact
constexpr double kMoved = 0.25;     // metres that a contact may be moved by without a new plan
constexpr double kReached = 0.05;   // metres from a palm to its contact
constexpr double kStraight = 0.3;   // metres that are free on both sides of a straight route
constexpr double kNearSeat = 0.15, kOnSeat = 0.2;  // metres: the pelvis beside and above its place on the seat
constexpr double kClose = 0.5, kBeside = 1;        // metres: who comes no nearer, or stops there, has arrived, too
constexpr int kSetsOff = 30;                       // frames within which people set off
constexpr double kStandsStill = 0.03;              // metres in half a second: less is no nearer, or a stop
constexpr double kOffSeat = 0.3;                   // metres: who only shifts on the seat does not go so far from it

Vector3f single(const Vector3d& v) { return v.cast<float>(); }

}  // namespace

struct LivePerson::Impl {
  const Engine& engine;
  Bones bones;
  State state;
  SettledPose pose;
  ChairGrid grid;
  std::optional<SeatedLife> seated_life;
  std::optional<StandingLife> standing_life;
  std::optional<Chair> chair;
  std::shared_ptr<const Surroundings> around;
  HandContacts contacts;
  double hold_seconds = kHold;
  std::array<int, 2> in_contact{};  // frames since the contact was reached
  std::array<bool, 2> begun{};      // the hand has left for it
  struct Target {
    Vector3d place = Vector3d::Zero();
    double heading = 0;
    int action = kIdleAction;
  } target;
  bool plans = true, blocked = false;
  bool stays = false;          // arrived at the target, or blocked
  bool rests = false;          // and has come to a stop
  int under_way = 0;           // frames since the target was given
  std::optional<Guide> guide;  // to near the target; none where they go straight
  bool guided = false;         // a route was needed
  Engine::Workspace work;
  std::array<float, kControlPose> control_pose{};
  std::array<float, kControlSize> control_in{}, control_out{};

  Impl(const Engine& e, uint64_t seed) : engine(e), work(e, seed) {}

  bool pelvis_within(double beside, double above) const {
    if (!chair) return false;
    const Vector3d off = chair->off(state.position[0].cast<double>());
    return Eigen::Vector2d(off.x(), off.z()).norm() < beside && off.y() < above;
  }
  bool seated() const { return pelvis_within(kNearSeat, kOnSeat); }

  Eigen::Vector2d here() const { return on_ground(state.position[0].cast<double>()); }

  void aim(const Target& at, int after) {
    set_goal(state, single(at.place), ahead_of(at.heading).cast<float>(), at.action, after);
  }

  /// Goes to the target along `route`: none where there is no route, or none is planned.
  void go(const Target& to, std::optional<WalkPath> route) {
    blocked = stays = plans && !route;
    rests = false;
    under_way = 0;
    if (standing_life) standing_life.emplace(engine.networks().habits);
    guide.reset();
    target = to;
    if (blocked) {
      const Vector3f at = state.now().root.origin();
      target = {at.cast<double>(), heading_of(state.now().root.facing.cast<double>()), kIdleAction};
    }
    // Somebody who stands sets off a second after they get a goal. In the data somebody who walks has had theirs all
    // along, and walking without one means stopping: so they get it for all samples.
    const bool walks = state.now().action[kWalkAction] > 0.5F;
    aim(target, walks && state.now().goal_action[kIdleAction] > 0.5F ? -kNow : kSamples - 1 - kNow);
    guided = plans && route && !(to.action == kSitAction && is_straight(*route));
    if (guided) guide.emplace(std::move(*route));
  }

  /// Whether they may walk straight to the end of a route.
  bool is_straight(const WalkPath& route) const {
    return straight(around->floor(), here(), route.points.back(), kStraight);
  }

  const Sample& half_a_second_ago() const { return state.samples[kNow / 2]; }
  bool stopped() const { return (state.now().root.position - half_a_second_ago().root.position).norm() < kStandsStill; }
  /// Whether they are at the place to walk to, or have walked close to it and come no nearer, or have stopped beside
  /// it.
  bool arrived() const {
    const auto left = [&](const Sample& s) {
      return (on_ground(target.place) - s.root.position.cast<double>()).norm();
    };
    const Sample& before = half_a_second_ago();
    const double now = left(state.now());
    return now < kArrived || (now < (stopped() ? kBeside : kClose) && under_way > kSetsOff &&
                              before.action[kWalkAction] > 0.5F && left(before) - now < kStandsStill);
  }

  /// The route is left where the rest of it is straight, the place on the floor reached where they are near. They then
  /// stay where they come to a stop: drawn on to the place itself, feet would slide.
  void follow() {
    ++under_way;
    if (guide) {
      guide->follow(here());
      if (target.action == kSitAction && is_straight(guide->route())) guide.reset();
    }
    if (stays && !rests && stopped()) {
      rests = true;
      target.place = {here().x(), 0, here().y()};
    }
    if (target.action != kWalkAction || !arrived()) return;
    guide.reset();
    target.action = kIdleAction;
    stays = true;
    aim(target, 0);
  }

  /// Draws the predicted trajectory to the route, then to the line before the seat. Who can walk straight to where one
  /// sits down does so by the networks alone.
  void draw() {
    if (guide)
      guide->draw(state);
    else if (guided && target.action == kSitAction && !seated())
      draw_before(*chair, state);
    else if (plans && stays && !(rests && standing_life))
      hold(on_ground(target.place), state);
  }

  /// Hands leave for contacts when sitting down is about to begin, or at once where the person sits.
  void plan_hands() {
    if (!chair) return;
    const bool about_to = state.samples[kNow + kSoon].action[kSitAction] > 0.5F;
    for (int side = 0; side < 2; ++side) {
      const auto s = static_cast<size_t>(side);
      if (!contacts[s]) continue;
      if (!begun[s] && (about_to || seated())) {
        if (engine.controlled() && !state.wanted[0] && !state.wanted[1]) engine.start_control(work);
        give_contact(state, side, single(*contacts[s]), kReachTime);
        begun[s] = true;
        in_contact[s] = 0;
      } else if (state.wanted[s]) {
        const bool there = (palm_of(state, side) - single(*contacts[s])).norm() < kReached;
        if ((there || in_contact[s] > 0) && ++in_contact[s] > hold_seconds * engine.config().rate)
          drop_contact(state, side);
      }
    }
  }

  /// What they do while they stay where they are and no contact says.
  AheadPose leisure() {
    if (state.wanted[0] || state.wanted[1]) return {};
    if (seated_life && target.action == kSitAction && seated()) return seated_life->next(state, work.random);
    const bool on_the_way = stays && !rests;
    if (standing_life && target.action == kIdleAction && !on_the_way) return standing_life->next(state, work.random);
    return {};
  }

  void step() {
    follow();
    plan_hands();
    state.ahead = leisure();
    if (grid.centres.empty())
      std::fill_n(work.input.begin() + engine.input().chair.first, engine.input().chair.size, 0.F);
    build_input(engine.input(), state, {grid, engine.ego(), *around}, work.input.data());
    build_contacts(state, work.contacts.data());
    engine.predict(work);
    const Place root = state.now().root;
    const bool controlled = engine.controlled() && (state.wanted[0] || state.wanted[1]);
    if (controlled) {
      build_control_input(state, control_pose.data(), control_in.data());
      engine.control(control_pose.data(), control_in.data(), control_out.data(), work);
    }
    const auto& inference = engine.config().inference;
    apply_output(engine.output(), work.output.data(), {inference.goal_idle, inference.goal_walk, inference.goal_sit},
                 engine.config().rate, state);
    if (controlled) apply_control(control_out.data(), root, state);
    draw();
    settle(bones, state, pose);
  }
};

LivePerson::LivePerson(const Engine& engine, const Clip& start, uint64_t seed) : impl_(new Impl(engine, seed)) {
  if (start.frames() < 1 || start.skeleton.parents != standard_parents() || !start.rotations.defined() ||
      !start.trans.defined())
    throw Error("start", "needs a pose with rotations on the standard skeleton");
  Impl& p = *impl_;
  p.bones = bones_of(start.skeleton);
  p.pose.local = local_quaternions(start.rotations[-1]);
  const torch::Tensor trans = start.trans[-1].to(torch::kFloat64).contiguous();
  p.pose.trans = Eigen::Map<const Vector3d>(trans.data_ptr<double>());
  pose_bones(p.bones, p.pose.local, p.pose.trans, p.pose.posed);
  std::array<Vector3f, kJoints> position;
  std::array<Eigen::Matrix3f, kJoints> rotation;
  for (size_t j = 0; j < kJoints; ++j) {
    position[j] = single(p.pose.posed.positions[j]);
    rotation[j] = p.pose.posed.rotations[j].toRotationMatrix().cast<float>();
  }
  p.state = start.frames() > 1 ? state_after(start, "start") : standing_state(position, rotation);
  if (const Habits& habits = engine.networks().habits; habits.standing.size() > 0) p.standing_life.emplace(habits);
  p.around = std::make_shared<Surroundings>(Scene{});
}
LivePerson::~LivePerson() = default;
LivePerson::LivePerson(LivePerson&&) noexcept = default;

void LivePerson::sit_on(const Chair& chair, std::shared_ptr<const Surroundings> around, const HandContacts& contacts,
                        double hold) {
  impl_->chair = chair;
  impl_->grid = sense_chair(chair, impl_->engine.config());
  const Habits& habits = impl_->engine.networks().habits;
  if (habits.seated.size() > 0) impl_->seated_life.emplace(habits, impl_->grid, chair.seat_height);
  impl_->around = std::move(around);
  Impl& p = *impl_;
  p.go({chair.seat(), chair.heading(), kSitAction},
       p.plans ? find_route(p.around->floor(), p.here(), chair) : std::nullopt);
  reach_for(contacts, hold);
}

void LivePerson::reach_for(const HandContacts& contacts, double hold) {
  Impl& p = *impl_;
  p.hold_seconds = hold;
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<size_t>(side);
    if (p.state.wanted[s] && contacts[s] && (*contacts[s] - *p.contacts[s]).norm() < kMoved) {
      move_contact(p.state, side, single(*contacts[s]));
      p.in_contact[s] = 0;
      continue;
    }
    if (p.state.wanted[s]) drop_contact(p.state, side);
    p.begun[s] = false;
  }
  p.contacts = contacts;
}

void LivePerson::walk_to(const Eigen::Vector2d& place, double heading) {
  reach_for({});
  Impl& p = *impl_;
  std::optional<WalkPath> route;
  if (p.plans && p.seated())
    route = find_route(p.around->floor(), *p.chair, place);
  else if (p.plans)
    route = find_route(p.around->floor(), p.here(), place);
  p.go({{place.x(), 0, place.y()}, heading, kWalkAction}, std::move(route));
}

void LivePerson::plan_routes(bool plan) { impl_->plans = plan; }
bool LivePerson::blocked() const { return impl_->blocked; }
const WalkPath* LivePerson::route() const { return impl_->guide ? &impl_->guide->route() : nullptr; }

void LivePerson::step() { impl_->step(); }
const SettledPose& LivePerson::pose() const { return impl_->pose; }
const State& LivePerson::state() const { return impl_->state; }
bool LivePerson::seated() const { return impl_->seated(); }
bool LivePerson::off_seat() const { return !impl_->pelvis_within(kOffSeat, kOffSeat); }

bool LivePerson::done(int side) const {
  const auto s = static_cast<size_t>(side);
  return !impl_->contacts[s] || (impl_->begun[s] && !impl_->state.wanted[s]);
}

std::optional<double> LivePerson::contact_distance(int side) const {
  const auto& contact = impl_->contacts[static_cast<size_t>(side)];
  if (!contact) return std::nullopt;
  return (palm_of(impl_->state, side).cast<double>() - *contact).norm();
}

Clip clip_of(const std::vector<SettledPose>& poses, const Clip& person, double rate) {
  const auto frames = static_cast<int64_t>(poses.size());
  Clip clip = person_of(person);
  clip.rate = rate;
  clip.rotations = torch::empty({frames, kStandardJoints, 3});
  clip.trans = torch::empty({frames, 3});
  float *rotation = clip.rotations.data_ptr<float>(), *trans = clip.trans.data_ptr<float>();
  const auto write = [](const Vector3d& v, float*& to) {
    for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(v[i]);
  };
  for (const SettledPose& pose : poses) {
    for (const Quaterniond& q : pose.local) write(axis_angle_of(q), rotation);
    write(pose.trans, trans);
  }
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

Clip standing_clip(const Eigen::Vector2d& place, double heading, const torch::Tensor& betas) {
  const BodyModel& body = builtin_body();
  const Figure figure = make_figure(body, betas);
  Controls controls;
  controls.root = {place.x(), figure.stand_height, place.y()};
  controls.yaw = controls.gaze_yaw = heading;
  const Eigen::Vector2d ahead = ahead_of(heading), left = left_of(heading);
  for (int side = 0; side < 2; ++side) {
    const Eigen::Vector2d ball = place + (side == 0 ? 0.09 : -0.09) * left + (figure.ankle_ahead + 0.1) * ahead;
    controls.foot[side] = {{ball.x(), figure.ball_height, ball.y()}, heading, 0, 0};
    controls.arm[side].abduction = 0.12;
    controls.arm[side].elbow = 0.2;
  }
  const Posed posed = pose_figure(figure, controls);
  SettledPose pose{{posed.local.begin(), posed.local.end()}, posed.position[0] - figure.bones.offsets[0], {}};
  Clip person;
  person.skeleton = shaped_skeleton(body, betas);
  person.betas = betas;
  return clip_of({pose}, person, 30);
}

}  // namespace inhabit::interact
