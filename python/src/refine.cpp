#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/io/cloud_sequence.h"
#include "inhabit/refine/refine_depth.h"
#include "results.h"

namespace inhabit::python {
namespace {

/// Clouds in memory (a list of (N, 3)), or those of a folder or file.
using CloudsArgument = std::variant<Path, std::vector<Floats>>;

CloudSequence clouds_of(const CloudsArgument& given, const CloudReadOptions& reading) {
  if (const auto* path = std::get_if<Path>(&given)) return open_clouds(path->string(), reading);
  const auto& clouds = std::get<std::vector<Floats>>(given);
  for (const Floats& cloud : clouds) {
    if (cloud.dim() != 2 || cloud.size(1) != 3 || cloud.size(0) == 0)
      throw Error("clouds", "are not (N, 3) each, N > 0");
    if (!torch::isfinite(cloud).all().item<bool>()) throw Error("clouds", "have a value that is not finite");
  }
  return {"clouds", static_cast<int64_t>(clouds.size()),
          [clouds](int64_t frame) { return torch::Tensor(clouds.at(static_cast<size_t>(frame))); }};
}

constexpr const char* kRefine =
    "A clean motion from a noisy or sliding one: smooth as far as it is noisy, feet that stand where they are in "
    "contact,\n"
    "no joint beyond its limits, nobody inside the scene.\n\n"
    "scene: left out, a flat floor is assumed under the feet. contacts: feet are kept in place while they stand;\n"
    "hands: and hands while they rest on the scene.\n"
    "keep: frames ('0,60,90', 'every:60') that come out as they are and standard joints ('left_wrist') that are kept "
    "in\n"
    "place, mixed as one likes. smooth: factor on how smooth the motion is, 0: contacts alone. generated: a network "
    "made\n"
    "the motion, whose poses are believed less closely. standard: on_source is not wanted. name: what errors call the "
    "clip.";

}  // namespace

void add_refine(py::module_& m) {
  py::class_<RefineResult>(m, "RefineResult", "What refine() returns.")
      .def_property_readonly(
          "before", [](const RefineResult& r) { return r.result.before; },
          "The motion as it was, on the standard skeleton.")
      .def_property_readonly(
          "clip", [](const RefineResult& r) { return r.result.clip; },
          "The refined motion, a Clip on the standard skeleton, at the motion's own rate.")
      .def_property_readonly(
          "on_source", [](const RefineResult& r) { return r.result.on_source; },
          "The same on the clip's own skeleton, kept frames bit by bit; empty where standard=True.")
      .def_property_readonly(
          "scene", [](const RefineResult& r) { return r.scene; }, "The scene that was given.")
      .def_property_readonly(
          "noise_rotations", [](const RefineResult& r) { return r.result.noise_rotations; },
          "Radians, median over the joints: white noise found in the motion.")
      .def_property_readonly(
          "noise_root", [](const RefineResult& r) { return r.result.noise_root; }, "Metres: the same of the root.")
      .def_property_readonly(
          "contacts", [](const RefineResult& r) { return r.result.contacts; },
          "Number of contacts of balls of the feet and heels.")
      .def_property_readonly(
          "hands",
          [](const RefineResult& r) {
            py::list out;
            for (const refine::GivenContact& hand : r.result.hands) {
              const Eigen::Vector3d& p = hand.place;
              out.append(py::dict("side"_a = hand.joint - 20, "first"_a = hand.first, "last"_a = hand.last,
                                  "place"_a = std::vector<double>{p.x(), p.y(), p.z()}));
            }
            return out;
          },
          "Contacts of palms with the scene, a dictionary each: side (0 left, 1 right), frames first to last, place in "
          "metres.")
      .def_property_readonly(
          "moved", [](const RefineResult& r) { return r.result.moved; },
          "Metres, mean distance of the joints from where they were.");
  m.def(
      "refine",
      [](const Clip& clip, const std::optional<Scene>& scene, bool contacts, bool hands, const std::string& keep,
         double smooth, bool generated, bool standard, const std::string& name) {
        refine::Options options;
        options.contacts = contacts;
        options.hands = hands;
        options.smooth = smooth;
        options.generated = generated;
        options.name = name;
        options.standard = standard;
        if (!keep.empty()) refine::add_kept(keep, clip, options);
        const Scene there = scene.value_or(Scene());
        return RefineResult{released([&, clip] { return refine::refine(clip, there, options); }), there};
      },
      "clip"_a, "scene"_a = py::none(), py::kw_only(), "contacts"_a = true, "hands"_a = true, "keep"_a = "",
      "smooth"_a = 1.0, "generated"_a = false, "standard"_a = false, "name"_a = "motion", kRefine);

  py::class_<refine::DepthResult>(m, "DepthResult", "What refine_to_depth() returns.")
      .def_readonly("before", &refine::DepthResult::before, "The motion as it was, on the standard skeleton.")
      .def_readonly("clip", &refine::DepthResult::clip, "The fitted motion, a Clip on the standard skeleton.")
      .def_readonly("on_source", &refine::DepthResult::on_source,
                    "The same on the clip's own skeleton; empty where standard=True.")
      .def_readonly("distance_before", &refine::DepthResult::distance_before,
                    "Metres from the points to the skin, median of the frames' medians, before.")
      .def_readonly("distance_after", &refine::DepthResult::distance_after, "The same after.")
      .def_readonly("moved", &refine::DepthResult::moved, "Metres, mean distance of the joints from where they were.");
  m.def(
      "refine_to_depth",
      [](const Clip& clip, const CloudsArgument& clouds, const BodyModel* body, const std::optional<Point>& camera,
         double scale, const std::optional<std::string>& up, double smooth, int64_t window, int64_t points,
         bool standard, const std::string& name) {
        if (!(scale > 0 && scale < 1e12)) throw Error("scale", "is not a number over 0");
        refine::DepthOptions options;
        options.body = body;
        if (camera) options.camera = Eigen::Vector3d((*camera)[0], (*camera)[1], (*camera)[2]);
        options.smooth = smooth;
        options.window = window;
        options.points = points;
        options.name = name;
        options.standard = standard;
        const CloudReadOptions reading = {scale, up_axis(up) == UpAxis::z};
        return released([&, clip] { return refine::refine_to_depth(clip, clouds_of(clouds, reading), options); });
      },
      "clip"_a, "clouds"_a, py::kw_only(), "body"_a = py::none(), "camera"_a = py::none(), "scale"_a = 1.0,
      "up"_a = py::none(), "smooth"_a = 1.0, "window"_a = 120, "points"_a = 400, "standard"_a = false,
      "name"_a = "motion",
      "A motion that fits what a depth camera saw of the person (forecasting paper, appendix A.1.2).\n\n"
      "clouds: a list of (N, 3) metres, one a frame, in the clip's world, or a folder or file of them. scale: metres "
      "per unit of\n"
      "a file's points (0.001: millimetres); up: 'z' where they are of a file whose motion was +Z up. body: whose skin "
      "was\n"
      "seen. camera: (x, y, z) metres, +Y up, where it stands. smooth: factor on the priors. window: frames solved at "
      "once.\n"
      "points: of each cloud that are pulled to the skin.");
}

}  // namespace inhabit::python
