#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/npy_format.h"
#include "inhabit/io/npz.h"
#include "inhabit/math/rotation.h"
#include "io/pickle_bytes.h"

// Small folders in the layouts that owners of data sets hand out, of a person who walks to a sofa and sits down.

namespace inhabit {

inline const std::string kSitter = INHABIT_SOURCE_DIR "/examples/data/sit.npz";

/// The sitter's last `frames` of the first `last` as SMPL-X has them: +Y up, metres, axis-angle.
struct Sitter {
  torch::Tensor orient, body, trans;  // (T, 3), (T, 63), (T, 3)
  Clip clip;                          // the same on the sitter's own skeleton
};
inline Sitter sitter(int64_t first, int64_t last) {
  Sitter out;
  out.clip = slice(read_clip_npz(kSitter), first, last);
  const int64_t T = out.clip.frames();
  out.orient = out.clip.rotations.select(1, 0).clone();
  out.body = out.clip.rotations.narrow(1, 1, 21).reshape({T, 63}).clone();
  // SMPL-X's pelvis rests 0.351 m under its origin.
  out.trans = out.clip.root_path() - torch::tensor({0.003F, -0.351F, 0.012F});
  return out;
}

/// A +Y-up orientation and place of the pelvis in a +Z-up world: (x, y, z) -> (x, -z, y).
inline void to_z_up(Sitter& s) {
  const torch::Tensor rotation = torch::tensor({{1.F, 0.F, 0.F}, {0.F, 0.F, -1.F}, {0.F, 1.F, 0.F}});
  const torch::Tensor pelvis = torch::tensor({0.003F, -0.351F, 0.012F});
  s.orient = matrix_to_axis_angle(rotation.matmul(axis_angle_to_matrix(s.orient)));
  s.trans = (s.trans + pelvis).matmul(rotation.t()) - pelvis;
}

inline void make_folders(const std::string& path) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
}
inline void write_npy_at(const std::string& path, const torch::Tensor& tensor) {
  make_folders(path);
  write_npy(path, tensor);
}
inline void write_npy_at(const std::string& path, const std::vector<std::string>& texts) {
  make_folders(path);
  write_atomically(path, npy_bytes(StringArray{{static_cast<int64_t>(texts.size())}, texts}));
}

inline void write_pickle(const std::string& path, const std::map<std::string, torch::Tensor>& arrays,
                         const std::string& more = "") {
  make_folders(path);
  write_atomically(path, pickled(arrays, more));
}

inline Npz amass_arrays(Sitter s, double rate) {
  to_z_up(s);
  const int64_t T = s.orient.size(0);
  Npz npz;
  npz.tensors["poses"] = torch::cat({s.orient, s.body, torch::full({T, 90}, 0.125)}, 1).to(torch::kFloat64);
  npz.tensors["trans"] = s.trans.to(torch::kFloat64);
  npz.tensors["betas"] = torch::arange(16).to(torch::kFloat64) / 10;
  npz.tensors["mocap_framerate"] = torch::tensor(rate, torch::kFloat64);
  npz.strings["gender"] = {{}, {"female"}};
  return npz;
}

/// DATASET/PERSON/RECORDING_poses.npz of four people, one of whom has a recording that is damaged.
inline void write_amass(const std::string& folder) {
  for (const char* person : {"A/01", "A/02", "B/x", "B/y"}) {
    const std::string path = folder + "/" + person + "/walk to sofa_poses.npz";
    make_folders(path);
    write_npz(path, amass_arrays(sitter(120, 300), 60));
    write_npz(folder + "/" + std::string(person) + "/shape.npz", amass_arrays(sitter(120, 122), 60));
  }
  write_atomically(folder + "/B/y/broken_poses.npz", "PK this is none");
}

inline void write_samp(const std::string& folder) {
  Sitter s = sitter(100, 300);
  to_z_up(s);
  const int64_t T = s.orient.size(0);
  for (const char* name : {"chair_mo001", "sofa001", "locomotion001"})
    write_pickle(folder + "/pkl/" + name + std::string("_stageii.pkl"),
                 {{"pose_est_fullposes", torch::cat({s.orient, s.body, torch::full({T, 99}, 0.125)}, 1)},
                  {"pose_est_trans", s.trans},
                  {"shape_est_betas", torch::arange(300) / 100.0},
                  {"mocap_framerate", torch::tensor(30.0)}});
}

}  // namespace inhabit
