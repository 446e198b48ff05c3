#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/data/import_set.h"
#include "inhabit/io/npz.h"

// Data sets that keep each frame in a file of its own.

namespace inhabit {

/// A frame's pickle.
struct FrameFile {
  int64_t number = 0;  ///< of the frame, at 30 Hz
  std::string path;    ///< of the file
};

/// What `told` takes of a folder's entries, by number; a number that is there twice counts once.
std::vector<FrameFile> frames_in(const std::string& folder,
                                 const std::function<std::optional<FrameFile>(const std::filesystem::path&)>& told);

/// A recording for each stretch of at least two frames without a gap of over half a second: NAME, NAME_1, ...
std::vector<ImportRecording> pieces_of(const ImportRecording& recording, const std::vector<FrameFile>& frames);

/// Takes away the frames that are not of the recording's piece. Throws Error(name, ...) where fewer than two stay.
void keep_piece(std::vector<FrameFile>& frames, const ImportRecording& recording);

/// Numbers of the pickles, each a dictionary: arrays of a row (N) a frame. `needed` are in every frame; of `wanted`
/// those are left out that some frame lacks, or has in another length. Throws Error(path, ...).
Npz rows_of(const std::vector<FrameFile>& frames, const std::vector<std::string>& needed,
            const std::vector<std::string>& wanted);

/// A motion of SMPL-X's parameters at 30 Hz: transl, global_orient, body_pose. The hands are coefficients of the
/// model's own basis, no angles: kept as they are, not posed.
ImportedMotion smplx_motion(Npz rows, const std::string& subject, const ClipReadOptions& reading);

/// Puts the frames that are missing between their neighbours; parameters that are no rotations are the nearest frame's.
void fill_missing(ImportedMotion& motion, const std::vector<FrameFile>& frames);

/// The numbers of a matrix in JSON, row by row, float64. Throws Error(path, ...) for anything else.
torch::Tensor numbers_of(const nlohmann::json& rows, const std::string& path);

/// (4, 4) float32 of 16 numbers. Throws Error(path, ...) unless they are finite, a rotation and a place.
torch::Tensor rigid_transform(const torch::Tensor& numbers, const std::string& path);

/// Moves a clip by such a transform.
void move_clip(Clip& clip, const torch::Tensor& transform);

/// Moves a scene by it.
Scene moved_scene(Scene scene, const torch::Tensor& transform);

}  // namespace inhabit
