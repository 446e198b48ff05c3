#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/io/npz.h"
#include "inhabit/io/read_options.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

/// A clip from an .npz file of the AMASS and SMPL families or of inhabit itself. Joint positions alone, SMPL's first 22
/// or more, may have any usual name and shape, and come as .npy too (joint_array.h).
///
/// Pose, axis-angle radians, either whole: `poses` (T, 3J) or (T, J, 3) with J = 22, 24 (SMPL), 52 (SMPL-H) or 55
/// (SMPL-X); or in parts: `root_orient`, `global_orient` or `orient` (T, 3); `pose_body` or `body_pose` (T, 63|69); and
/// where the body has them `pose_hand` (T, 90) or `left_hand_pose` and `right_hand_pose`, `pose_jaw` or `jaw_pose`,
/// `pose_eye`. Parts may also be rotation matrices (T, J, 3, 3).
/// Place: `trans`, `transl` or `translation` (T, 3) metres. Rate: `mocap_framerate`, `mocap_frame_rate`, `fps`,
/// `framerate` or `frame_rate`; 30 where there is none. `betas` (B), (1, B) or (T, B); `gender` as any kind of text.
/// inhabit's own: `joint_names` (J), `parents` (J), `offsets` (J, 3) metres, `joints` (T, J, 3), `action` (T),
/// `action_names`, `contact` (T, J), `hand_targets` (T, 2, 4), `object_names` (O), `object_pose` (T, O, 6),
/// `source_body`, `source_betas`, `translations` (T, J, 3), `up` ("z" where the arrays are in a z-up world).
///
/// A file without a skeleton gets that of `options.body` shaped by its betas, or else of the built-in body in its mean
/// shape (its betas belong to another body and are kept as source_betas); the pelvis stays where the file's own model
/// has it. Such a file may be z-up: it is rotated when the trunk points along +Z.
/// Throws Error(path, ...) where arrays are missing or disagree, or a number is not finite.
Clip read_clip_npz(const std::string& path, const ClipReadOptions& options = {}, Notes* notes = nullptr);

/// The same from what was read already; `subject` names the source in errors.
Clip clip_from_npz(const Npz& npz, const std::string& subject, const ClipReadOptions& options = {},
                   Notes* notes = nullptr);

/// The arrays of a clip: AMASS names (`root_orient` and `pose_body` for 22 joints, else `poses`) and inhabit's own,
/// from which clip_from_npz makes the same clip again, bit by bit. Where clip.file is of an .npz, its up axis, and of
/// the SMPL family where the root is counted from, are as they were there. Throws Error(subject, ...) for a clip that
/// is not valid.
Npz npz_from_clip(const Clip& clip, const std::string& subject);

/// Writes the arrays of npz_from_clip. Throws Error(path, ...) for a clip that is not valid and where the file cannot
/// be written.
void write_clip_npz(const std::string& path, const Clip& clip);

/// Several motions of one person, of equal length, in one file: the arrays of npz_from_clip, those that go frame by
/// frame with a leading sample dimension, `joints` (S, T, J, 3). @param more further arrays, (S, T, ...); undefined
/// ones are left out.
void write_clips_npz(const std::string& path, const std::vector<Clip>& clips,
                     const std::map<std::string, torch::Tensor>& more = {});

/// The motions of such a file, or the one motion of any other that read_clip_npz reads.
std::vector<Clip> read_clips_npz(const std::string& path, const ClipReadOptions& options = {}, Notes* notes = nullptr);
/// As read_clips_npz, from what was read already.
/// @param subject names the source in errors
std::vector<Clip> clips_from_npz(const Npz& npz, const std::string& subject, const ClipReadOptions& options = {},
                                 Notes* notes = nullptr);

/// True where the arrays hold motion (and not, say, a point cloud).
bool holds_clip(const Npz& npz);

}  // namespace inhabit
