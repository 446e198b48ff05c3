#include <filesystem>

#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/io/extension.h"

namespace inhabit {

// DATASET/PERSON/RECORDING_poses.npz (SMPL-H), or _stageii.npz (SMPL-X); a person's shape.npz or _stagei.npz beside
// them is no recording.
ImportSet open_amass(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  const std::vector<std::string> files = files_below(folder, [](const std::string& name) {
    if (extension_of(name) != "npz") return false;
    const std::string stem = name.substr(0, name.size() - 4);
    return !stem.ends_with("shape") && !stem.ends_with("_stagei");
  });
  for (const std::string& path : files) {
    ImportRecording recording;
    recording.name = name_below(folder, path);
    recording.person = std::filesystem::path(recording.name).parent_path().generic_string();
    set.recordings.push_back(recording);
  }
  if (files.empty()) set.missing.emplace_back("DATASET/PERSON/*_poses.npz or *_stageii.npz");
  set.read = [folder, reading](const ImportRecording& recording) {
    const std::string path = folder + "/" + recording.name + ".npz";
    return smpl_motion(read_npz(path), path, reading, true);
  };
  return set;
}

}  // namespace inhabit
