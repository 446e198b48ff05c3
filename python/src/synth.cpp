#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/interact/reseat_set.h"
#include "inhabit/synth/chairs.h"
#include "inhabit/synth/check.h"
#include "inhabit/synth/fit.h"
#include "inhabit/synth/generate.h"

namespace inhabit::python {
namespace {

using Files = std::vector<Path>;

/// Opens as Python's Dataset what was made.
py::object opened(const Path& folder) { return py::module_::import("inhabit").attr("Dataset")(folder); }
/// None where other shards are still to come: there is no index yet.
py::object opened(const Path& folder, const Dataset& made) { return made.whole ? opened(folder) : py::none(); }

constexpr const char* kShard =
    "\nshard: (I, N) for part I of N, for several processes that write one folder; the last of them writes the index. "
    "Returns\n"
    "the Dataset, or None where other shards are still to come.";

std::string documented(const std::string& text, const char* more) { return text + more; }

Path reseat(const Path& data, const Path& folder, const std::variant<std::string, Files>& chairs,
            const std::string& split, bool frame_by_frame, uint64_t seed, const py::object& progress) {
  interact::ReseatOptions options;
  if (const auto* kind = std::get_if<std::string>(&chairs)) {
    if (*kind != "procedural" && *kind != "rescaled")
      throw Error("chairs", "is '" + *kind + "', which is none of procedural, rescaled, and no list of files");
    options.chairs = *kind == "procedural" ? interact::NewChairs::procedural : interact::NewChairs::rescaled;
  } else {
    options.chairs = interact::NewChairs::files;
    options.files = texts_of(std::get<Files>(chairs));
  }
  options.split = split;
  options.frame_by_frame = frame_by_frame;
  options.seed = seed;
  options.progress = progress_of(progress);
  const auto made = released([&] { return interact::reseat_dataset(data.string(), folder.string(), options); });
  say({summary(made)});
  return folder;
}

}  // namespace

void add_synth(py::module_& m) {
  m.def(
      "synth_rooms",
      [](const Path& folder, int64_t clips, uint64_t seed, double seconds, int clips_per_room, double on_chord,
         const ShardArgument& shard, const py::object& progress) {
        GenerateOptions options;
        options.clips = clips;
        options.seed = seed;
        options.seconds = seconds;
        options.clips_per_room = clips_per_room;
        options.chords.tried = on_chord;
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        return opened(folder, released([&] { return generate_rooms(folder.string(), options); }));
      },
      "folder"_a, py::kw_only(), "clips"_a = 100, "seed"_a = 1, "seconds"_a = 12.0, "clips_per_room"_a = 4,
      "on_chord"_a = 0.0, "shard"_a = py::none(), "progress"_a = py::none(),
      documented(
          "A data set of people who live in made-up rooms, in `folder`; the same seed gives the same bytes. seconds: "
          "length of\n"
          "each clip. on_chord: fraction of straight lines between poses that furniture is tried on. progress(done, "
          "all) "
          "is "
          "called\n"
          "after each clip.",
          kShard)
          .c_str());
  m.def(
      "synth_chairs",
      [](const Path& folder, double minutes, int subjects, int64_t chairs, std::vector<std::string> kinds,
         uint64_t seed, const ShardArgument& shard, const py::object& progress) {
        ChairsOptions options;
        options.minutes = minutes;
        options.subjects = subjects;
        options.chairs = chairs;
        options.kinds = std::move(kinds);
        options.seed = seed;
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        return opened(folder, released([&] { return generate_chairs(folder.string(), options); }));
      },
      "folder"_a, py::kw_only(), "minutes"_a = 180.0, "subjects"_a = 6, "chairs"_a = 240,
      "kinds"_a = std::vector<std::string>(), "seed"_a = 1, "shard"_a = py::none(), "progress"_a = py::none(),
      documented("A data set of people who walk up to chairs and sit on them, in `folder`. kinds: of chairs, such as\n"
                 "['sofa', 'bed']; empty: all. progress(done, all) is called after each clip.",
                 kShard)
          .c_str());
  m.def(
      "synth_fit",
      [](const Path& folder, const Files& train, const Files& val, const Files& test, int rooms_per_clip,
         double seconds, bool mirrored, double stretches, double on_chord, bool only_on_chord, uint64_t seed,
         const std::optional<std::string>& up, std::optional<double> scale, std::optional<double> rate, bool level,
         const ShardArgument& shard, const py::object& progress) {
        FittingOptions options;
        options.train = texts_of(train);
        options.val = texts_of(val);
        options.test = texts_of(test);
        options.rooms_per_clip = rooms_per_clip;
        options.seconds = seconds;
        options.mirrored = mirrored;
        options.stretches = stretches;
        options.chords.tried = on_chord;
        options.only_on_chords = only_on_chord;
        options.seed = seed;
        options.reading = reading_of(up, scale, rate, std::nullopt, level);
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        return opened(folder, released([&] { return fit_recordings(folder.string(), options); }));
      },
      "folder"_a, "train"_a, py::kw_only(), "val"_a = Files(), "test"_a = Files(), "rooms_per_clip"_a = 3,
      "seconds"_a = 12.0, "mirrored"_a = true, "stretches"_a = 0.5, "on_chord"_a = ChordOptions().tried,
      "only_on_chord"_a = false, "seed"_a = 1, "up"_a = py::none(), "scale"_a = py::none(), "rate"_a = py::none(),
      "level"_a = false, "shard"_a = py::none(), "progress"_a = py::none(),
      documented(
          "A data set of rooms fitted around recorded motion, in `folder`. train, val, test: motion files. seconds: "
          "longest piece\n"
          "of a recording. mirrored: every second room of training is around the mirror image. up, scale, rate, level: "
          "how the "
          "files\n"
          "are read. progress(done, all) is called after each recording.",
          kShard)
          .c_str());
  m.def(
      "synth_reseat",
      [](const Path& data, const Path& folder, const std::variant<std::string, Files>& chairs, const std::string& split,
         bool frame_by_frame, uint64_t seed, const py::object& progress) {
        return opened(reseat(data, folder, chairs, split, frame_by_frame, seed, progress));
      },
      "data"_a, "folder"_a, py::kw_only(), "chairs"_a = "procedural", "split"_a = "train", "frame_by_frame"_a = false,
      "seed"_a = 1, "progress"_a = py::none(),
      "The clips of a data set in which somebody sits, carried over to other chairs, as a data set in `folder`. "
      "chairs:\n"
      "'procedural', 'rescaled', or a list of files of a chair each. Returns the Dataset; what was left out is "
      "logged.");
  py::class_<Bar>(m, "Bar", "One measure of a data set's motion and the range it must lie in.")
      .def_readonly("name", &Bar::name, "What is measured.")
      .def_readonly("unit", &Bar::unit, "Its unit.")
      .def_readonly("low", &Bar::low, "Lowest value that passes.")
      .def_readonly("high", &Bar::high, "Highest value that passes.")
      .def_readonly("value", &Bar::value, "Over the whole data set.")
      .def_readonly("clips", &Bar::clips, "Clips that it could be measured on.")
      .def_readonly("worst_clip", &Bar::worst_clip, "File of the clip farthest out.")
      .def_readonly("worst", &Bar::worst, "Its value.")
      .def_readonly("where", &Bar::where, "The place in that clip, where there is one.")
      .def_property_readonly("passes", &Bar::pass, "Whether the value lies in the range.");
  m.def(
      "check_motion",
      [](const Path& folder, const std::string& split, const py::object& progress) {
        const Progress told = progress_of(progress);
        return released([&] { return check_motion(open_dataset(folder.string()), split, told); });
      },
      "folder"_a, "split"_a = "all", py::kw_only(), "progress"_a = py::none(),
      "Measures a data set's motion: skating, speed, acceleration, jerk, joint limits, penetration, contacts. A list "
      "of Bar.\nprogress(done, all) is called after each clip.");
}

}  // namespace inhabit::python
