#pragma once
#include <cstdio>

#include "data/import_folders.h"
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
  std::string ply;
  int64_t vertices = 0, faces = 0;
  std::string points, triangles;
  for (const Mesh& mesh : room.meshes) {
    const auto v = mesh.vertices.contiguous();
    const auto a = v.accessor<float, 2>();
    for (int64_t i = 0; i < v.size(0); ++i)
      points += std::to_string(a[i][0]) + " " + std::to_string(a[i][1]) + " " + std::to_string(a[i][2]) + "\n";
    const auto f = mesh.faces.accessor<int64_t, 2>();
    for (int64_t i = 0; i < mesh.faces.size(0); ++i)
      triangles += "3 " + std::to_string(vertices + f[i][0]) + " " + std::to_string(vertices + f[i][1]) + " " +
                   std::to_string(vertices + f[i][2]) + "\n";
    vertices += v.size(0);
    faces += mesh.faces.size(0);
  }
  write_atomically(folder + "/scenes/" + scene + ".ply",
                   "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
                       "\nproperty list uchar int vertex_indices\nend_header\n" + points + triangles);
  // The camera looks along the world's +Y, its y points down.
  const torch::Tensor turn = torch::tensor({{1.F, 0.F, 0.F}, {0.F, 0.F, 1.F}, {0.F, -1.F, 0.F}});
  const torch::Tensor place = torch::tensor({0.5F, -4.F, 0.75F});
  write_atomically(folder + "/cam2world/" + scene + ".json",
                   "[[1, 0, 0, 0.5], [0, 0, 1, -4.0], [0, -1, 0, 0.75], [0, 0, 0, 1]]");
  Sitter s = sitter(first, last);
  to_z_up(s);
  const torch::Tensor pelvis = torch::tensor({0.003F, -0.351F, 0.012F});
  const torch::Tensor world = s.trans + pelvis - torch::tensor({0.F, 0.F, 1.F});
  const torch::Tensor orient = matrix_to_axis_angle(turn.t().matmul(axis_angle_to_matrix(s.orient)));
  const torch::Tensor transl = (world - place).matmul(turn) - pelvis;
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
  const torch::Tensor turn = torch::tensor({{0.F, 0.F, 1.F}, {0.F, 1.F, 0.F}, {-1.F, 0.F, 0.F}});
  const torch::Tensor shift = torch::tensor({1.F, 0.F, 2.F});
  for (Mesh& mesh : sofa.meshes) mesh.vertices = (mesh.vertices - shift).matmul(turn).contiguous();
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
  // Rows of points times this: v turn^T + shift.
  mat.select(1, 1).narrow(1, 0, 3).narrow(2, 0, 3).copy_(turn.t());
  mat.select(1, 1).narrow(1, 0, 3).select(2, 3).copy_(shift);
  mat.select(1, 1).select(1, 3).select(1, 3).fill_(1);
  write_npy_at(folder + "/object_mat.npy", mat);
}

}  // namespace inhabit
