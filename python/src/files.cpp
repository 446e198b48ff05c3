#include "inhabit/io/files.h"

#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/convert_files.h"
#include "inhabit/io/describe.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"

namespace inhabit::python {
namespace {

using Text = std::optional<std::string>;
using Number = std::optional<double>;

/// `read(path, options, notes)` with what Python says about the file, notes to the log with its name.
template <class Read>
auto read_with(const Path& path, ClipReadOptions options, const BodyModel* body, const Read& read) {
  Notes own, notes;
  options.body = body;
  auto out = released([&] { return read(path.string(), options, &own); });
  add_notes(notes, std::move(own), path.string());
  say(notes);
  return out;
}

Scene read_scene(const Path& path, const Text& up, Number scale) {
  SceneReadOptions options;
  options.up = up_axis(up);
  options.scale = scale;
  if (scale && !(*scale > 0 && *scale < 1e12)) throw Error("scale", "is not a number over 0");
  SceneFile read = released([&] { return read_scene_file(path.string(), options); });
  if (read.report.up_detected || read.report.scale_detected) say({path.string() + ": " + describe(read.report)});
  read.scene.name = path.string();
  return std::move(read.scene);
}

constexpr const char* kReading =
    "\n\nup: 'y' or 'z', scale: metres per unit, rate: frames a second, whatever the file says (each is detected or "
    "read\n"
    "where it is left out); asf: skeleton of an .amc (else the .asf beside it); body: the Body of an SMPL-family "
    "file;\n"
    "level: the floor under the feet is made level.\n"
    "What was detected is logged to logging.getLogger('inhabit').";

WriteOptions writing_of(double start, Number end, Number rate, bool loop, const Text& up) {
  if (rate && !(*rate >= 0.1 && *rate <= 1000)) throw Error("rate", "is not in [0.1, 1000]");
  if (!(start >= 0)) throw Error("start", "is under 0");
  return {start, end, loop, rate.value_or(0), up_axis(up)};
}

ConvertOptions converting_of(const ClipReadOptions& reading, const WriteOptions& writing, bool retarget,
                             const std::optional<Path>& scene, const std::optional<Path>& body) {
  return {reading, writing, retarget, scene ? scene->string() : "", body ? body->string() : ""};
}

constexpr const char* kWriting =
    "\n\nstart, end: seconds of the clip between which it is written; rate: frames a second of the file; loop: its end "
    "is mixed\n"
    "into its start, so that it can be repeated; up: 'z' for .bvh and .npz.";

}  // namespace

void add_files(py::module_& m) {
  static const std::string write_clip_doc =
      std::string(
          "Writes a motion as its extension says: .npz, .json, .bvh or .glb; only a .glb holds the scene. A clip "
          "of positions\nalone is fitted first for .bvh and .glb.") +
      kWriting;
  static const std::string write_clips_doc =
      std::string(
          "Writes several motions of one person, of equal length, to one .npz, or to a file each: NAME_000.bvh "
          "...") +
      kWriting;
  static const std::string read_clip_doc =
      std::string(
          "A motion from any file inhabit reads: .bvh .fbx .dae .glb .gltf .amc .txt .npz .npy .json, on "
          "the\nfile's own skeleton.") +
      kReading;
  m.def(
      "read_clip",
      [](const Path& path, const Text& up, Number scale, Number rate, const std::optional<Path>& asf,
         const BodyModel* body, bool level) {
        return read_with(path, reading_of(up, scale, rate, asf, level), body,
                         [](const auto&... given) { return read_clip(given...); });
      },
      "path"_a, py::kw_only(), "up"_a = py::none(), "scale"_a = py::none(), "rate"_a = py::none(), "asf"_a = py::none(),
      "body"_a = py::none(), "level"_a = false, read_clip_doc.c_str());
  m.def(
      "read_clips",
      [](const Path& path, const Text& up, Number scale, Number rate, const std::optional<Path>& asf,
         const BodyModel* body, bool level) {
        return read_with(path, reading_of(up, scale, rate, asf, level), body,
                         [](const auto&... given) { return read_clips(given...); });
      },
      "path"_a, py::kw_only(), "up"_a = py::none(), "scale"_a = py::none(), "rate"_a = py::none(), "asf"_a = py::none(),
      "body"_a = py::none(), "level"_a = false,
      "Every motion of a file: the one that read_clip gives, or the samples of an .npz of futures.");
  m.def(
      "write_clip",
      [](const Path& path, const Clip& clip, const std::optional<Scene>& scene, double start, Number end, Number rate,
         bool loop, const Text& up) {
        const WriteOptions writing = writing_of(start, end, rate, loop, up);
        released([&, clip] { write_clips(path.string(), {clip}, writing, {}, scene ? &*scene : nullptr); });
      },
      "path"_a, "clip"_a, "scene"_a = py::none(), py::kw_only(), "start"_a = 0.0, "end"_a = py::none(),
      "rate"_a = py::none(), "loop"_a = false, "up"_a = py::none(), write_clip_doc.c_str());
  m.def(
      "write_clips",
      [](const Path& path, const std::vector<Clip>& clips, double start, Number end, Number rate, bool loop,
         const Text& up) {
        if (clips.empty()) throw Error(path.string(), "no motion to write");
        const WriteOptions writing = writing_of(start, end, rate, loop, up);
        released([&] { write_clips(path.string(), clips, writing); });
      },
      "path"_a, "clips"_a, py::kw_only(), "start"_a = 0.0, "end"_a = py::none(), "rate"_a = py::none(),
      "loop"_a = false, "up"_a = py::none(), write_clips_doc.c_str());
  m.def("read_scene", &read_scene, "path"_a, py::kw_only(), "up"_a = py::none(), "scale"_a = py::none(),
        "A scene from a mesh (.obj .ply .glb .gltf .off .stl) or a point cloud (.ply .pcd .xyz .npz .npy), in metres "
        "with\n"
        "+Y up. up: 'y' or 'z', scale: metres per unit; both are detected where they are left out, and logged to\n"
        "logging.getLogger('inhabit').");
  m.def(
      "write_scene",
      [](const Path& path, const Scene& scene) { released([&, scene] { write_scene(path.string(), scene); }); },
      "path"_a, "scene"_a,
      "Writes a scene as .glb (meshes with names and colours, points) or .ply (one mesh, or points).");
  m.def(
      "convert",
      [](const Path& source, const Path& target, Number rate, bool retarget, const Text& up, Number scale,
         Number input_rate, const std::optional<Path>& asf, const Text& out_up, const std::optional<Path>& scene,
         const std::optional<Path>& body, double start, Number end, bool loop, bool level) {
        const ConvertOptions options = converting_of(reading_of(up, scale, input_rate, asf, level),
                                                     writing_of(start, end, rate, loop, out_up), retarget, scene, body);
        Notes notes;
        const std::string written =
            released([&] { return convert_file(source.string(), target.string(), options, &notes); });
        say(notes);
        return written;
      },
      "source"_a, "target"_a, py::kw_only(), "rate"_a = py::none(), "retarget"_a = false, "up"_a = py::none(),
      "scale"_a = py::none(), "input_rate"_a = py::none(), "asf"_a = py::none(), "out_up"_a = py::none(),
      "scene"_a = py::none(), "body"_a = py::none(), "start"_a = 0.0, "end"_a = py::none(), "loop"_a = false,
      "level"_a = false,
      "Writes a motion or a scene in another format, told by the extensions; returns a line that says what was "
      "written.\n"
      "rate: frames a second of the output; retarget: onto the standard 22 joints; out_up: 'z' for .bvh and .npz, else "
      "+Y up;\n"
      "scene: a file to put into a .glb beside the motion; body: SMPL-family model file (.npz). start, end, loop: as "
      "write_clip\n"
      "has them; up, scale, input_rate, asf, level: how the motion is read, as read_clip has them.");
  m.def(
      "convert_files",
      [](const PathsArgument& sources, const Path& folder, const std::string& format, Number rate, bool retarget,
         const Text& up, Number scale, Number input_rate, const std::optional<Path>& asf, const Text& out_up,
         const std::optional<Path>& scene, const std::optional<Path>& body, double start, Number end, bool loop,
         bool level, const py::object& progress) {
        const ConvertOptions options = converting_of(reading_of(up, scale, input_rate, asf, level),
                                                     writing_of(start, end, rate, loop, out_up), retarget, scene, body);
        const Progress told = progress_of(progress);
        Notes notes;
        std::vector<Path> written;
        FileCount count = released([&] {
          return convert_files(
              texts_of(sources), folder.string(), format, options,
              [&](const std::string& file, const std::string& /*line*/) { written.emplace_back(file); }, &notes, told);
        });
        say(notes);
        return std::pair(std::move(written), std::move(count.skipped));
      },
      "sources"_a, "folder"_a, py::kw_only(), "format"_a = "npz", "rate"_a = py::none(), "retarget"_a = false,
      "up"_a = py::none(), "scale"_a = py::none(), "input_rate"_a = py::none(), "asf"_a = py::none(),
      "out_up"_a = py::none(), "scene"_a = py::none(), "body"_a = py::none(), "start"_a = 0.0, "end"_a = py::none(),
      "loop"_a = false, "level"_a = false, "progress"_a = py::none(),
      "Writes files, all motion of folders (of 'ply' their scenes) and patterns, each as a file of the same name in "
      "`folder`.\n"
      "format: 'npz', 'json', 'bvh', 'glb' or 'ply'; the rest as convert has it. progress(done, all) is called after "
      "each file.\n"
      "Returns the files that were written, and why others were skipped, a list of lines.");
  m.def(
      "info",
      [](const Path& path, const Text& up, Number scale, Number rate, const std::optional<Path>& asf, bool level) {
        const ClipReadOptions options = reading_of(up, scale, rate, asf, level);
        const std::string facts = released([&] {
          return describe_file(path.string(), options).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        });
        return python_of(facts).cast<py::dict>();
      },
      "path"_a, py::kw_only(), "up"_a = py::none(), "scale"_a = py::none(), "rate"_a = py::none(), "asf"_a = py::none(),
      "level"_a = false,
      "What a motion, scene, model or data set holds, as a dictionary: lengths in metres, times in seconds. up, scale, "
      "rate,\n"
      "asf, level: how the file is read, as read_clip has them.");
}

}  // namespace inhabit::python
