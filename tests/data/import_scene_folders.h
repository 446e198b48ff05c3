#pragma once
#include <cstdio>

#include "data/import_folders.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/png_mask.h"
#include "inhabit/io/scene_file.h"

// The same with the room that the person sits down in.

namespace inhabit {

inline const std::string kSitterRoom = INHABIT_SOURCE_DIR "/examples/data/sit_room.glb";

/// The sitter's room, or some of its meshes, as Wavefront text, +Y up or +Z up.
inline void write_obj(const std::string& path, const Scene& scene) {
  make_folders(path);
  std::string text;
  int64_t base = 1;
  for (const Mesh& mesh : scene.meshes) {
    text += "o " + mesh.name + "\n";
    const auto v = mesh.vertices.accessor<float, 2>();
    for (int64_t i = 0; i < mesh.vertices.size(0); ++i)
      text += "v " + std::to_string(v[i][0]) + " " + std::to_string(v[i][1]) + " " + std::to_string(v[i][2]) + "\n";
    const auto f = mesh.faces.accessor<int64_t, 2>();
    for (int64_t i = 0; i < mesh.faces.size(0); ++i)
      text += "f " + std::to_string(base + f[i][0]) + " " + std::to_string(base + f[i][1]) + " " +
              std::to_string(base + f[i][2]) + "\n";
    base += mesh.vertices.size(0);
  }
  write_atomically(path, text);
}

/// scenes/, cam2world/ and fittings/ with a pickle a frame in the camera's axes; frames 40 to 42 are missing.
inline void write_prox(const std::string& folder, const std::string& scene, int64_t first, int64_t last) {
  Scene room = read_scene_file(kSitterRoom).scene;
  for (Mesh& mesh : room.meshes)  // +Z up, the floor a metre under the origin
    mesh.vertices =
        torch::stack({mesh.vertices.select(1, 0), -mesh.vertices.select(1, 2), mesh.vertices.select(1, 1)}, 1) -
        torch::tensor({0.F, 0.F, 1.F});
  std::filesystem::create_directories(folder + "/scenes");
  std::filesystem::create_directories(folder + "/cam2world");
  write_ply(folder + "/scenes/" + scene + ".ply", room);
  // The camera looks along the world's +Y, its y points down.
  const torch::Tensor rotation = torch::tensor({{1.F, 0.F, 0.F}, {0.F, 0.F, 1.F}, {0.F, -1.F, 0.F}});
  const torch::Tensor place = torch::tensor({0.5F, -4.F, 0.75F});
  write_atomically(folder + "/cam2world/" + scene + ".json",
                   "[[1, 0, 0, 0.5], [0, 0, 1, -4.0], [0, -1, 0, 0.75], [0, 0, 0, 1]]");
  Sitter s = sitter(first, last);
  to_z_up(s);
  const torch::Tensor pelvis = torch::tensor({0.003F, -0.351F, 0.012F});
  const torch::Tensor world = s.trans + pelvis - torch::tensor({0.F, 0.F, 1.F});
  const torch::Tensor orient = matrix_to_axis_angle(rotation.t().matmul(axis_angle_to_matrix(s.orient)));
  const torch::Tensor transl = (world - place).matmul(rotation) - pelvis;
  for (int64_t t = 0; t < s.orient.size(0); ++t) {
    if (t >= 40 && t < 43) continue;
    char name[64];
    std::snprintf(name, sizeof name, "s001_frame_%05d__00.00.00.000", static_cast<int>(t + 1));
    write_pickle(folder + "/fittings/" + scene + "_00162_01/results/" + name + "/000.pkl",
                 {{"transl", transl[t].view({1, 3})},
                  {"global_orient", orient[t].view({1, 3})},
                  {"body_pose", s.body[t].view({1, 63})},
                  {"betas", torch::arange(10).view({1, 10})},
                  {"left_hand_pose", torch::full({1, 12}, 0.5)},
                  {"pose_embedding", torch::zeros({1, 32})}});
  }
}

/// Three motions one after the other, each in the sitter's room; the sofa is an object of its own.
inline void write_trumans(const std::string& folder) {
  const Scene whole = read_scene_file(kSitterRoom).scene;
  Scene room, sofa;
  for (const Mesh& mesh : whole.meshes) (mesh.name.rfind("sofa", 0) == 0 ? sofa : room).meshes.push_back(mesh);
  // The sofa as its file has it, turned by a quarter and moved: object_mat puts it back.
  const torch::Tensor rotation = torch::tensor({{0.F, 0.F, 1.F}, {0.F, 1.F, 0.F}, {-1.F, 0.F, 0.F}});
  const torch::Tensor shift = torch::tensor({1.F, 0.F, 2.F});
  for (Mesh& mesh : sofa.meshes) mesh.vertices = (mesh.vertices - shift).matmul(rotation).contiguous();
  write_obj(folder + "/Scene_mesh/home.obj", room);
  write_obj(folder + "/Object_chairs/Object_mesh/sofa.obj", sofa);
  const Sitter s = sitter(120, 320);
  const int64_t T = s.orient.size(0), n = 3;
  write_npy_at(folder + "/human_orient.npy", s.orient.repeat({n, 1}));
  write_npy_at(folder + "/human_pose.npy", s.body.repeat({n, 1}));
  write_npy_at(folder + "/human_transl.npy", s.trans.repeat({n, 1}));
  write_npy_at(folder + "/left_hand_pose.npy", torch::full({n * T, 45}, 0.25));
  std::vector<std::string> segments;
  for (int64_t t = 0; t < n * T; ++t) segments.push_back("seg" + std::to_string(t / T));
  write_npy_at(folder + "/seg_name.npy", segments);
  write_npy_at(folder + "/scene_flag.npy", torch::zeros({n * T}, torch::kInt64));
  write_npy_at(folder + "/scene_list.npy", std::vector<std::string>{"home.npy"});
  write_npy_at(folder + "/bad_frames.npy", torch::tensor({T + 70}));
  write_npy_at(folder + "/object_list.npy", std::vector<std::string>{"stool", "sofa"});
  torch::Tensor flag = torch::full({n * T, 2}, -1, torch::kInt64);
  flag.select(1, 1).fill_(1);
  write_npy_at(folder + "/object_flag.npy", flag);
  torch::Tensor mat = torch::zeros({n * T, 2, 4, 4});
  // Rows of points times this: v rotation^T + shift.
  mat.select(1, 1).narrow(1, 0, 3).narrow(2, 0, 3).copy_(rotation.t());
  mat.select(1, 1).narrow(1, 0, 3).select(2, 3).copy_(shift);
  mat.select(1, 1).select(1, 3).select(1, 3).fill_(1);
  write_npy_at(folder + "/object_mat.npy", mat);
}

/// A person of the world in other axes, x_world = rotation x + shift. @param rotation (3, 3). @param shift (3)
inline void to_axes(Sitter& s, const torch::Tensor& rotation, const torch::Tensor& shift) {
  const torch::Tensor pelvis = torch::tensor({0.003F, -0.351F, 0.012F});
  s.orient = matrix_to_axis_angle(rotation.t().matmul(axis_angle_to_matrix(s.orient)));
  s.trans = (s.trans + pelvis - shift).matmul(rotation) - pelvis;
}
inline Scene to_axes(Scene scene, const torch::Tensor& rotation, const torch::Tensor& shift) {
  for (Mesh& mesh : scene.meshes) mesh.vertices = (mesh.vertices - shift).matmul(rotation).contiguous();
  return scene;
}

/// A VPoser whose codes are the principal components of some poses, (T, 63) axis-angle: rotations come out 0.01 off.
struct FakeVposer {
  std::map<std::string, torch::Tensor> weights;
  torch::Tensor codes;  ///< (T, 32)
};
inline FakeVposer fake_vposer(const torch::Tensor& poses) {
  const int64_t T = poses.size(0), n = 40;
  // Rows of a joint's first two columns, as the network has them.
  const torch::Tensor six = axis_angle_to_matrix(poses.view({T, 21, 3})).narrow(3, 0, 2).reshape({T, 126}).contiguous();
  const torch::Tensor mean = six.mean(0);
  const torch::Tensor basis = std::get<2>(torch::linalg_svd(six - mean, false)).narrow(0, 0, 32);  // (32, 126)
  FakeVposer out;
  const torch::Tensor codes = (six - mean).matmul(basis.t());
  const double shift = -codes.min().item<double>() + 0.5;  // positive codes pass the leaky ReLUs as they are
  out.codes = codes + shift;
  out.weights["bodyprior_dec_fc1.weight"] = torch::eye(n).narrow(1, 0, 32).contiguous();
  out.weights["bodyprior_dec_fc2.weight"] = torch::eye(n);
  out.weights["bodyprior_dec_fc1.bias"] = torch::zeros({n});
  out.weights["bodyprior_dec_fc2.bias"] = torch::zeros({n});
  out.weights["bodyprior_dec_out.weight"] = torch::cat({basis.t(), torch::ones({126, n - 32})}, 1).contiguous();
  out.weights["bodyprior_dec_out.bias"] = mean - basis.t().sum(1) * shift;
  return out;
}

/// dataset.csv, a scan and a pickle a frame of PyTorch's tensors; frames 40 to 42 are missing.
inline void write_gimo(const std::string& folder, int64_t first, int64_t last) {
  const double scale = 1.03;
  const torch::Tensor scan_rotation = yaw_matrix(0.5), scan_shift = torch::tensor({-0.2F, 0.9F, 0.3F});
  const torch::Tensor take_rotation = yaw_matrix(1.25), take_shift = torch::tensor({-1.5F, -1.25F, 3.25F});
  const auto matrix = [](const torch::Tensor& rotation, const torch::Tensor& shift, const char* row, const char* end) {
    std::string out;
    for (int64_t r = 0; r < 3; ++r) {
      out += row;
      for (int64_t c = 0; c < 3; ++c) out += std::to_string(rotation[r][c].item<double>()) + (*row ? ", " : " ");
      out += std::to_string(shift[r].item<double>()) + end;
    }
    return out;
  };
  make_folders(folder + "/hall/scene_obj/transform_norm.txt");
  write_atomically(folder + "/hall/scene_obj/transform_norm.txt",
                   matrix(scan_rotation, scan_shift, "", "\n") + "0 0 0 1\n");
  Scene scan = read_scene_file(kSitterRoom).scene;
  for (Mesh& mesh : scan.meshes) mesh.vertices = mesh.vertices * scale;
  write_obj(folder + "/hall/scene_obj/textured_output.obj", to_axes(scan, scan_rotation, scan_shift));
  write_atomically(folder + "/dataset.csv",
                   "\xEF\xBB\xBFsequence_path,start_frame,end_frame,scene,transformation,training\r\n"
                   "2022-01-23,300," +
                       std::to_string(300 + last - first) +
                       ",hall,transform_info.json,0\r\n2022-01-24,0,9,hall,transform_info.json,1\r\n");
  const std::string take = folder + "/hall/2022-01-23/";
  make_folders(take + "x");
  write_atomically(take + "transform_info.json", "{\"scale\": 1.03, \"transformation\": [" +
                                                     matrix(take_rotation, take_shift, "[", "], ") + "[0, 0, 0, 1]]}");
  Sitter s = sitter(first, last);
  to_axes(s, scan_rotation, scan_shift / scale);
  to_axes(s, take_rotation, take_shift / scale);
  const FakeVposer vposer = fake_vposer(s.body);
  make_folders(folder + "/vposer_v1_0/snapshots/TR00_E096.pt");
  write_atomically(folder + "/vposer_v1_0/snapshots/TR00_E096.pt", torch_file(vposer.weights));
  make_folders(take + "smplx_local/x");
  for (int64_t t = 0; t < s.orient.size(0); ++t)
    if (t < 40 || t >= 43)
      write_atomically(take + "smplx_local/" + std::to_string(300 + t) + ".pkl",
                       torch_pickle({{"orient", s.orient[t]},
                                     {"trans", s.trans[t]},
                                     {"latent", vposer.codes[t]},
                                     {"beta", torch::arange(10) / 10.0},
                                     {"lhand", torch::full({45}, 0.5)}}));
}

/// What couch's sofa does from its 100th frame on: it slides 1 mm a frame along +X.
inline double sofa_slid(int64_t t) { return t < 100 ? 0 : 0.001 * static_cast<double>(t - 100); }

/// sequences/ with a pickle a frame in the axes of a camera that is tilted by 25 degrees, the sofa as it was
/// registered.
inline void write_couch(const std::string& folder, int64_t first, int64_t last) {
  const torch::Tensor rotation =
      axis_angle_to_matrix(torch::tensor({static_cast<float>(M_PI - 25 * M_PI / 180), 0.F, 0.F}));
  const torch::Tensor shift = torch::tensor({0.5F, 1.75F, -3.F});
  Sitter s = sitter(first, last);
  to_axes(s, rotation, shift);
  // SMPL-H's pelvis rests elsewhere than SMPL-X's.
  s.trans += torch::tensor({0.003F, -0.351F, 0.012F}) - torch::tensor({-0.002F, -0.223F, 0.028F});
  Scene sofa;
  for (const Mesh& mesh : read_scene_file(kSitterRoom).scene.meshes)
    if (mesh.name.rfind("sofa", 0) == 0) sofa.meshes.push_back(mesh);
  const std::string take = folder + "/sequences/Date01_Sub02_sofa_sit/";
  for (int64_t t = 0; t < s.orient.size(0); ++t) {
    char name[32];
    std::snprintf(name, sizeof name, "t%08.3f", static_cast<double>(t) / 30);
    const std::string frame = take + name;
    write_pickle(frame + "/person/fit01/person_fit.pkl",
                 {{"pose", torch::cat({s.orient[t], s.body[t], torch::full({90}, 0.125)})},
                  {"trans", s.trans[t]},
                  {"betas", torch::arange(10) / 10.0}});
    if (t == 120) continue;  // not registered there
    make_folders(frame + "/sofa/fit01/x");
    Scene there = sofa;
    for (Mesh& mesh : there.meshes) mesh.vertices = mesh.vertices + torch::tensor({sofa_slid(t), 0.0, 0.0});
    write_ply(frame + "/sofa/fit01/sofa_fit.ply", to_axes(there, rotation, shift));
  }
  write_atomically(take + "info.json", "{\"cat\": \"sofa\", \"gender\": \"male\"}");
  write_atomically(folder + "/split.json", "{\"train\": [], \"test\": [\"Date01_Sub02_sofa_sit\"]}");
  make_folders(folder + "/sequences/Date01_Sub02_slow/t0001.000/x");
}

constexpr int64_t kGtaRows = 36, kGtaColumns = 64;

/// A recording's folder of GTA-IM: people's joints (T, 22, 3), +Y up, and what a camera 3 m above their origin sees of
/// the room, straight down: its depth (rows, columns), metres. Somebody of 7 by 7 pixels stands before it. What
/// info_frames.npz holds.
inline Npz write_gta_im(const std::string& recording, const torch::Tensor& people, const torch::Tensor& room) {
  make_folders(recording + "/x");
  const std::vector<int64_t> of = {15, 12, 14, 17, 19, 21, 13, 16, 18, 20, 9, 9, 6, 3, 0, 2, 5, 8, 1, 4, 7};
  torch::Tensor joints = people.index_select(1, torch::tensor(of)).clone();
  joints.select(1, 10).add_(torch::tensor({0.F, 0.1F, 0.F}));  // the release has a spine of five
  joints = torch::stack({joints.select(2, 0), -joints.select(2, 2), joints.select(2, 1)}, 2) + 100;
  const int64_t F = joints.size(0);
  Npz npz;
  npz.tensors["joints_3d_world"] = joints.to(torch::kFloat64);
  npz.tensors["joints_2d"] = torch::tensor({58.0, 5.0}, torch::kFloat64).expand({F, 21, 2}).contiguous();
  npz.tensors["intrinsics"] = (torch::eye(3) * 40).expand({F, 3, 3}).contiguous();
  // Row vectors: the camera is 3 m above the floor z = 100 and looks down; its x is the world's.
  torch::Tensor to_world = torch::zeros({4, 4});
  to_world[0][0] = 1;
  to_world[1][1] = -1;
  to_world[2][2] = -1;
  to_world[3] = torch::tensor({100.F, 100.F, 103.F, 1.F});
  npz.tensors["world2cam_trans"] = torch::linalg_inv(to_world).expand({F, 4, 4}).contiguous();
  write_npz(recording + "/info_frames.npz", npz);
  std::string frames = "(l";
  for (int64_t t = 0; t < F; ++t) frames += "(dS'cam_near_clip'\nF0.15\nsS'cam_far_clip'\nF800.0\nsa";
  write_atomically(recording + "/info_frames.pickle", frames + ".");
  write_atomically(recording + "/realtimeinfo.gz", "(dS'setting'\n(dS'room'\nI10\nss.");
  // The buffer's number for a depth.
  const auto number = [](double z) { return 50 * (800 - 0.15) / (0.15 * 800 / z - 0.15); };
  torch::Tensor depth = torch::zeros({kGtaRows, kGtaColumns, 3}, torch::kUInt8), ids = torch::zeros_like(depth);
  for (int64_t y = 0; y < kGtaRows; ++y)
    for (int64_t x = 0; x < kGtaColumns; ++x) {
      const bool person = std::abs(x - 58) < 3 && std::abs(y - 5) < 3;
      const auto raw = static_cast<int64_t>(number(person ? 1.5 : room[y][x].item<double>()));
      for (int64_t c = 0; c < 3; ++c) depth[y][x][2 - c] = static_cast<uint8_t>((raw >> (8 * c)) & 255);
      ids[y][x][0] = person ? 7 : 9;
    }
  write_png(recording + "/00010.png", depth);
  write_png(recording + "/00010_id.png", ids);
  return npz;
}

}  // namespace inhabit
