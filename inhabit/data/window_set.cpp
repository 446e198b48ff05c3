#include "inhabit/data/window_set.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "inhabit/error.h"

namespace inhabit {
namespace {

// Keys are "set/item", where an item is a clip's number or a scene's name.
std::string key_of(int32_t set, const std::string& item) { return std::to_string(set) + "/" + item; }
std::string item_of(const std::string& key) { return key.substr(key.find('/') + 1); }

}  // namespace

WindowSet::WindowSet(const std::vector<std::string>& folders, const std::string& split, int64_t frames, int64_t stride,
                     double rate, const std::function<void(const Dataset&)>& accept, bool in_scenes)
    : frames_(frames), stride_(stride) {
  for (const std::string& folder : folders) {
    sets_.push_back(open_dataset(folder));
    const Dataset& set = sets_.back();
    accept(set);
    if (set.rate != rate) throw Error(folder, fmt::format("has {} frames a second, the model {}", set.rate, rate));
    for (const size_t c : clips_at_hand(set, split)) {
      const DatasetClip& clip = set.clips[c];
      if (in_scenes && clip.scene.empty()) continue;
      for (int64_t start = 0; start + frames <= clip.frames; start += stride)
        places_.push_back(
            {static_cast<int32_t>(sets_.size() - 1), static_cast<int32_t>(c), static_cast<int32_t>(start)});
    }
  }
}

const Dataset& WindowSet::set_of(const std::string& key) const {
  return sets_[std::stoul(key.substr(0, key.find('/')))];
}
const DatasetClip& WindowSet::entry_of(const std::string& clip_key) const {
  return set_of(clip_key).clips[std::stoul(item_of(clip_key))];
}

std::string WindowSet::name(int64_t index) const {
  return file(clip_key(index)) + " " + std::to_string(place(index).start);
}
std::vector<std::pair<std::string, std::vector<int64_t>>> WindowSet::by_set() const {
  std::vector<std::pair<std::string, std::vector<int64_t>>> out;
  int32_t last = -1;
  for (int64_t i = 0; i < size(); ++i) {
    if (place(i).set != last) {
      const auto folder = std::filesystem::absolute(dataset(i).folder + "/.").lexically_normal();  // "rooms/" too
      out.emplace_back(folder.parent_path().filename().string(), std::vector<int64_t>());
    }
    last = place(i).set;
    out.back().second.push_back(i);
  }
  return out;
}
std::string WindowSet::clip_key(int64_t index) const {
  return key_of(place(index).set, std::to_string(place(index).clip));
}
std::string WindowSet::scene_key(int64_t index) const { return key_of(place(index).set, entry(index).scene); }
std::string WindowSet::scene_key_of_clip(const std::string& clip_key) const {
  return clip_key.substr(0, clip_key.find('/') + 1) + entry_of(clip_key).scene;
}
Clip WindowSet::load_clip(const std::string& clip_key) const {
  return inhabit::load_clip(set_of(clip_key), entry_of(clip_key));
}
Scene WindowSet::load_scene(const std::string& scene_key) const {
  return inhabit::load_scene(set_of(scene_key), item_of(scene_key));
}
std::string WindowSet::file(const std::string& clip_key) const {
  return set_of(clip_key).folder + "/" + entry_of(clip_key).file;
}

std::vector<int64_t> WindowSet::spread(int64_t count) const {
  std::vector<int64_t> out;
  const int64_t n = std::min(count, size());
  for (int64_t i = 0; i < n; ++i) out.push_back(i * size() / n);
  return out;
}

PacedWindow paced_window(int64_t start, int64_t frames, int64_t clip_frames, double pace) {
  const double steps = static_cast<double>(frames - 1);
  const auto needed = std::min(static_cast<int64_t>(std::ceil(steps * pace)) + 1, clip_frames);
  return {std::min(start, clip_frames - needed), needed, std::min(pace, static_cast<double>(needed - 1) / steps)};
}

void require_any_window(const WindowSet& windows, const std::vector<std::string>& folders, const std::string& split) {
  if (windows.size() == 0)
    throw Error(folders.front(), "has no window of " + std::to_string(windows.frames()) + " frames in split " + split);
}

}  // namespace inhabit
