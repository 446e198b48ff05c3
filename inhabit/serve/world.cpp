#include "inhabit/serve/world.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/interact/standing_place.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/bounding_box.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/objects.h"
#include "inhabit/synth/room.h"

namespace inhabit::serve {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using torch::Tensor;

constexpr double kFarthestPlace = 1000;  // metres: scenes beyond are cut off there

/// The height of what people stand on: below the seats, else the top of the floor's lowest mesh, else the lowest point.
double floor_of(const Scene& scene, double lowest) {
  const std::vector<interact::Chair> chairs = interact::find_chairs(scene);
  if (!chairs.empty()) return chairs.front().frame.translation().y();
  double floor = HUGE_VAL;
  for (const Mesh& mesh : scene.meshes)
    if (is_floor(mesh.name) && mesh.vertices.numel() > 0)
      floor = std::min(floor, mesh.vertices.select(1, 1).max().item<double>());
  return floor < HUGE_VAL ? floor : lowest;
}

/// Somebody at the free place that is nearest to 2 m before the first seat, or to the middle, and looks at it.
Clip first_pose(const World& world) {
  const Vector2d middle = 0.5 * (world.low + world.high);
  Vector2d wanted = middle, seen = middle;
  if (!world.seats.empty()) {
    const interact::Chair& chair = world.seats.front().chair;
    seen = on_ground(chair.seat());
    wanted = seen + 2 * ahead_of(chair.heading());
  }
  const auto place = interact::nearest_free(wanted, [&](const Vector2d& at) { return world.free_at(at); });
  if (!place) throw Error(world.scene.name.empty() ? "scene" : world.scene.name, "has no free floor to stand on");
  const Vector2d to = seen - *place;
  return interact::standing_clip(*place, to.norm() > 0.1 ? heading_of(to) : 0);
}

std::shared_ptr<World> world_of(const Scene& scene, interact::ChairInteractor interactor) {
  const Eigen::AlignedBox3d box = bounding_box(scene);
  if (box.isEmpty()) throw Error(scene.name.empty() ? "scene" : scene.name, "is empty");
  const Scene there = raised(scene, -floor_of(scene, box.min().y()));
  const auto cut = [](double x) { return std::clamp(x, -kFarthestPlace, kFarthestPlace); };
  auto world = std::make_shared<World>(World{there,
                                             std::make_shared<const interact::Surroundings>(there),
                                             {},
                                             std::move(interactor),
                                             {},
                                             {},
                                             {},
                                             {},
                                             {cut(box.min().x()), cut(box.min().z())},
                                             {cut(box.max().x()), cut(box.max().z())},
                                             {}});
  for (const interact::Chair& chair : interact::find_chairs(there))
    world->seats.push_back({chair, SceneQuery(Scene{chair.name, {chair.mesh}, {}})});
  world->person = first_pose(*world);
  // What is only computed when it is first needed, so that nobody waits for it later.
  interact::LivePerson first(world->interactor.engine(), world->person);
  for (const Seat& seat : world->seats) first.sit_on(seat.chair, world->around, {});
  first.step();
  world->preparation = std::jthread([around = world->around](const std::stop_token& stop) {
    around->prepare([&] { return stop.stop_requested(); });
  });
  return world;
}

}  // namespace

const Seat& World::seat(const std::string& name) const {
  std::string names;
  for (const Seat& seat : seats) {
    if (seat.chair.name == name) return seat;
    names += (names.empty() ? "" : ", ") + seat.chair.name;
  }
  throw Error(name.substr(0, 60),
              names.empty() ? "cannot be sat on: nothing here can" : "cannot be sat on; there are " + names);
}

bool World::free_at(const Vector2d& place) const {
  if ((place.array() < low.array()).any() || (place.array() > high.array()).any()) return false;
  return interact::room_to_stand(*around, place);
}

Scene default_room() {
  Room room;
  room.size = {6, 5.4};
  std::mt19937_64 random(4);
  std::vector<Furniture>& all = room.furniture;
  all = {make_armchair(random), make_chair(random), make_sofa(random, 2), make_stool(random)};
  all[0].place(-1.2, -1.4, 0.35);
  all[1].place(1.5, -1.5, -0.3);
  all[2].place(-2.2, 1.2, 1.5708);
  all[3].place(1.9, 0.9, -1.2);
  Scene scene = room.scene();
  scene.name = "A room with four seats";
  return scene;
}

ModelFiles with_shipped(ModelFiles given) {
  given.interact = model_file(given.interact, "interact-compact.safetensors");
  const auto find = [](std::string& file, const char* shipped) {
    const bool wanted = !file.empty();
    try {
      file = model_file(file, shipped);
    } catch (const Error&) {
      if (wanted) throw;
    }
  };
  find(given.forecast, "forecast-compact.safetensors");
  find(given.inbetween, "inbetween-compact.safetensors");
  find(given.anticipate, "anticipate-cmu.safetensors");
  return given;
}

std::shared_ptr<const World> make_world(const Scene& scene, const ModelFiles& models) {
  const std::shared_ptr<World> world = world_of(scene, interact::ChairInteractor::load(models.interact));
  if (!models.forecast.empty()) world->forecaster.emplace(forecast::ContactForecaster::load(models.forecast));
  if (!models.inbetween.empty()) world->inbetweener.emplace(inbetween::SceneInbetweener::load(models.inbetween));
  if (!models.anticipate.empty()) world->anticipator.emplace(anticipate::IntentionAnticipator::load(models.anticipate));
  return world;
}

std::shared_ptr<const World> make_world(const Scene& scene, interact::ChairInteractor interactor) {
  return world_of(scene, std::move(interactor));
}

}  // namespace inhabit::serve
