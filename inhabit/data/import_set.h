#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// One recording, or a piece of one, of a data set as its owners hand it out.
struct ImportRecording {
  std::string name = {};    ///< "CMU/01/01_01_poses": there once
  std::string person = {};  ///< who moves; empty: not told
  std::string split = {};   ///< "train", "val" or "test" as the paper has it; empty: it does not say
  std::string scene = {};   ///< recordings that say the same share a scene; empty: without one
  std::string action = {};  ///< of sets of labelled actions
  int64_t first = 0;        ///< row of the data set's arrays, where it is a piece of them
  int64_t count = 0;        ///< rows from there on; 0: it is no piece
};

/// A recording as read: metres, +Y up, at its own rate, on any skeleton that retargets.
struct ImportedMotion {
  Clip clip;                                  ///< the motion
  std::map<std::string, torch::Tensor> more;  ///< parameters of its own body model that a clip has no place for, (T, N)
};

/// What a folder holds of a data set.
struct ImportSet {
  std::string format;                       ///< one of import_formats()
  std::string folder;                       ///< where the data set lies, for errors
  std::vector<ImportRecording> recordings;  ///< in order
  std::vector<std::string> missing;         ///< what is not there, a line each
  std::vector<std::string> broken;          ///< recordings that cannot be read, found while looking, and why
  std::vector<std::string> actions;         ///< of labelled actions; empty: told from the motion
  std::string splits;                       ///< where the splits come from, one clause
  std::function<ImportedMotion(const ImportRecording&)> read;  ///< throws Error; safe to use from several threads
  std::function<Scene(const ImportRecording&)> scene;  ///< metres, +Y up, in the world of the motion; throws Error
};

/// The formats that import knows, in the order of docs/data.md.
const std::vector<std::string>& import_formats();

/// Looks at the folder of a data set; docs/data.md has each layout. @param body of SMPL-family parameters, null: the
/// built-in one. It must outlive the set. Throws Error(folder, ...) where nothing of the format is there.
ImportSet open_import_set(const std::string& format, const std::string& folder, const BodyModel* body = nullptr);

/// Adds recordings of labelled actions as read_motion_set has them, with its splits. @param source "cmu:FOLDER" or
/// "h36m:FOLDER"
void add_motion_set(ImportSet& set, const std::string& source);

// Each format.
/// AMASS: DATASET/PERSON/RECORDING_poses.npz (SMPL-H) or _stageii.npz (SMPL-X), without scenes. A set of any format may
/// come without recordings, and says in ImportSet::missing what is not there; open_import_set refuses it.
ImportSet open_amass(const std::string& folder, const ClipReadOptions& reading);
/// TRUMANS: human_pose.npy, human_orient.npy, human_transl.npy (SMPL-X, 30 Hz, +Y up), Scene_mesh/SCENE.obj and poses
/// of its objects; or single recordings. Throws Error(folder, ...) where an array is missing beside them.
ImportSet open_trumans(const std::string& folder, const ClipReadOptions& reading);
/// SAMP: RECORDING_stageii.pkl in any folder below (SMPL-X, 120 Hz, +Z up), one actor.
ImportSet open_samp(const std::string& folder, const ClipReadOptions& reading);
/// PROX: fittings/ or PROXD/ with a pickle a frame (SMPL-X in the camera's axes, 30 Hz), cam2world/SCENE.json and
/// scenes/SCENE.ply (+Z up).
ImportSet open_prox(const std::string& folder, const ClipReadOptions& reading);
/// GTA-IM: RECORDING/info_frames.npz with the joints, and depth images that the scene comes from; metres, +Z up.
ImportSet open_gta_im(const std::string& folder, const ClipReadOptions& reading);
/// Human3.6M, 50 Hz, the first of these that is there: data_3d_h36m.npz with positions of 32 joints (metres, +Z up), as
/// which `folder` may be a file; S1/MyPoseFeatures/D3_Positions/ACTION.cdf, the same in millimetres as the owners hand
/// it out; S1/ACTION_N.txt (exponential maps).
ImportSet open_human36m(const std::string& folder, const ClipReadOptions& reading);
/// CMU: train/ and test/ACTION/ACTION_N.txt of the literature (exponential maps), or SUBJECT/SUBJECT_N.amc with its
/// .asf of mocap.cs.cmu.edu.
ImportSet open_cmu(const std::string& folder, const ClipReadOptions& reading);
/// GIMO: dataset.csv, a pickle a frame (SMPL-X with VPoser's codes, 30 Hz) and the scans, scaled by what each recording
/// says.
ImportSet open_gimo(const std::string& folder, const ClipReadOptions& reading);
/// COUCH, and BEHAVE which has the same layout: sequences/NAME/tSECONDS/person/fit01/person_fit.pkl (SMPL-H in a
/// camera's axes), meshes of the objects beside it, split.json.
ImportSet open_couch(const std::string& folder, const ClipReadOptions& reading);

/// Gives a split to recordings without one: a tenth of the people, at least one, is tested on, another tenth validated
/// on. Where fewer than three people are told apart it is a tenth of the recordings. Who is in which follows from the
/// names alone. Where the paper has a split but nothing to validate on, a tenth of what is trained on is: by scene, or
/// by person where no two share a scene. Says how in `splits`.
void assign_splits(ImportSet& set);

}  // namespace inhabit
