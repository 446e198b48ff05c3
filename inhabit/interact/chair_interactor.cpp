#include "inhabit/interact/chair_interactor.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/interact/contact_surface.h"
#include "inhabit/interact/fit_contacts.h"
#include "inhabit/interact/labels.h"
#include "inhabit/interact/route.h"
#include "inhabit/interact/standing_place.h"
#include "inhabit/interruption.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/dead_blending.h"
#include "inhabit/motion/observe.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/motion/transfer.h"
#include "inhabit/nn/random_tensor.h"
#include "inhabit/scene/bounding_box.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/surface_place.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

constexpr double kLowestContact = 0.1;  // metres above the floor
constexpr double kInside = 0.05;        // metres from a surface that nobody begins within
constexpr double kSeenBefore = 1.1;     // seconds of a start that count
constexpr float kFeet = 0.12F;          // metres above the floor
constexpr int64_t kFade = 12;           // frames over which a motion before fades into the networks'
constexpr int64_t kMostSamples = 1000, kMostDraws = 100'000;

/// Throws Error for an option that no person and no scene can make good.
void require_possible(const Options& options) {
  if (!(options.seconds > 0 && options.seconds <= 3600)) throw Error("seconds", "are not over 0 and up to 3600");
  if (!(options.hold > 0)) throw Error("hold", "is not over 0");
  if (std::isinf(options.hold) && options.then_walk)
    throw Error("hold", "hands that hold on to the end let nobody walk off");
}

/// The chair that is meant, in a scene.
Chair chosen_chair(const Scene& scene, const Options& o, const Vector3d& from) {
  if (o.sit_at) return chair_at(scene, o.sit_at->head<3>(), (*o.sit_at)[3], o.force);
  // On a sofa one sits where one comes to first, or where the hands are to go.
  Eigen::Vector2d towards = on_ground(from);
  if (!o.contacts.empty()) {
    const HandContacts& hands = o.contacts.front();
    if (hands[0] && hands[1])
      towards = on_ground(0.5 * (*hands[0] + *hands[1]));
    else if (hands[0] || hands[1])
      towards = on_ground(hands[0] ? *hands[0] : *hands[1]);
  }
  if (!o.chair.empty() && o.chair != "auto") return nearest_place(find_chair(scene, o.chair, o.force), towards);
  std::vector<Chair> chairs = find_chairs(scene);
  if (chairs.empty()) {
    const std::vector<std::string> names = object_names(scene);
    if (names.size() == 1) chairs.push_back(find_chair(scene, names[0], o.force));  // or says why it is none
    for (size_t k = 0; o.force && chairs.empty() && k < names.size(); ++k) {
      try {
        chairs.push_back(find_chair(scene, names[k], true));
      } catch (const Error&) {
        continue;  // nothing level in it
      }
    }
  }
  if (chairs.empty()) throw Error(scene.name.empty() ? "scene" : scene.name, "holds nothing to sit on");
  for (Chair& chair : chairs) chair = nearest_place(chair, towards);
  return *std::min_element(chairs.begin(), chairs.end(), [&](const Chair& a, const Chair& b) {
    return (a.seat() - from).norm() < (b.seat() - from).norm();
  });
}

/// Where somebody's pelvis is in their last frame.
Vector3d pelvis_of(const Clip& person) {
  const Tensor root = person.joints[-1][0].to(torch::kFloat64).contiguous();
  return Eigen::Map<const Vector3d>(root.data_ptr<double>());
}

/// The chair of somebody who is yet to be placed before one, whatever their hands are to do.
Chair chair_nearest_to_origin(const Scene& scene, Options options) {
  options.contacts.clear();
  return chosen_chair(scene, options, pelvis_of(standing_clip({0, 0}, 0)));
}

/// The chair of somebody who was placed before the `first` one. Along a sofa contacts decide, but another seat may be
/// nearer to the place before this one: who is placed before a chair sits on that one.
Chair chair_of_placed(const Chair& first, const Scene& scene, const Options& options) {
  if (options.contacts.empty()) return first;
  return chosen_chair(scene, options, pelvis_of(standing_clip(on_ground(first.seat()), 0)));
}

/// Moves contacts to the chair's surface. Throws Error for one in the air or out of the arms' reach.
void settle_contacts(const Chair& chair, const Skeleton& skeleton, bool force, HandContacts& contacts) {
  const SceneQuery surface(Scene{chair.name, {chair.mesh}, {}});
  for (int side = 0; side < 2; ++side)
    if (auto& contact = contacts[static_cast<size_t>(side)])
      contact = contact_on_surface(chair, surface, skeleton, side, *contact, force);
}

/// Throws Error where a joint, or the middle of a bone, is in something.
void require_free(const Clip& person, const Surroundings& around, const std::string& name) {
  const Tensor joints = person.joints[0].to(torch::kFloat32).contiguous();
  const auto at = [&](int64_t j) { return Eigen::Vector3f(joints.data_ptr<float>() + 3 * j); };
  for (int64_t j = 0; j < kStandardJoints; ++j) {
    const Eigen::Vector3f middle = 0.5F * (at(j) + at(std::max(0, standard_parents()[static_cast<size_t>(j)])));
    // Feet are near a floor that is part of a scan.
    const auto near = [&](const Eigen::Vector3f& p) { return p.y() > kFeet && around.distance(p, 1) < kInside; };
    if (near(at(j)) || near(middle))
      throw Error(name, fmt::format("begins inside what stands in the scene ({})",
                                    standard_joint_names()[static_cast<size_t>(j)]));
  }
}

using ContactErrors = std::vector<std::array<std::optional<double>, 2>>;

/// What a person did, frame by frame, in a scene whose floor is y = 0.
struct Take {
  std::vector<SettledPose> poses;
  Tensor targets, action;          // (T, 2, 4), (T)
  std::vector<size_t> contact_of;  // (T) which of the series was reached for
  ContactErrors contact_error;     // the closest approach to each
  std::optional<int64_t> seated;   // first frame from which they sit to the end
  bool left = false;               // they were told to walk off
};

/// Seconds that hands stay at the i-th contacts of a series.
double hold_of(const Options& options, size_t i, size_t contacts) {
  return std::isinf(options.hold) && i + 1 < contacts ? kHold : options.hold;
}

/// @param options whose contacts are `series`, on the surface
Take perform(LivePerson& person, const std::vector<HandContacts>& series, const Options& options, int64_t frames) {
  constexpr int64_t kSits = 60;  // frames
  Take take;
  take.poses.push_back(person.pose());
  take.targets = torch::zeros({frames, 2, 4});
  take.action = torch::zeros({frames}, torch::kInt64);
  take.contact_error.resize(series.size());
  take.contact_of.assign(static_cast<size_t>(frames), 0);
  size_t present = 0;
  for (int64_t t = 1; t < frames; ++t) {
    interruption_point();
    if (options.progress) options.progress(t, frames);
    person.step();
    take.poses.push_back(person.pose());
    const State& state = person.state();
    const auto& weights = state.now().action;
    take.action[t] = std::max_element(weights.begin(), weights.end()) - weights.begin();
    take.contact_of[static_cast<size_t>(t)] = present;
    if (take.left) continue;
    if (person.off_seat())
      take.seated.reset();
    else if (person.seated() && !take.seated)
      take.seated = t;
    bool all = true;
    for (int side = 0; side < 2; ++side) {
      const auto s = static_cast<size_t>(side);
      const Eigen::Vector3f& c = state.contact[s];
      if (state.wanted[s]) take.targets[t][side] = torch::tensor({c.x(), c.y(), c.z(), 1.F});
      const auto distance = person.contact_distance(side);
      if (!distance || present >= series.size()) continue;
      auto& least = take.contact_error[present][s];
      least = std::min(least.value_or(*distance), *distance);
      all = all && person.done(side);
    }
    if (all && present + 1 < series.size()) {
      ++present;
      person.reach_for(series[present], hold_of(options, present, series.size()));
    } else if (all && options.then_walk && take.seated && t - *take.seated >= kSits) {
      person.walk_to(options.then_walk->head<2>(), (*options.then_walk)[2]);
      take.left = true;
    }
  }
  if (options.progress) options.progress(frames, frames);
  return take;
}

/// The same errors of a motion that was fitted.
ContactErrors errors_after(const Clip& motion, const std::vector<size_t>& contact_of, ContactErrors errors) {
  const Tensor distances = contact_distances(motion).contiguous();
  const auto at = distances.accessor<float, 2>();
  const ContactErrors raw = errors;  // of contacts that no hand left for
  for (auto& both : errors) both = {};
  for (int64_t t = 0; t < motion.frames(); ++t)
    for (int64_t side = 0; side < 2; ++side)
      if (!std::isnan(at[t][side])) {
        auto& least = errors[contact_of[static_cast<size_t>(t)]][static_cast<size_t>(side)];
        least = std::min(least.value_or(HUGE_VAL), static_cast<double>(at[t][side]));
      }
  for (size_t i = 0; i < raw.size(); ++i)
    for (size_t side = 0; side < 2; ++side)
      if (!errors[i][side]) errors[i][side] = raw[i][side];
  return errors;
}

/// Whether (x, z) is within 3 m of the box around all that a scene holds.
bool is_within(const Scene& scene, const Eigen::Vector2d& place) {
  constexpr double kBeyond = 3;
  const Eigen::AlignedBox2d box = on_ground(bounding_box(scene));
  return box.isEmpty() || box.exteriorDistance(place) <= kBeyond;
}

/// Metres on the floor from where the root ends to a place (x, z, heading).
double distance_on_ground(const Clip& motion, const Vector3d& place) {
  const Tensor root = motion.joints[-1][0].to(torch::kFloat64).contiguous();
  return (on_ground(Eigen::Map<const Vector3d>(root.data_ptr<double>())) - place.head<2>()).norm();
}

}  // namespace

struct ChairInteractor::Impl {
  Engine engine;
  Impl(const Networks& networks, Predictor predictor) : engine(networks, predictor) {}
};

ChairInteractor::ChairInteractor(const Networks& networks, Predictor predictor)
    : impl_(new Impl(networks, predictor)) {}
ChairInteractor::~ChairInteractor() = default;
ChairInteractor::ChairInteractor(ChairInteractor&&) noexcept = default;
ChairInteractor ChairInteractor::load(const std::string& path) { return ChairInteractor(load_networks(path)); }
const Config& ChairInteractor::config() const { return impl_->engine.config(); }
const Engine& ChairInteractor::engine() const { return impl_->engine; }

std::vector<HandContacts> ChairInteractor::draw_contacts(const Chair& chair, int64_t count, uint64_t seed) const {
  const torch::NoGradGuard no_gradients;
  ContactNetwork network = impl_->engine.networks().contact;
  if (count < 0 || count > kMostDraws) throw Error("count", fmt::format("is not from 0 to {}", kMostDraws));
  if (network.is_empty()) throw Error("contacts", "the model has no ContactNet");
  const ChairGrid grid = sense_chair(chair, config());
  Tensor condition = torch::empty({1, config().chair_size()});
  contact_condition(grid, condition.data_ptr<float>());
  const SceneQuery surface(Scene{chair.name, {chair.mesh}, {}});
  const double floor = chair.frame.translation().y();
  std::vector<HandContacts> out;
  for (int64_t i = 0; i < count; ++i) {
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(i)));
    const Tensor z = nn::normal_tensor(random, {1, config().contact_z}, config().inference.contact_spread);
    const Tensor drawn = network->decode(z, condition).contiguous();
    HandContacts contacts;
    for (const int side : {1, 0}) {  // the network has the right hand first
      const float* p = drawn.data_ptr<float>() + (side == 1 ? 0 : 3);
      const Vector3d point = grid.seat.out({p[0], p[1], p[2]}).cast<double>() + Vector3d(0, floor, 0);
      const SurfacePlace touched = nearest_places(surface, {point}).front();
      if (touched.distance <= kOffSurface && touched.place.y() - floor >= kLowestContact)
        contacts[static_cast<size_t>(side)] = touched.place;
    }
    out.push_back(contacts);
  }
  return out;
}

Chair ChairInteractor::chair_of(const Clip& start, const Scene& scene, const Options& options) const {
  if (start.frames() > 0) return chosen_chair(scene, options, pelvis_of(start));
  return chair_of_placed(chair_nearest_to_origin(scene, options), scene, options);
}

Result ChairInteractor::run(const Clip& start, const Scene& scene, const Options& options) const {
  return std::move(run_samples(start, scene, options, 1).front());
}

std::vector<Result> ChairInteractor::run_samples(const Clip& start, const Scene& scene, const Options& options,
                                                 int64_t samples) const {
  require_possible(options);
  if (samples < 1 || samples > kMostSamples) throw Error("samples", fmt::format("is not from 1 to {}", kMostSamples));
  Options one = options;
  Chair chair;
  Clip placed = start;
  if (start.frames() > 0) {
    chair = chosen_chair(scene, options, pelvis_of(start));
  } else {
    const Chair first = chair_nearest_to_origin(scene, options);
    chair = chair_of_placed(first, scene, options);
    placed = standing_before(first, scene);
    one.name = "the person before the chair";
  }
  std::vector<Result> out;
  for (int64_t i = 0; i < samples; ++i) {
    one.seed = options.seed + static_cast<uint64_t>(i);
    one.progress = part_of(options.progress, i, samples);
    out.push_back(run_on(placed, scene, chair, one));
  }
  return out;
}

Result ChairInteractor::run_on(const Clip& start, const Scene& scene, const Chair& chosen,
                               const Options& options) const {
  const torch::NoGradGuard no_gradients;
  require_possible(options);
  Result out;
  if (start.frames() < 1) throw Error(options.name, "has no frame");
  out.chair = chosen;
  const auto seen = static_cast<int64_t>(std::ceil(kSeenBefore * start.rate)) + 1;
  Clip past = observe(slice(start, std::max<int64_t>(0, start.frames() - seen), start.frames()), -1, config().rate, 1,
                      options.name)
                  .motion;
  const double floor = out.chair.frame.translation().y();

  out.contacts = options.draw_contacts ? draw_contacts(out.chair, 1, options.seed) : options.contacts;
  for (HandContacts& contacts : out.contacts) settle_contacts(out.chair, past.skeleton, options.force, contacts);
  const Scene there = raised(scene, -floor);  // what the chair stands on is y = 0
  const auto around = std::make_shared<const Surroundings>(there);
  Chair chair = out.chair;
  chair.frame.translation().y() = 0;
  chair.mesh.vertices = chair.mesh.vertices - torch::tensor({0.F, static_cast<float>(floor), 0.F});
  past.trans = past.trans - torch::tensor({0.F, static_cast<float>(floor), 0.F});
  past.joints = joint_positions(past.skeleton, past.rotations, past.trans);
  const Clip person = slice(past, past.frames() - 1, past.frames());
  if (!options.force) require_free(person, *around, options.name);
  LivePerson live(impl_->engine, past, options.seed);
  live.plan_routes(!options.straight);
  std::vector<HandContacts> series = out.contacts;
  for (HandContacts& contacts : series)
    for (auto& contact : contacts)
      if (contact) contact->y() -= floor;
  live.sit_on(chair, around, series.empty() ? HandContacts{} : series[0], hold_of(options, 0, series.size()));
  if (live.blocked()) throw Error(options.name, "there is no route from there to " + out.chair.name);
  if (options.then_walk && !options.force && !is_within(there, options.then_walk->head<2>()))
    throw Error("the place to walk to",
                fmt::format("{:g},{:g} is over 3 m outside the scene", options.then_walk->x(), options.then_walk->y()));
  if (options.then_walk && !options.straight && !find_route(around->floor(), chair, options.then_walk->head<2>()))
    throw Error("the place to walk to", "there is no route to it from " + out.chair.name);
  const Take take = perform(live, series, options, std::max<int64_t>(1, std::llround(options.seconds * config().rate)));
  out.contact_error = take.contact_error;
  out.seated = take.seated;
  out.motion = clip_of(take.poses, person, config().rate);
  if (!options.raw && past.frames() > 1) {
    // The networks' first pose is their own: after a motion a swinging foot would jump.
    PoseTrack track = pose_track(out.motion);
    dead_blend(track, pose_track(slice(past, past.frames() - 2, past.frames() - 1)), kFade);
    set_pose(out.motion, track);
  }
  out.motion.hand_targets = take.targets;
  out.motion.action_names = kActionNames;
  out.motion.action = take.action;
  if (!options.raw) {
    out.motion = fit_contacts(out.motion, there);
    out.contact_error = errors_after(out.motion, take.contact_of, take.contact_error);
  }
  if (options.then_walk) out.walk_error = take.left ? distance_on_ground(out.motion, *options.then_walk) : HUGE_VAL;
  const Tensor up = torch::tensor({0.F, static_cast<float>(floor), 0.F});
  out.motion.trans = out.motion.trans + up;
  out.motion.joints = out.motion.joints + up;
  out.motion.hand_targets.select(2, 1).add_(floor * out.motion.hand_targets.select(2, 3));
  if (!options.standard && out.motion.frames() > 1)
    out.on_source = going_on(start, start.frames(), slice(out.motion, 0, 1), slice(out.motion, 1, out.motion.frames()));
  return out;
}

}  // namespace inhabit::interact
