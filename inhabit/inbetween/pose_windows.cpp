#include "inhabit/inbetween/pose_windows.h"

#include "inhabit/data/cache.h"
#include "inhabit/error.h"
#include "inhabit/inbetween/config.h"

namespace inhabit::inbetween {

namespace {

constexpr size_t kAllKept = 1'000'000;
constexpr const char* kOfRecordings = "inhabit synth fit";

}  // namespace

struct PoseWindows::Impl {
  WindowSet windows;
  mutable RecentCache<std::shared_ptr<const Poses>> clips{kAllKept,
                                                          [this](const std::string& k) { return read_clip(k); }};
  mutable RecentCache<SceneDistances> scenes{
      kAllKept, [this](const std::string& k) { return SceneDistances(windows.load_scene(k)); }};
  std::vector<int64_t> recorded = {}, generated = {};

  std::shared_ptr<const Poses> read_clip(const std::string& key) const {
    const Clip clip = windows.load_clip(key);
    if (!clip.rotations.defined()) throw Error(windows.file(key), "has no rotations");
    return std::make_shared<Poses>(poses_of(clip));
  }
};

PoseWindows::PoseWindows(const std::vector<std::string>& folders, const std::string& split, const Config& config,
                         int64_t stride)
    : impl_(new Impl{WindowSet(folders, split, config.frames, stride, config.rate, [](const Dataset& set) {
        if (set.parents != standard_parents()) throw Error(set.folder, "is not on the standard skeleton");
      })}) {
  for (int64_t i = 0; i < size(); ++i) {
    const auto& made_by = windows().dataset(i).provenance;
    const bool of_recordings = made_by.is_object() && made_by.value("command", std::string()) == kOfRecordings;
    (of_recordings ? impl_->recorded : impl_->generated).push_back(i);
  }
}

PoseWindows::~PoseWindows() = default;

const WindowSet& PoseWindows::windows() const { return impl_->windows; }
const std::vector<int64_t>& PoseWindows::recorded() const { return impl_->recorded; }
const std::vector<int64_t>& PoseWindows::generated() const { return impl_->generated; }

PoseWindow PoseWindows::window(int64_t index, bool mirrored, double pace) const {
  const auto clip = impl_->clips.get(windows().clip_key(index));
  const int64_t frames = windows().frames(), start = windows().place(index).start;
  PoseWindow out{{}, impl_->scenes.get(windows().scene_key(index))};
  if (pace == 1) {
    out.poses = window_of(*clip, start, frames, mirrored);
  } else {
    const PacedWindow at = paced_window(start, frames, clip->frames(), pace);
    out.poses = at_pace(window_of(*clip, at.first, at.frames, mirrored), frames, at.pace);
  }
  if (mirrored) out.scene = out.scene.mirrored();
  return out;
}

}  // namespace inhabit::inbetween
