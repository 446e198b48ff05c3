#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/pickle.h"

namespace inhabit {
namespace {

ImportedMotion read_samp(const std::string& path, const ClipReadOptions& reading) {
  const Pickle pickle = read_pickle(path);
  Npz npz;
  npz.tensors["poses"] = pickle.numbers_at(*pickle.root, "pose_est_fullposes");
  npz.tensors["trans"] = pickle.numbers_at(*pickle.root, "pose_est_trans");
  npz.tensors["betas"] = pickle.numbers_at(*pickle.root, "shape_est_betas");
  npz.tensors["mocap_framerate"] = pickle.numbers_at(*pickle.root, "mocap_framerate");
  npz.strings["gender"] = {{}, {"male"}};  // the data set has one actor
  npz.strings["surface_model_type"] = {{}, {"smplx"}};
  return smpl_motion(npz, path, reading, true);
}

}  // namespace

// RECORDING_stageii.pkl, in any folder below: SMPL-X, 120 Hz, +Z up, one actor.
ImportSet open_samp(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  for (const std::string& path :
       files_below(folder, [](const std::string& name) { return extension_of(name) == "pkl"; }))
    set.recordings.push_back({.name = name_below(folder, path), .person = "actor"});
  if (set.recordings.empty()) set.missing.emplace_back("*_stageii.pkl");
  set.read = [folder, reading](const ImportRecording& recording) {
    return read_samp(folder + "/" + recording.name + ".pkl", reading);
  };
  return set;
}

}  // namespace inhabit
