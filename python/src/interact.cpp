#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/interact/contact_area.h"
#include "results.h"

namespace inhabit::python {
namespace {

using interact::Chair;
using interact::ChairInteractor;
using interact::HandContacts;

/// A part of the chair by name, a point in metres, or none.
using HandContactArgument = std::variant<std::monostate, std::string, Point>;
using HandsArgument = std::pair<HandContactArgument, HandContactArgument>;

std::vector<HandContacts> series_of(const std::vector<HandsArgument>& given, const Chair& chair) {
  const auto contact_of = [&](const HandContactArgument& hand, int side) {
    interact::ContactPlace place;
    if (const auto* area = std::get_if<std::string>(&hand)) place = *area;
    if (const auto* p = std::get_if<Point>(&hand)) place = Eigen::Vector3d((*p)[0], (*p)[1], (*p)[2]);
    return interact::contact_at(chair, place, side);
  };
  std::vector<HandContacts> out;
  for (const auto& [left, right] : given) out.push_back({contact_of(left, 0), contact_of(right, 1)});
  return out;
}

std::vector<HandPoints> python_contacts(const std::vector<HandContacts>& of) {
  const auto point = [](const std::optional<Eigen::Vector3d>& p) {
    return p ? std::optional(Point{p->x(), p->y(), p->z()}) : std::nullopt;
  };
  std::vector<HandPoints> out;
  for (const HandContacts& c : of) out.emplace_back(point(c[0]), point(c[1]));
  return out;
}

void add_chair(py::module_& m) {
  py::class_<Chair>(m, "Chair", "Something to sit on, and how one sits on it.")
      .def_readonly("name", &Chair::name, "Name of the object, 'armchair_0'.")
      .def_readonly("mesh", &Chair::mesh, "Its Mesh, world, metres.")
      .def_readonly("seat_height", &Chair::seat_height, "Metres over the floor.")
      .def_property_readonly("heading", &Chair::heading, "Of a seated person, radians from +Z towards +X.")
      .def_property_readonly(
          "seat",
          [](const Chair& c) {
            const Eigen::Vector3d s = c.seat();
            return Point{s.x(), s.y(), s.z()};
          },
          "(x, y, z) metres: where the pelvis comes to rest.")
      .def(
          "contact",
          [](const Chair& chair, const std::string& area, const std::string& hand) {
            if (hand != "left" && hand != "right")
              throw Error("hand", "is '" + hand + "', which is none of left, right");
            const Eigen::Vector3d p = interact::contact_on(chair, area, hand == "left" ? 0 : 1);
            return Point{p.x(), p.y(), p.z()};
          },
          "area"_a, "hand"_a,
          "(x, y, z) metres: a point on 'armrest', 'front', 'side' or 'back' for the 'left' or 'right' hand.")
      .def("__repr__", [](const Chair& c) { return "<inhabit.Chair '" + c.name + "'>"; });
  m.def(
      "find_chairs", [](const Scene& scene) { return released([scene] { return interact::find_chairs(scene); }); },
      "scene"_a, "All that can be sat on in a scene: seats of 0.3 to 0.6 m.");
  m.def(
      "standing_clip",
      [](double x, double z, double heading, const std::optional<Floats>& betas) {
        return interact::standing_clip({x, z}, heading, betas ? torch::Tensor(*betas) : torch::Tensor());
      },
      "x"_a, "z"_a, "heading"_a = 0.0, "betas"_a = py::none(),
      "A person who stands with hanging arms at (x, z) on the floor y = 0: a Clip of one frame. heading: radians from "
      "+Z\n"
      "towards +X.");
}

void add_result(py::module_& m) {
  py::class_<InteractResult>(m, "InteractResult", "What Interactor.run returns.")
      .def_property_readonly(
          "clip", [](const InteractResult& r) { return r.result.motion; },
          "The motion, a Clip on the standard skeleton, 30 Hz, from the pose that was given on.")
      .def_property_readonly(
          "on_source", [](const InteractResult& r) { return r.result.on_source; },
          "What follows on the start on its own skeleton, at its rate; empty where standard=True.")
      .def_property_readonly(
          "chair", [](const InteractResult& r) { return r.result.chair; }, "The Chair that was sat on.")
      .def_property_readonly(
          "scene", [](const InteractResult& r) { return r.scene; }, "The scene that was given.")
      .def_property_readonly(
          "contacts", [](const InteractResult& r) { return python_contacts(r.result.contacts); },
          "Contacts that were reached for, on the surface: pairs (left, right) of (x, y, z) metres or None.")
      .def_property_readonly(
          "contact_error",
          [](const InteractResult& r) {
            std::vector<std::pair<std::optional<double>, std::optional<double>>> out;
            for (const auto& e : r.result.contact_error) out.emplace_back(e[0], e[1]);
            return out;
          },
          "Pairs (left, right), metres: the palm's closest approach to each contact, None without one.")
      .def_property_readonly(
          "seated", [](const InteractResult& r) { return r.result.seated; },
          "First frame from which the person sits, to the end or until they leave; None where they do not.")
      .def_property_readonly("samples", &samples_of<InteractResult>,
                             "All motions that were asked for, of which this is the first: a list for page().");
}

constexpr const char* kInteractRun =
    "Walks from the last frame of `start` (a Clip on any skeleton that maps to the standard one, see standing_clip; "
    "None:\n"
    "somebody who stands 2 m before the chair) to a chair of the scene and sits down, the hands where they are "
    "wanted.\n\n"
    "chair: object of the scene; left out, its only or nearest seat. sit_at: (x, y, z, heading), metres and radians, "
    "any\n"
    "place to sit on instead.\n"
    "contacts: pairs (left, right), one after the other; each hand a part of the chair ('armrest', 'front', 'side',\n"
    "'back'), a point (x, y, z) in metres, or None. draw_contacts: ContactNet draws them from `seed`. samples: so "
    "many\n"
    "motions, with seeds from `seed` on: `samples` of the result.\n"
    "hold: seconds that hands stay at each of the contacts; math.inf: at the last to the end.\n"
    "then_walk: (x, z, heading): where they walk in the end. seconds: length of the motion.\n"
    "raw: the motion before does not fade in, and nothing is fitted to contacts and scene; straight: no route\n"
    "is planned around what stands in the way; force: seats and contacts out of reach are tried all the same. "
    "standard: on_source is not wanted. name: what errors call the "
    "start.";

}  // namespace

void add_interact(py::module_& m) {
  add_chair(m);
  add_result(m);
  py::class_<ChairInteractor>(
      m, "Interactor",
      "Controllable human-chair interaction: a person, a chair and where the hands are to go in,\n"
      "motion out. Safe to use from several threads.")
      .def(py::init([](const std::optional<Path>& model) {
             const std::string file = model_file(model, "interact-compact.safetensors");
             return released([&] { return std::make_unique<ChairInteractor>(ChairInteractor::load(file)); });
           }),
           "model"_a = py::none(), "model: a model file; left out, the one that ships.")
      .def_property_readonly(
          "config", [](const ChairInteractor& i) { return python_of(to_json(i.config())).cast<py::dict>(); },
          "The model's configuration.")
      .def(
          "run",
          [](const ChairInteractor& interactor, const std::optional<Clip>& given, const Scene& scene,
             const std::string& chair, const std::optional<std::array<double, 4>>& sit_at,
             const std::vector<HandsArgument>& contacts, double hold, bool draw_contacts,
             const std::optional<Point>& then_walk, double seconds, uint64_t seed, int64_t samples, bool raw,
             bool straight, bool force, bool standard, const std::string& name) {
            interact::Options options;
            options.chair = chair;
            if (sit_at) options.sit_at = Eigen::Vector4d((*sit_at)[0], (*sit_at)[1], (*sit_at)[2], (*sit_at)[3]);
            options.hold = hold;
            options.draw_contacts = draw_contacts;
            options.raw = raw;
            options.straight = straight;
            options.force = force;
            if (then_walk) options.then_walk = Eigen::Vector3d((*then_walk)[0], (*then_walk)[1], (*then_walk)[2]);
            options.standard = standard;
            options.seconds = seconds;
            options.seed = seed;
            options.name = name;
            std::vector<InteractResult> all;
            for (interact::Result& one : released([&, start = given.value_or(Clip()), scene] {
                   if (!contacts.empty())
                     options.contacts = series_of(contacts, interactor.chair_of(start, scene, options));
                   return interactor.run_samples(start, scene, options, samples);
                 }))
              all.push_back({std::move(one), scene, {}});
            return first_of(std::move(all));
          },
          "start"_a, "scene"_a, py::kw_only(), "chair"_a = "", "sit_at"_a = py::none(),
          "contacts"_a = std::vector<HandsArgument>(), "hold"_a = interact::kHold, "draw_contacts"_a = false,
          "then_walk"_a = py::none(), "seconds"_a = 16.0, "seed"_a = 1, "samples"_a = 1, "raw"_a = false,
          "straight"_a = false, "force"_a = false, "standard"_a = false, "name"_a = "start", kInteractRun)
      .def(
          "chair_of",
          [](const ChairInteractor& interactor, const Scene& scene, const std::string& chair,
             const std::optional<Clip>& start, bool force) {
            interact::Options options;
            options.chair = chair;
            options.force = force;
            return released(
                [&, from = start.value_or(Clip()), scene] { return interactor.chair_of(from, scene, options); });
          },
          "scene"_a, "chair"_a = "", py::kw_only(), "start"_a = py::none(), "force"_a = false,
          "The Chair that run sits down on. chair: object of the scene; left out, its only or nearest seat, from the "
          "last frame\n"
          "of `start` or the scene's origin. force: seats of any height.")
      .def(
          "draw_contacts",
          [](const ChairInteractor& interactor, const Chair& chair, int64_t count, uint64_t seed) {
            return python_contacts(released([&] { return interactor.draw_contacts(chair, count, seed); }));
          },
          "chair"_a, "count"_a = 10, "seed"_a = 1,
          "Contacts that ContactNet proposes on a chair: `count` pairs (left, right) of (x, y, z) metres or None.");
}

}  // namespace inhabit::python
