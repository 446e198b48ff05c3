#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/data/shard.h"
#include "inhabit/io/file_lock.h"
#include "inhabit/io/npz.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// One clip of a native data set. Paths are relative to the data set's folder, with forward slashes.
struct DatasetClip {
  std::string file;    ///< "clips/000012.npz"
  std::string scene;   ///< "scenes/room_0003.glb"; empty for motion without a scene
  std::string split;   ///< "train", "val" or "test"
  int64_t frames = 0;  ///< number of frames, so that cutting into samples needs no file
  std::string source;  ///< the recording it was made from; empty when generated
};

/// The index of a native data set (docs/dataset.md): a folder with dataset.json, scenes/ and clips/. Only the index is
/// held; clips and scenes are read when asked for.
struct Dataset {
  std::string folder;                                    ///< where it lies
  double rate = 30.0;                                    ///< frames a second of every clip
  std::vector<std::string> joint_names;                  ///< of the skeleton that all clips have
  std::vector<int> parents;                              ///< of these joints, -1 for the root
  std::vector<std::string> actions;                      ///< what Clip::action counts
  nlohmann::json provenance = nlohmann::json::object();  ///< how it was made: command, seed, sources, licence
  std::vector<DatasetClip> clips;                        ///< of all splits
  Shard shard;                                           ///< what part of it this process makes
  std::vector<std::shared_ptr<const FileLock>> locks;    ///< of the folder, while the data set is being made
  bool whole = true;  ///< false: other shards are still to come, there is no index yet and `clips` are this shard's

  /// The clips of one split, in order; "all" gives every clip. Throws as require_split.
  std::vector<DatasetClip> split(const std::string& name) const;
};

/// Throws Error("split", ...) unless it is "train", "val", "test" or "all".
void require_split(const std::string& name);

/// Reads FOLDER/dataset.json. Throws Error(FOLDER/dataset.json, ...) that names the entry at fault where it is missing,
/// no JSON, of another version, has values of the wrong type or size, a path that leaves the folder, or one scene in
/// two splits.
Dataset open_dataset(const std::string& folder);

/// Places in Dataset::clips of the clips of a split ("all": of every split), in order. One of the training split whose
/// file is missing or torn, or whose scene is missing, is left out with a warning that says why, and how many were:
/// others teach as well. Of the other splits, which are measured on, it is an Error(file, ...): said at once, not an
/// hour into a training. Throws as require_split.
std::vector<size_t> clips_at_hand(const Dataset& dataset, const std::string& split);

/// Throws Error(file, ...) where the clip is missing or damaged, or disagrees with the index (frames, rate, joints,
/// actions).
Clip load_clip(const Dataset& dataset, const DatasetClip& entry);

/// The same from the arrays of its file. @param subject names them in errors.
Clip clip_from_arrays(const Dataset& dataset, const DatasetClip& entry, const Npz& arrays, const std::string& subject);

/// A scene by the name that clips give it. Scenes are shared by clips: keep those you need again.
Scene load_scene(const Dataset& dataset, const std::string& name);

/// An empty data set of the standard skeleton in `folder`, whose folders are made. Throws Error where they cannot be,
/// or where a data set is there already or being made. Several shards may be made in one folder at once.
Dataset create_dataset(const std::string& folder, const std::vector<std::string>& actions, const Shard& shard = {});

/// The same in a folder that may hold a data set already, or clips of one that was not finished: what is there stays.
Dataset continue_dataset(const std::string& folder, const std::vector<std::string>& actions, const Shard& shard = {});

/// Writes a scene into the folder as glTF, or a clip whose `entry` says where it goes (frames are filled in). Both may
/// be called from several threads.
void write_scene(const Dataset& dataset, const std::string& name, const Scene& scene);
/// Writes a clip as .npz (write_clip_npz) into `entry.file` of the folder and sets entry.frames. Throws Error naming
/// the file.
void write_clip(const Dataset& dataset, DatasetClip& entry, const Clip& clip);

/// A line: folder, clips, minutes and the clips of each split; of a part whose others are missing, that they are.
std::string summary(const Dataset& dataset);

/// Writes dataset.json; last, so that an interrupted run leaves no data set behind. Throws Error as open_dataset would.
void write_index(const Dataset& dataset);

}  // namespace inhabit
