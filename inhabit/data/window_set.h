#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "inhabit/data/native.h"

namespace inhabit {

/// Windows of equal length, one every `stride` frames, of the clips of native data sets. Only their
/// places are in memory. Safe to use from several threads.
class WindowSet {
 public:
  /// Where a window is.
  struct Place {
    int32_t set;    ///< data set, in the order of the folders
    int32_t clip;   ///< clip of it
    int32_t start;  ///< first frame
  };

  /// @param folders native data sets; @param split "train", "val", "test" or "all"; @param rate that their clips must
  /// have; @param accept throws Error where a data set's skeleton is not the one wanted; @param in_scenes clips without
  /// a scene are left out. Throws Error where a data set cannot be read, has another rate, or a file is
  /// missing that clips_at_hand does not leave out.
  WindowSet(const std::vector<std::string>& folders, const std::string& split, int64_t frames, int64_t stride,
            double rate, const std::function<void(const Dataset&)>& accept, bool in_scenes = true);

  /// Number of windows.
  int64_t size() const { return static_cast<int64_t>(places_.size()); }
  /// Where window `index` is; likewise below.
  const Place& place(int64_t index) const { return places_.at(static_cast<size_t>(index)); }
  /// Its clip.
  const DatasetClip& entry(int64_t index) const { return sets_[place(index).set].clips[place(index).clip]; }
  /// Its data set.
  const Dataset& dataset(int64_t index) const { return sets_[place(index).set]; }
  /// The place of a window among those of its clip.
  int64_t number(int64_t index) const { return place(index).start / stride_; }
  /// Frames of a window.
  int64_t frames() const { return frames_; }
  /// Frames from a window to the next.
  int64_t stride() const { return stride_; }
  /// "FOLDER/clips/000012.npz 30", for errors and tables.
  std::string name(int64_t index) const;

  std::string clip_key(int64_t index) const;                         ///< of a window's clip in caches
  std::string scene_key(int64_t index) const;                        ///< of its scene
  std::string scene_key_of_clip(const std::string& clip_key) const;  ///< of a clip's scene
  Clip load_clip(const std::string& clip_key) const;                 ///< reads it; throws Error
  Scene load_scene(const std::string& scene_key) const;              ///< reads it; throws Error
  std::string file(const std::string& clip_key) const;               ///< "FOLDER/clips/000012.npz"

  /// Indices of the windows of each data set that has any, behind the name of its folder, in the order of the folders.
  std::vector<std::pair<std::string, std::vector<int64_t>>> by_set() const;
  /// At most `count` windows, evenly spread over all.
  std::vector<int64_t> spread(int64_t count) const;

 private:
  const Dataset& set_of(const std::string& key) const;
  const DatasetClip& entry_of(const std::string& clip_key) const;

  int64_t frames_, stride_;
  std::vector<Dataset> sets_;
  std::vector<Place> places_;
};

/// A window at another pace than its clip's: its frame t is where the clip has first + t x pace.
struct PacedWindow {
  int64_t first;   ///< frame of the clip
  int64_t frames;  ///< of the clip that it lies between
  double pace;     ///< 2: twice as fast
};

/// The window of `frames` frames from `start` on, of a clip of `clip_frames`, which begins earlier where the clip would
/// end before it, and is slower where the clip is shorter than all of it.
PacedWindow paced_window(int64_t start, int64_t frames, int64_t clip_frames, double pace);

/// For evaluations, which need a window: throws Error(first folder, ...) where `split` of `folders` has none.
void require_any_window(const WindowSet& windows, const std::vector<std::string>& folders, const std::string& split);

}  // namespace inhabit
