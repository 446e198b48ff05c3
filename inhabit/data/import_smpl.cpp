#include "inhabit/data/import_smpl.h"

#include <algorithm>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/upright.h"

namespace fs = std::filesystem;

namespace inhabit {

ImportedMotion smpl_motion(const Npz& npz, const std::string& subject, const ClipReadOptions& reading, bool z_up) {
  ImportedMotion out;
  ClipReadOptions as_it_is = reading;
  as_it_is.up = UpAxis::y;
  out.clip = clip_from_npz(npz, subject, as_it_is);
  if (z_up) rotate_upright(out.clip);
  const int64_t frames = out.clip.frames();
  const auto keep = [&](const char* name, const torch::Tensor& rows) {
    if (rows.dim() == 2 && rows.size(0) == frames && torch::isfinite(rows).all().item<bool>())
      out.more[name] = rows.to(torch::kFloat32).contiguous();
  };
  for (const char* name : {"pose_hand", "pose_jaw", "pose_eye", "expression", "left_hand_pose", "right_hand_pose"})
    if (npz.has(name)) keep(name, npz.tensors.at(name));
  const auto whole = npz.tensors.find("poses");
  if (whole == npz.tensors.end() || whole->second.dim() != 2) return out;
  const torch::Tensor& poses = whole->second;
  if (poses.size(1) == 156) keep("pose_hand", poses.narrow(1, 66, 90));
  if (poses.size(1) == 165) {
    keep("pose_jaw", poses.narrow(1, 66, 3));
    keep("pose_eye", poses.narrow(1, 69, 6));
    keep("pose_hand", poses.narrow(1, 75, 90));
  }
  return out;
}

std::vector<std::string> files_below(const std::string& folder, const std::function<bool(const std::string&)>& wanted) {
  std::vector<std::string> out;
  std::error_code refused;
  for (fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink, refused), end;
       !refused && entry != end; entry.increment(refused))
    if (entry->is_regular_file(refused) && wanted(entry->path().filename().string()))
      out.push_back(entry->path().string());
  if (refused) throw Error(folder, "cannot be read: " + refused.message());
  std::sort(out.begin(), out.end());
  return out;
}

std::string name_below(const std::string& folder, const std::string& path) {
  return fs::path(path).lexically_relative(folder).replace_extension().generic_string();
}

}  // namespace inhabit
