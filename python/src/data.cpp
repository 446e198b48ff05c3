#include <memory>
#include <tuple>

#include "calls.h"
#include "inhabit/data/cache.h"
#include "inhabit/data/motion_set.h"
#include "inhabit/data/native.h"
#include "inhabit/data/window_set.h"
#include "inhabit/error.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/sample.h"

namespace inhabit::python {
namespace {

using torch::Tensor;
using Folders = std::vector<Path>;

size_t index_in(int64_t index, int64_t size) {
  if (index < 0) index += size;
  if (index < 0 || index >= size)
    throw py::index_error("index " + std::to_string(index) + " of " + std::to_string(size));
  return static_cast<size_t>(index);
}

/// Clips of one split of a native data set.
struct ClipSet {
  Dataset dataset;
  std::string split;
  std::vector<DatasetClip> entries;
};

std::shared_ptr<ClipSet> open_clip_set(const Path& folder, const std::string& split) {
  auto out = std::make_shared<ClipSet>();
  out->dataset = open_dataset(folder.string());
  out->split = split;
  out->entries = out->dataset.split(split);
  return out;
}

/// Windows of clips as dictionaries of arrays; clips are kept while recently used.
class Windows {
 public:
  using Arguments = std::tuple<Folders, std::string, int64_t, int64_t, double>;
  const Arguments arguments;  // what another process makes the same from

  Windows(const Folders& folders, const std::string& split, int64_t frames, int64_t stride, double rate)
      : arguments(folders, split, frames, stride, rate),
        set_(
            texts_of(folders), split, checked(frames, "frames"), checked(stride, "stride"), rate, [](const Dataset&) {},
            false),
        clips_(16, [this](const std::string& key) { return set_.load_clip(key); }) {}

  int64_t size() const { return set_.size(); }
  std::string name(int64_t index) const { return set_.name(index); }
  /// Of the cache's own arrays: to be copied, not given out.
  Clip cached_clip(int64_t index) { return window_of(clips_.get(set_.clip_key(index)), index); }
  /// Read anew, as who asks may write into it; likewise the scene.
  Clip clip(int64_t index) const { return window_of(set_.load_clip(set_.clip_key(index)), index); }
  std::optional<Scene> scene(int64_t index) const {
    if (set_.entry(index).scene.empty()) return std::nullopt;
    return set_.load_scene(set_.scene_key(index));
  }

 private:
  static int64_t checked(int64_t count, const char* name) {
    if (count < 1) throw Error(name, "are fewer than 1");
    return count;
  }
  Clip window_of(const Clip& whole, int64_t index) const {
    const int64_t first = set_.place(index).start;
    return slice(whole, first, first + set_.frames());
  }
  WindowSet set_;
  RecentCache<Clip> clips_;
};

void put(py::dict& out, const char* name, const Tensor& array) {
  if (array.defined()) out[name] = array_of(array.clone(at::MemoryFormat::Contiguous));
}

py::dict item_of(Windows& windows, int64_t index) {
  const auto at = static_cast<int64_t>(index_in(index, windows.size()));
  const Clip clip = released([&] { return windows.cached_clip(at); });
  py::dict out("index"_a = at);
  put(out, "joints", clip.joints);
  put(out, "rotations", clip.rotations);
  put(out, "trans", clip.trans);
  put(out, "betas", clip.betas);
  put(out, "action", clip.action);
  put(out, "contact", clip.contact);
  put(out, "hand_targets", clip.hand_targets);
  return out;
}

using Settings = std::vector<std::string>;

template <class Config>
Config config_of(Config config, const Settings& settings) {
  set_fields(config, settings);
  validate(config, "settings");
  return config;
}

/// Samples of a system's training data. Workers of a DataLoader make their own from the arguments.
struct ForecastWindows {
  using Arguments = std::tuple<Folders, std::string, int64_t, std::string, Settings, uint64_t, bool>;
  Arguments arguments;
  std::unique_ptr<forecast::Data> data;
  uint64_t seed = 1;
  bool augment = false;

  explicit ForecastWindows(const Arguments& from) : arguments(from) {
    const auto& [folders, split, stride, preset, settings, own_seed, own_augment] = from;
    const forecast::Config config = config_of(forecast::preset(preset), settings);
    if (stride < 1) throw Error("stride", "is under 1");
    seed = own_seed;
    augment = own_augment;
    data = released([&, &folders = folders, &split = split, &stride = stride] {
      return std::make_unique<forecast::Data>(texts_of(folders), split, config, stride);
    });
  }
};
struct InbetweenWindows {
  using Arguments = std::tuple<Folders, std::string, int64_t, std::string, Settings>;
  Arguments arguments;
  std::unique_ptr<inbetween::Data> data;

  explicit InbetweenWindows(const Arguments& from) : arguments(from) {
    const auto& [folders, split, stride, preset, settings] = from;
    const inbetween::Config config = config_of(inbetween::preset(preset), settings);
    if (stride < 1) throw Error("stride", "is under 1");
    data = released([&, &folders = folders, &split = split, &stride = stride] {
      return std::make_unique<inbetween::Data>(texts_of(folders), split, config, stride);
    });
  }
};

/// Pickled as what it was made from.
template <class Made, class Make>
auto pickle_arguments(const Make& make) {
  return py::pickle([](const Made& made) { return made.arguments; },
                    [make](const typename Made::Arguments& from) { return make(from); });
}

void add_clip_set(py::module_& m) {
  py::class_<DatasetClip>(m, "DatasetClip", "One clip of a native data set; paths are relative to its folder.")
      .def_readonly("file", &DatasetClip::file, "'clips/000012.npz'.")
      .def_readonly("scene", &DatasetClip::scene, "'scenes/room_0003.glb'; empty for motion without a scene.")
      .def_readonly("split", &DatasetClip::split, "'train', 'val' or 'test'.")
      .def_readonly("frames", &DatasetClip::frames, "Number of frames.")
      .def_readonly("source", &DatasetClip::source, "The recording it was made from; empty when generated.");
  py::class_<ClipSet, std::shared_ptr<ClipSet>>(m, "Dataset",
                                                "The clips of one split of a native data set (docs/dataset.md), read "
                                                "when they are asked for: dataset[i] is a Clip.")
      .def(py::init(&open_clip_set), "folder"_a, "split"_a = "all", "split: 'train', 'val', 'test' or 'all'.")
      .def_property_readonly(
          "folder", [](const ClipSet& s) { return Path(s.dataset.folder); }, "The folder.")
      .def_readonly("split", &ClipSet::split, "The split.")
      .def_property_readonly(
          "rate", [](const ClipSet& s) { return s.dataset.rate; }, "Frames a second of every clip.")
      .def_property_readonly(
          "actions", [](const ClipSet& s) { return s.dataset.actions; }, "What Clip.action counts.")
      .def_property_readonly(
          "provenance", [](const ClipSet& s) { return python_of(s.dataset.provenance.dump()).cast<py::dict>(); },
          "How it was made: command, seed, sources, licence.")
      .def_readonly("entries", &ClipSet::entries, "A DatasetClip for each clip.")
      .def(
          "scene",
          [](const ClipSet& s, int64_t index) -> std::optional<Scene> {
            const DatasetClip& entry = s.entries[index_in(index, static_cast<int64_t>(s.entries.size()))];
            if (entry.scene.empty()) return std::nullopt;
            return released([&] { return load_scene(s.dataset, entry.scene); });
          },
          "index"_a, "The Scene of clip `index`, or None.")
      .def("__len__", [](const ClipSet& s) { return s.entries.size(); })
      .def(
          "__getitem__",
          [](const ClipSet& s, int64_t index) {
            const DatasetClip& entry = s.entries[index_in(index, static_cast<int64_t>(s.entries.size()))];
            return released([&] { return load_clip(s.dataset, entry); });
          },
          "index"_a, "The Clip at `index`.")
      .def(py::pickle([](const ClipSet& s) { return py::make_tuple(Path(s.dataset.folder), s.split); },
                      [](const py::tuple& t) { return open_clip_set(t[0].cast<Path>(), t[1].cast<std::string>()); }));
}

}  // namespace

void add_data(py::module_& m) {
  add_clip_set(m);
  py::class_<Windows, std::shared_ptr<Windows>>(m, "Windows",
                                                "Windows of equal length of the clips of native data sets, for "
                                                "torch.utils.data.DataLoader: windows[i] is a dictionary\n"
                                                "of arrays: index, joints (T, 22, 3) metres, rotations (T, 22, 3) "
                                                "radians, trans (T, 3) metres and, where the clips\n"
                                                "have them, betas (B), action (T) int64, contact (T, 22), hand_targets "
                                                "(T, 2, 4). Clips and scenes are kept while\n"
                                                "recently used; safe to use from several threads.")
      .def(py::init([](const Folders& folders, const std::string& split, int64_t frames, int64_t stride, double rate) {
             return released([&] { return std::make_shared<Windows>(folders, split, frames, stride, rate); });
           }),
           "folders"_a, "split"_a = "train", "frames"_a = 90, "stride"_a = 30, "rate"_a = 30.0,
           "folders: native data sets; split: 'train', 'val', 'test' or 'all'; frames: T; stride: frames from one "
           "window to\n"
           "the next; rate: frames a second that the clips must have.")
      .def(
          "clip", [](Windows& w, int64_t i) { return w.clip(static_cast<int64_t>(index_in(i, w.size()))); }, "index"_a,
          "Window `index` as a Clip.")
      .def(
          "scene", [](Windows& w, int64_t i) { return w.scene(static_cast<int64_t>(index_in(i, w.size()))); },
          "index"_a, "The Scene of window `index`, or None.")
      .def(
          "name", [](Windows& w, int64_t i) { return w.name(static_cast<int64_t>(index_in(i, w.size()))); }, "index"_a,
          "'FOLDER/clips/000012.npz 30': file and first frame of window `index`.")
      .def("__len__", &Windows::size)
      .def("__getitem__", &item_of, "index"_a, "The arrays of window `index`.")
      .def(pickle_arguments<Windows>([](const Windows::Arguments& from) {
        return released(
            [&] { return std::apply([](const auto&... each) { return std::make_shared<Windows>(each...); }, from); });
      }));
  py::class_<ForecastWindows>(
      m, "ForecastWindows",
      "What forecasting is trained on, for torch.utils.data.DataLoader: a dictionary of joints\n"
      "(P + T, 22, 3) and points (N, 3), metres, in the axes of the window.")
      .def(py::init([](const Folders& folders, const std::string& split, int64_t stride, const std::string& preset,
                       const py::object& settings, uint64_t seed, bool augment) {
             return std::make_unique<ForecastWindows>(
                 ForecastWindows::Arguments{folders, split, stride, preset, settings_of(settings), seed, augment});
           }),
           "folders"_a, "split"_a = "train", "stride"_a = 5, "preset"_a = "compact", "settings"_a = py::none(),
           "seed"_a = 1, "augment"_a = false,
           "settings: of the configuration, {'points': 1024}; points and augmentation are drawn from (seed, index).")
      .def("__len__", [](const ForecastWindows& w) { return w.data->size(); })
      .def(
          "__getitem__",
          [](const ForecastWindows& w, int64_t index) {
            const auto at = static_cast<int64_t>(index_in(index, w.data->size()));
            const forecast::Sample sample = released([&] { return w.data->sample(at, w.seed, w.augment); });
            return py::dict("index"_a = at, "joints"_a = array_of(sample.joints.contiguous()),
                            "points"_a = array_of(sample.points.contiguous()));
          },
          "index"_a, "The arrays of window `index`.")
      .def(pickle_arguments<ForecastWindows>(
          [](const ForecastWindows::Arguments& from) { return std::make_unique<ForecastWindows>(from); }));
  py::class_<InbetweenWindows>(
      m, "InbetweenWindows",
      "What in-betweening is trained on, for torch.utils.data.DataLoader: a dictionary of features\n"
      "(T, 201), occupancy (24, 48, 48), floor (96, 96), offsets (T, 64, 3) metres, body_shape (7)\n"
      "and bones (22, 3) metres.")
      .def(py::init([](const Folders& folders, const std::string& split, int64_t stride, const std::string& preset,
                       const py::object& settings) {
             return std::make_unique<InbetweenWindows>(
                 InbetweenWindows::Arguments{folders, split, stride, preset, settings_of(settings)});
           }),
           "folders"_a, "split"_a = "train", "stride"_a = 30, "preset"_a = "compact", "settings"_a = py::none(),
           "settings: of the configuration, {'frames': 61}.")
      .def("__len__", [](const InbetweenWindows& w) { return w.data->size(); })
      .def(
          "__getitem__",
          [](const InbetweenWindows& w, int64_t index) {
            const auto at = static_cast<int64_t>(index_in(index, w.data->size()));
            const inbetween::Sample sample = released([&] { return w.data->sample(at); });
            py::dict out("index"_a = at);
            put(out, "features", sample.features);
            put(out, "occupancy", sample.occupancy);
            put(out, "floor", sample.floor);
            put(out, "offsets", sample.offsets);
            put(out, "body_shape", sample.body_shape);
            put(out, "bones", sample.bones);
            return out;
          },
          "index"_a, "The arrays of window `index`.")
      .def(pickle_arguments<InbetweenWindows>(
          [](const InbetweenWindows::Arguments& from) { return std::make_unique<InbetweenWindows>(from); }));
  py::class_<ActionMotion>(m, "Recording", "One recording of a labelled action.")
      .def_readonly("name", &ActionMotion::name, "Name of the file.")
      .def_readonly("action", &ActionMotion::action, "'walking'.")
      .def_readonly("split", &ActionMotion::split, "'train', 'val' or 'test'.")
      .def_readonly("clip", &ActionMotion::clip, "A Clip on the standard skeleton.");
  m.def(
      "read_recordings",
      [](const std::string& source, double rate) {
        Notes notes;
        auto out = released([&] { return read_motion_set(source, rate, &notes); });
        say(notes);
        return out;
      },
      "source"_a, "rate"_a = 25.0,
      "Recordings of labelled actions at `rate` frames a second: 'cmu:FOLDER' or 'h36m:FOLDER' (exponential-map text), "
      "or a\n"
      "native data set's folder. Files that are left out are logged.");
}

}  // namespace inhabit::python
