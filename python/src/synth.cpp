#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/interact/reseat_set.h"
#include "inhabit/synth/activity.h"
#include "inhabit/synth/blocked.h"
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
         double passages, const ShardArgument& shard, const py::object& progress) {
        GenerateOptions options;
        options.clips = clips;
        options.seed = seed;
        options.seconds = seconds;
        options.clips_per_room = clips_per_room;
        options.chords.tried = on_chord;
        options.passages = passages;
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        return opened(folder, released([&] { return generate_rooms(folder.string(), options); }));
      },
      "folder"_a, py::kw_only(), "clips"_a = 100, "seed"_a = 1, "seconds"_a = 12.0, "clips_per_room"_a = 4,
      "on_chord"_a = 0.0, "passages"_a = 0.0, "shard"_a = py::none(), "progress"_a = py::none(),
      documented(
          "A data set of people who live in made-up rooms, in `folder`; the same seed gives the same bytes. seconds: "
          "length of\n"
          "each clip. on_chord: fraction of straight lines between poses that furniture is tried on. passages:\n"
          "fraction of the places along walks that get furniture on both sides. progress(done, all) is called\n"
          "after each clip.",
          kShard)
          .c_str());
  m.def(
      "synth_chairs",
      [](const Path& folder, double minutes, int subjects, int64_t chairs, double linger,
         std::vector<std::string> kinds, uint64_t seed, const ShardArgument& shard, const py::object& progress) {
        ChairsOptions options;
        options.minutes = minutes;
        options.subjects = subjects;
        options.chairs = chairs;
        options.linger = linger;
        options.kinds = std::move(kinds);
        options.seed = seed;
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        return opened(folder, released([&] { return generate_chairs(folder.string(), options); }));
      },
      "folder"_a, py::kw_only(), "minutes"_a = 180.0, "subjects"_a = 6, "chairs"_a = 240, "linger"_a = 0.0,
      "kinds"_a = std::vector<std::string>(), "seed"_a = 1, "shard"_a = py::none(), "progress"_a = py::none(),
      documented("A data set of people who walk up to chairs and sit on them, in `folder`. kinds: of chairs, such as\n"
                 "['sofa', 'bed']; empty: all. linger: seconds that half of the people stand about at most before\n"
                 "they set off, and after they have walked off. progress(done, all) is called after each clip.",
                 kShard)
          .c_str());
  m.def(
      "synth_fit",
      [](const Path& folder, const PathsArgument& mocap, const PathsArgument& val, const PathsArgument& test,
         int rooms_per_clip, double seconds, bool mirrored, double stretches, double on_chord,
         std::pair<int, int> chord_frames, bool only_on_chord, double passages, bool decoys, uint64_t seed,
         const std::optional<std::string>& up, std::optional<double> scale, std::optional<double> rate,
         const std::optional<Path>& asf, bool level, const ShardArgument& shard, const py::object& progress) {
        FittingOptions options;
        options.val = texts_of(val);
        options.test = texts_of(test);
        options.rooms_per_clip = rooms_per_clip;
        options.seconds = seconds;
        options.mirrored = mirrored;
        options.stretches = stretches;
        options.chords.tried = on_chord;
        options.passages = passages;
        std::tie(options.chords.shortest, options.chords.longest) = chord_frames;
        options.only_on_chords = only_on_chord;
        options.decoys = decoys;
        options.seed = seed;
        options.reading = reading_of(up, scale, rate, asf, level);
        options.shard = shard_of(shard);
        options.progress = progress_of(progress);
        const Dataset made = released([&] {
          add_recordings(options, texts_of(mocap));
          return fit_recordings(folder.string(), options);
        });
        for (const char* what : {"doubts", "skipped"}) say(made.provenance.value(what, Notes()));
        return opened(folder, made);
      },
      "folder"_a, "mocap"_a, py::kw_only(), "val"_a = Files(), "test"_a = Files(), "rooms_per_clip"_a = 3,
      "seconds"_a = 12.0, "mirrored"_a = true, "stretches"_a = 0.5, "on_chord"_a = ChordOptions().tried,
      "chord_frames"_a = std::pair(ChordOptions().shortest, ChordOptions().longest), "only_on_chord"_a = false,
      "passages"_a = 0.0, "decoys"_a = false, "seed"_a = 1, "up"_a = py::none(), "scale"_a = py::none(),
      "rate"_a = py::none(), "asf"_a = py::none(), "level"_a = false, "shard"_a = py::none(), "progress"_a = py::none(),
      documented(
          "A data set of rooms fitted around recorded motion, in `folder`. mocap: motion files, folders of them or "
          "patterns; those\n"
          "in a folder called test are kept for testing. val, test: likewise, kept for validation and testing. "
          "seconds: longest\n"
          "piece of a recording. mirrored: every second room of training is around the mirror image. stretches: "
          "fraction of the\n"
          "rooms of training around 4.1 to 5.5 s. on_chord: fraction of straight lines between poses, chord_frames "
          "apart, that\n"
          "furniture is tried on; only_on_chord: rooms of training without any are left out. passages:\n"
          "fraction of the places along walks that get furniture on both sides. decoys: rooms of validation and "
          "testing\n"
          "tell less of where people go, by seats and tables that they pass by. up, scale, rate, asf, "
          "level: how the\n"
          "files are read. progress(done, all) is called after each recording. What is doubted and skipped is "
          "logged.",
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
  m.def(
      "blocked_windows",
      [](const Path& folder, const std::string& split, int64_t frames, int64_t every, int64_t stride, int64_t clips) {
        const BlockedOptions options = {frames, every, stride, clips};
        const BlockedWindows found =
            released([&] { return blocked_windows(open_dataset(folder.string()), split, options); });
        return py::dict("clips"_a = found.clips, "windows"_a = found.windows, "blocked"_a = found.blocked,
                        "colliding"_a = found.colliding, "straight"_a = found.straight, "real"_a = found.real);
      },
      "folder"_a, "split"_a = "train", py::kw_only(), "frames"_a = BlockedOptions().frames,
      "every"_a = BlockedOptions().every, "stride"_a = BlockedOptions().stride, "clips"_a = BlockedOptions().clips,
      "In how many windows of a data set's clips a room decides how one gets from key to key, as `inhabit synth "
      "blocked` has\n"
      "it: a dictionary of clips and windows that were looked at, blocked (windows whose straight path between keys "
      "collides\n"
      "and whose motion does not), colliding (whose motion does), and straight and real, fractions of frames that "
      "collide.\n"
      "frames: of a window; every: between keys; stride: between windows; clips: at most so many, 0 for all.");
  m.def(
      "dynamics_by_activity",
      [](const Path& folder, const std::string& split, double low_pass) {
        ScoreTable table = released(
            [&] { return activity_table(dynamics_by_activity(open_dataset(folder.string()), split, low_pass)); });
        table.labels = {"activity"};
        return python_of(rows_json(table).dump()).cast<py::list>();
      },
      "folder"_a, "split"_a = "all", py::kw_only(), "low_pass"_a = 6.0,
      "How people of a data set move, by what they do (standing, walking, sitting down, ...), as `inhabit synth "
      "activity` has\n"
      "it: a list of dictionaries of activity, frames, speed (m/s), acceleration (m/s^2) and jerk (m/s^3), and the "
      "last two\n"
      "after a low-pass that halves the power at `low_pass` Hz (low_acceleration, low_jerk).");
}

}  // namespace inhabit::python
