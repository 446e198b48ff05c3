#include "inhabit/io/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/mesh.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/point_cloud.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

/// A box without its top: 4 wide (x), `height` high, 6 deep; vertices written through `write(x, y, z)` with y up.
struct OpenRoom {
  double height = 2.5;
  std::vector<std::array<double, 3>> vertices() const {
    std::vector<std::array<double, 3>> out;
    for (const double y : {0.0, height}) {
      for (const auto& [x, z] : {std::pair{0.0, 0.0}, {4.0, 0.0}, {4.0, 6.0}, {0.0, 6.0}}) out.push_back({x, y, z});
    }
    return out;
  }
  std::vector<std::vector<int>> faces() const {
    return {{3, 2, 1, 0}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  }
};

enum class Axis { y_up, z_up };

std::array<double, 3> in_axes(const std::array<double, 3>& p, Axis axis, double scale) {
  if (axis == Axis::y_up) return {p[0] * scale, p[1] * scale, p[2] * scale};
  return {p[0] * scale, -p[2] * scale, p[1] * scale};
}

std::string obj_of(const OpenRoom& room, Axis axis, double scale) {
  std::ostringstream out;
  out << "o room\n";
  for (const auto& vertex : room.vertices()) {
    const auto p = in_axes(vertex, axis, scale);
    out << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  for (const auto& face : room.faces()) {
    out << 'f';
    for (const int corner : face) out << ' ' << corner + 1;
    out << '\n';
  }
  return out.str();
}

std::string ply_of(const OpenRoom& room, Axis axis, double scale) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      << "element face 5\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& vertex : room.vertices()) {
    const auto p = in_axes(vertex, axis, scale);
    out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  for (const auto& face : room.faces()) {
    out << face.size();
    for (const int corner : face) out << ' ' << corner;
    out << '\n';
  }
  return out.str();
}

std::string off_of(const OpenRoom& room, Axis axis, double scale) {
  std::ostringstream out;
  out << "OFF\n8 5 0\n";
  for (const auto& vertex : room.vertices()) {
    const auto p = in_axes(vertex, axis, scale);
    out << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  for (const auto& face : room.faces()) {
    out << face.size();
    for (const int corner : face) out << ' ' << corner;
    out << '\n';
  }
  return out.str();
}

std::string stl_of(const OpenRoom& room, Axis axis, double scale) {
  std::ostringstream out;
  out << "solid room\n";
  const auto vertices = room.vertices();
  for (const auto& face : room.faces()) {
    for (size_t k = 2; k < face.size(); ++k) {
      out << " facet normal 0 0 0\n  outer loop\n";
      for (const int corner : {face[0], face[k - 1], face[k]}) {
        const auto p = in_axes(vertices[static_cast<size_t>(corner)], axis, scale);
        out << "   vertex " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
      }
      out << "  endloop\n endfacet\n";
    }
  }
  out << "endsolid room\n";
  return out.str();
}

std::string write_in(const TempFolder& folder, const std::string& name, const std::string& bytes) {
  const std::string path = folder / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

double area(const Scene& scene) {
  const Mesh mesh = merged_mesh(scene);
  const torch::Tensor c = mesh.vertices.index_select(0, mesh.faces.reshape({-1})).view({-1, 3, 3});
  return 0.5 * torch::cross(c.select(1, 1) - c.select(1, 0), c.select(1, 2) - c.select(1, 0), 1)
                   .norm(2, 1)
                   .sum()
                   .item<double>();
}

TEST(SceneFile, EveryMeshFormatAxisAndUnitGivesTheSameRoom) {
  const OpenRoom room;
  for (const Axis axis : {Axis::y_up, Axis::z_up}) {
    for (const double per_metre : {1.0, 100.0, 1000.0}) {
      const std::vector<std::pair<std::string, std::string>> files{{"obj", obj_of(room, axis, per_metre)},
                                                                   {"ply", ply_of(room, axis, per_metre)},
                                                                   {"off", off_of(room, axis, per_metre)},
                                                                   {"stl", stl_of(room, axis, per_metre)}};
      for (const auto& [extension, bytes] : files) {
        SCOPED_TRACE(extension + (axis == Axis::y_up ? " y " : " z ") + std::to_string(per_metre));
        const SceneFile file = parse_scene(bytes, extension, "room." + extension);
        EXPECT_EQ(file.report.up, axis == Axis::y_up ? 'y' : 'z');
        EXPECT_DOUBLE_EQ(file.report.scale, 1.0 / per_metre);
        EXPECT_EQ(file.report.triangles, 10);
        EXPECT_NEAR(file.report.lower[0], 0, 1e-5);
        EXPECT_NEAR(file.report.lower[1], 0, 1e-5);
        EXPECT_NEAR(file.report.lower[2], 0, 1e-5);
        EXPECT_NEAR(file.report.upper[0], 4, 1e-5);
        EXPECT_NEAR(file.report.upper[1], 2.5, 1e-5);
        EXPECT_NEAR(file.report.upper[2], 6, 1e-5);
        EXPECT_NEAR(area(file.scene), 24 + 2 * 2.5 * 10, 1e-3);
      }
    }
  }
}

TEST(SceneFile, HillyGroundLiesFlat) {
  for (const bool y_up : {true, false}) {
    std::ostringstream text;
    for (int i = 0; i <= 60; ++i) {
      for (int k = 0; k <= 60; ++k) {
        const double x = i / 10.0, z = k / 10.0, height = 0.3 * std::sin(3 * x) * std::cos(2 * z);
        text << x << ' ' << (y_up ? height : z) << ' ' << (y_up ? z : height) << '\n';
      }
    }
    EXPECT_EQ(parse_scene(text.str(), "xyz", "ground.xyz").report.up, y_up ? 'y' : 'z');
  }
}

TEST(SceneFile, HallsInMetresStayHalls) {
  for (const double height : {9.0, 12.0, 25.0}) {
    const SceneFile file = parse_scene(obj_of({height}, Axis::y_up, 1.0), "obj", "hall.obj");
    EXPECT_DOUBLE_EQ(file.report.scale, 1.0) << height;
    EXPECT_NEAR(file.report.upper[1], height, 1e-5);
  }
  // A street of 18 m houses, 24 m long.
  EXPECT_DOUBLE_EQ(parse_scene(obj_of({4.5}, Axis::y_up, 4.0), "obj", "street.obj").report.scale, 1.0);
  // A low stool alone, in centimetres.
  EXPECT_DOUBLE_EQ(parse_scene(obj_of({4.0}, Axis::y_up, 10.0), "obj", "stool.obj").report.scale, 0.01);
}

TEST(SceneFile, PointsInGltfAreACloud) {
  const TempFolder folder;
  Scene cloud;
  cloud.points = torch::rand({50, 3}) * 3;
  write_scene(folder / "cloud.glb", cloud);
  const SceneFile back = read_scene_file(folder / "cloud.glb");
  EXPECT_TRUE(back.scene.meshes.empty());
  EXPECT_TRUE(torch::equal(back.scene.points, cloud.points));
}

// The back rest of a chair that stands alone is no floor.
TEST(SceneFile, ALoneChairStandsAsItsFormatHasIt) {
  const auto seen = [](double unit) {
    std::string text = "o chair\n";
    int first = 1;
    const auto box = [&](Eigen::Vector3d low, Eigen::Vector3d high) {
      for (int i = 0; i < 8; ++i)
        text += fmt::format("v {} {} {}\n", unit * (i % 2 ? high : low).x(), unit * (i / 2 % 2 ? high : low).y(),
                            unit * (i / 4 ? high : low).z());
      for (const auto& f : {"0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"})
        text += fmt::format("f {} {} {} {}\n", first + f[0] - '0', first + f[2] - '0', first + f[4] - '0',
                            first + f[6] - '0');
      first += 8;
    };
    box({-0.23, 0.41, -0.23}, {0.23, 0.46, 0.23});
    box({-0.23, 0.46, -0.23}, {0.23, 0.87, -0.19});
    for (const double x : {-0.23, 0.19})
      for (const double z : {-0.23, 0.19}) box({x, 0, z}, {x + 0.04, 0.41, z + 0.04});
    return parse_scene(text, "obj", "chair.obj");
  };
  const TempFolder folder;
  for (const double unit : {1.0, 100.0}) {
    const SceneFile chair = seen(unit);
    EXPECT_EQ(chair.report.up, 'y') << unit;
    EXPECT_FALSE(chair.report.up_detected) << unit;
    EXPECT_NEAR(chair.report.upper[1], 0.87, 1e-4) << unit;
    write_ply(folder / "chair.ply", chair.scene);
    const SceneReport ply = read_scene_file(folder / "chair.ply").report;
    EXPECT_EQ(ply.up, 'y') << "as its header says; chairs of other .ply files stand along z";
    EXPECT_EQ(ply.upper, chair.report.upper);
  }
}

TEST(SceneFile, FlagsOverrideDetection) {
  SceneReadOptions options;
  options.up = UpAxis::y;
  options.scale = 0.5;
  const SceneFile file = parse_scene(obj_of(OpenRoom(), Axis::z_up, 1.0), "obj", "room.obj", options);
  EXPECT_EQ(file.report.up, 'y');
  EXPECT_FALSE(file.report.up_detected);
  EXPECT_FALSE(file.report.scale_detected);
  EXPECT_NEAR(file.report.upper[2] - file.report.lower[2], 1.25, 1e-5);
  options.scale = -1;
  EXPECT_THAT(refusal_of([&] { parse_scene(obj_of(OpenRoom(), Axis::z_up, 1.0), "obj", "room.obj", options); }),
              HasSubstr("scale"));
}

TEST(SceneFile, ReportSaysWhatWasFound) {
  const SceneFile file = parse_scene(ply_of(OpenRoom(), Axis::z_up, 100.0), "ply", "room.ply");
  const std::string line = describe(file.report);
  EXPECT_THAT(line, HasSubstr("10 triangles"));
  EXPECT_THAT(line, HasSubstr("4.00 x 2.50 x 6.00 m"));
  EXPECT_THAT(line, HasSubstr("up axis z (detected)"));
  EXPECT_THAT(line, HasSubstr("0.01 m per unit (detected)"));
}

TEST(SceneFile, NamesAndColoursAreKept) {
  const TempFolder folder;
  write_in(folder, "colours.mtl", "newmtl red\nKd 0.8 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.9\n");
  const std::string path = write_in(folder, "colours.obj",
                                    "mtllib colours.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\n"
                                    "o chair\nusemtl red\nf 1 2 3\no table\nusemtl blue\nf 1 2 4\n");
  const Scene scene = read_scene_file(path).scene;
  ASSERT_EQ(scene.meshes.size(), 2U);
  EXPECT_EQ(scene.name, "colours");
  EXPECT_EQ(scene.meshes[0].name, "chair");
  EXPECT_EQ(scene.meshes[1].name, "table");
  EXPECT_NEAR(scene.meshes[0].color[0], 0.8F, 1e-5);
  EXPECT_NEAR(scene.meshes[1].color[2], 0.9F, 1e-5);
}

/// A GLB of one triangle under two nodes: one moved, one mirrored.
std::string two_triangles_glb() {
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],)"
      R"("nodes":[{"name":"moved","mesh":0,"translation":[10,20,30]},{"name":"mirrored","mesh":0,"scale":[-1,1,1]}],)"
      R"("meshes":[{"name":"triangle","primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],)"
      R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,0.6,1]}}],)"
      R"("buffers":[{"byteLength":44}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
  while (json.size() % 4 != 0) json += ' ';
  const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::array<uint16_t, 4> indices{0, 1, 2, 0};
  std::string out;
  const auto word = [&](uint32_t value) { out.append(reinterpret_cast<const char*>(&value), 4); };
  word(0x46546C67), word(2), word(static_cast<uint32_t>(12 + 8 + json.size() + 8 + 44));
  word(static_cast<uint32_t>(json.size())), word(0x4E4F534A);
  out += json;
  word(44), word(0x004E4942);
  out.append(reinterpret_cast<const char*>(positions.data()), 36);
  out.append(reinterpret_cast<const char*>(indices.data()), 8);
  return out;
}

TEST(SceneFile, GlbAppliesNodeTransformsAndTurnsMirroredFaces) {
  const SceneFile file = parse_scene(two_triangles_glb(), "glb", "two.glb");
  EXPECT_EQ(file.report.up, 'y');
  EXPECT_DOUBLE_EQ(file.report.scale, 1.0);
  ASSERT_EQ(file.scene.meshes.size(), 2U);
  const Mesh& moved = file.scene.meshes[0];
  EXPECT_EQ(moved.name, "moved");
  EXPECT_NEAR(moved.color[1], 0.4F, 1e-5);
  EXPECT_TRUE(torch::allclose(std::get<0>(moved.vertices.min(0)), torch::tensor({10.F, 20.F, 30.F})));
  const Mesh& mirrored = file.scene.meshes[1];
  EXPECT_EQ(mirrored.name, "mirrored");
  for (const Mesh& mesh : file.scene.meshes) {
    const torch::Tensor c = mesh.vertices.index_select(0, mesh.faces[0]);
    EXPECT_GT(torch::cross(c[1] - c[0], c[2] - c[0], 0)[2].item<float>(), 0) << mesh.name;
  }
}

std::string gltf_of(const std::string& nodes, const std::string& more = "") {
  // Two triangles as a strip, in a buffer that is part of the text: (0 0 0) (1 0 0) (0 1 0) (1 1 0) as bytes.
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"name":"strip","primitives":[{"attributes":{"POSITION":0},"mode":5}]}],)" +
         R"("buffers":[{"byteLength":16,"uri":"data:application/octet-stream;base64,AAAAAAEAAAAAAQAAAQEAAA=="}],)" +
         R"("bufferViews":[{"buffer":0,"byteLength":16,"byteStride":4}],)" +
         R"("accessors":[{"bufferView":0,"componentType":5121,"count":4,"type":"VEC3"}])" + more + "}";
}

TEST(SceneFile, GltfStripsBytesAndTrees) {
  const std::vector<Mesh> meshes = parse_meshes(
      gltf_of(R"([{"scale":[2,2,2],"children":[1]},{"translation":[1,0,0],"mesh":0}])"), "gltf", "strip.gltf");
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_EQ(meshes[0].name, "strip");
  ASSERT_EQ(meshes[0].faces.size(0), 2);
  EXPECT_TRUE(torch::allclose(std::get<0>(meshes[0].vertices.max(0)), torch::tensor({4.F, 2.F, 0.F})));
  for (int64_t face = 0; face < 2; ++face) {
    const torch::Tensor c = meshes[0].vertices.index_select(0, meshes[0].faces[face]);
    EXPECT_GT(torch::cross(c[1] - c[0], c[2] - c[0], 0)[2].item<float>(), 0);
  }
  const auto message = [](const std::string& text) {
    return refusal_of([&] { parse_meshes(text, "gltf", "bad.gltf"); });
  };
  EXPECT_THAT(message(gltf_of(R"([{"mesh":0,"children":[1]},{"children":[0]}])")), HasSubstr("no tree"));
  EXPECT_THAT(message(gltf_of(R"([{"mesh":7}])")), HasSubstr("mesh that is not there"));
  EXPECT_THAT(message(gltf_of(R"([{"translation":[1e39,0,0],"mesh":0}])")), HasSubstr("not finite"));
  std::string longer = gltf_of(R"([{"mesh":0}])");
  longer.replace(longer.find("\"count\":4"), 9, "\"count\":5");
  EXPECT_THAT(message(longer), HasSubstr("past the end"));
}

TEST(SceneFile, PlyWithoutFacesIsACloud) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\ncomment a cloud\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nproperty uchar red\nend_header\n";
  for (const double value : {1.0, 2.0, 3.0, -1.0, -2.0, -3.0}) {
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), &value, 8);
    std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), 8);
    if (std::abs(value) == 3.0) bytes += '\x7f';
  }
  SceneReadOptions options;
  options.up = UpAxis::y;
  const SceneFile file = parse_scene(bytes, "ply", "cloud.ply", options);
  EXPECT_TRUE(file.scene.meshes.empty());
  EXPECT_TRUE(torch::equal(file.scene.points, torch::tensor({1.F, 2.F, 3.F, -1.F, -2.F, -3.F}).view({2, 3})));
}

TEST(SceneFile, DegenerateFacesAreDroppedAndCounted) {
  const std::string bytes = "OFF\n4 3 0\n0 0 0\n1 0 0\n0 0 1\n2 0 0\n3 0 1 2\n3 0 1 3\n3 0 0 1\n";
  const SceneFile file = parse_scene(bytes, "off", "flat.off");
  EXPECT_EQ(file.report.triangles, 1);
  const std::string none =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n";
  EXPECT_THAT(refusal_of([&] { parse_scene(none, "ply", "none.ply"); }), HasSubstr("none.ply"));
}

TEST(PointCloud, TextWithAnySeparator) {
  const torch::Tensor expected = torch::tensor({1.5F, 2.F, -3.F, 4.F, 5.25F, 6.F}).view({2, 3});
  for (const char* text :
       {"1.5 2 -3\n4 5.25 6\n", "1.5,2,-3\r\n4,5.25,6\r\n", "1.5, 2, -3, 255\n4, 5.25, 6, 255", "1.5;2;-3\n\n4;5.25;6",
        "x y z\n1.5\t2\t-3\n4\t5.25\t6\n", "2\n1.5 2 -3 # first\n4 5.25 6\n", "1,5 2,0 -3,0\n4,0 5,25 6,0\n",
        "1,5;2;-3\n4;5,25;6\n", "+1.5 2 -3 9 9 9\n4 525e-2 6 9 9 9"}) {
    EXPECT_TRUE(torch::equal(parse_point_cloud(text, "xyz", "cloud.xyz"), expected)) << text;
  }
}

std::string pcd_header(const std::string& data, int points) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH " +
         std::to_string(points) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}

TEST(PointCloud, PcdAsciiBinaryAndCompressedAgree) {
  const std::vector<std::array<float, 3>> points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const torch::Tensor expected = torch::arange(1, 10, torch::kFloat32).view({3, 3});
  const std::string ascii = pcd_header("ascii", 3) + "1 2 3 0\n4 5 6 0\n7 8 9 0\n";
  EXPECT_TRUE(torch::equal(parse_point_cloud(ascii, "pcd", "a.pcd"), expected));

  std::string interleaved, planes;
  for (const auto& point : points) {
    interleaved.append(reinterpret_cast<const char*>(point.data()), 12);
    interleaved.append(4, '\0');
  }
  EXPECT_TRUE(torch::equal(parse_point_cloud(pcd_header("binary", 3) + interleaved, "pcd", "b.pcd"), expected));

  for (size_t axis = 0; axis < 3; ++axis) {
    for (const auto& point : points) planes.append(reinterpret_cast<const char*>(&point[axis]), 4);
  }
  // Thirty-six literal bytes in two runs, then twelve zeros: one literal and a copy that overlaps itself.
  std::string packed;
  packed += '\x1f';
  packed.append(planes, 0, 32);
  packed += '\x03';
  packed.append(planes, 32, 4);
  packed += std::string("\x00\x00", 2);
  packed += std::string("\xe0\x02\x00", 3);  // length 7 + 2 + 2 = 11, one byte back
  const std::array<uint32_t, 2> sizes{static_cast<uint32_t>(packed.size()), 48};
  const std::string compressed =
      pcd_header("binary_compressed", 3) + std::string(reinterpret_cast<const char*>(sizes.data()), 8) + packed;
  EXPECT_TRUE(torch::equal(parse_point_cloud(compressed, "pcd", "c.pcd"), expected));
}

TEST(PointCloud, PcdLeavesUnmeasuredPointsOut) {
  const std::string bytes = pcd_header("ascii", 2) + "nan nan nan 0\n4 5 6 0\n";
  EXPECT_TRUE(torch::equal(parse_point_cloud(bytes, "pcd", "a.pcd"), torch::tensor({4.F, 5.F, 6.F}).view({1, 3})));
}

TEST(PointCloud, NumpyArchives) {
  Npz archive;
  const torch::Tensor points = torch::arange(12, torch::kFloat64).view({4, 3});
  for (const char* name : {"points", "xyz", "positions"}) {
    archive.tensors.clear();
    archive.tensors[name] = points;
    EXPECT_TRUE(torch::equal(parse_point_cloud(npz_bytes(archive), "npz", "cloud.npz"), points.to(torch::kFloat32)));
  }
  archive.tensors["points"] = torch::zeros({4});
  EXPECT_THAT(refusal_of([&] { parse_point_cloud(npz_bytes(archive), "npz", "cloud.npz"); }), HasSubstr("not (N, 3)"));
  archive.tensors["points"] = torch::full({4, 3}, NAN);
  EXPECT_THAT(refusal_of([&] { parse_point_cloud(npz_bytes(archive), "npz", "cloud.npz"); }), HasSubstr("not finite"));
  archive.tensors = {{"trans", points}};
  EXPECT_THAT(refusal_of([&] { parse_point_cloud(npz_bytes(archive), "npz", "cloud.npz"); }), HasSubstr("no array"));
}

TEST(Meshes, ObjCornersOfEveryForm) {
  const std::string text =
      "# a square and a triangle\ng first\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 0 1\nv 0 0 1\nvt 0 0\nvn 0 1 0\n"
      "f 1/1 2/1/1 3//1 \\\n 4\nl 1 2\ng second\nf -4 -3 -2\ng first\nf 1 3 4\n";
  const std::vector<Mesh> meshes = parse_meshes(text, "obj", "forms.obj");
  ASSERT_EQ(meshes.size(), 2U);
  EXPECT_EQ(meshes[0].name, "first");
  EXPECT_TRUE(torch::equal(meshes[0].faces, torch::tensor({0, 1, 2, 0, 2, 3, 0, 2, 3}, torch::kInt64).view({3, 3})));
  EXPECT_EQ(meshes[1].vertices.size(0), 3);
}

TEST(Meshes, BinaryStlIsWelded) {
  std::string bytes = "solid but binary";
  bytes.resize(80, ' ');
  const uint32_t triangles = 2;
  bytes.append(reinterpret_cast<const char*>(&triangles), 4);
  for (const std::array<float, 12>& t :
       {std::array<float, 12>{0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0}}) {
    bytes.append(reinterpret_cast<const char*>(t.data()), 48);
    bytes.append(2, '\0');
  }
  const Mesh mesh = parse_meshes(bytes, "stl", "square.stl").at(0);
  EXPECT_EQ(mesh.name, "square");
  EXPECT_EQ(mesh.vertices.size(0), 4);
  EXPECT_EQ(mesh.faces.size(0), 2);
  const float infinite = INFINITY;
  std::memcpy(bytes.data() + 84 + 12, &infinite, 4);
  EXPECT_THAT(refusal_of([&] { parse_meshes(bytes, "stl", "square.stl"); }), HasSubstr("not finite"));
}

TEST(BadScenes, OneLineThatNamesTheFile) {
  const TempFolder folder;
  const std::string ply_head = "ply\nformat binary_little_endian 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::vector<std::tuple<std::string, std::string, std::string>> cases{
      {"ply", "", "empty"},
      {"ply", "garbage", "ply"},
      {"ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "header"},
      {"ply", ply_head + "element vertex 4000000000\n" + xyz + "end_header\n", "4000000000"},
      {"ply", ply_head + "element vertex 18446744073709551615\n" + xyz + "end_header\nabc", "ends before"},
      {"ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n0 nan 0\n", "not finite"},
      {"ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n0 inf 0\n", "not finite"},
      {"ply",
       "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz +
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 1 2\n",
       "names vertex 1 of 1"},
      {"ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "x, y and z"},
      {"obj", "", "empty"},
      {"obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "bad.obj"},
      {"obj", "v 0 nan 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", "not finite"},
      {"obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 9\n", "line 4: a face names vertex 9 of 3"},
      {"obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 0\n", "invalid corner '0'"},
      {"obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 -9\n", "invalid corner '-9'"},
      {"obj", "v 0 0,5 0\n", "line 1: a vertex is not three numbers"},
      {"npz", "PK garbage", "bad.npz"},
      {"off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 0 1\n3 0 1 7\n", "line 6: a face names vertex 7 of 3"},
      {"stl", "solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 nan 0\n", "line 5"},
      {"off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "bad.off"},
      {"off", "OFF\n4000000000 4000000000 0\n", "bad.off"},
      {"stl", "solid nothing\nendsolid nothing\n", "bad.stl"},
      {"stl", std::string(80, ' ') + "\xff\xff\xff\x7f", "bad.stl"},
      {"glb", "glTF", "bad.glb"},
      {"glb", two_triangles_glb().substr(0, 400), "bad.glb"},
      {"gltf", "{}", "bad.gltf"},
      {"xyz", "", "empty"},
      {"xyz", "# nothing\n", "no points"},
      {"xyz", "1 2 3\n4 5\n", "line 2"},
      {"xyz", "1 2 3\n4 5 x\n", "line 2"},
      {"xyz", "1 2 3\n4 5 nan\n", "line 2"},
      {"xyz", std::string("\0\1\2\3", 4), "binary"},
      {"pcd", "garbage", "bad.pcd"},
      {"pcd", pcd_header("binary", 1000000), "ends before"},
      {"pcd", pcd_header("ascii", 3) + "1 2 3 0\n", "ends"},
      {"pcd", pcd_header("ascii", 1) + "1 x 3 0\n", "three numbers"},
      {"pcd", pcd_header("ascii", 1) + "1 inf 3 0\n", "infinite"},
      {"pcd", pcd_header("ascii", 1) + "nan nan nan 0\n", "no points"},
      {"pcd", pcd_header("binary_compressed", 3) + std::string("\5\0\0\0\xff\xff\xff\xff\1\2\3\4\5", 13), "impossible"},
      {"obj", "v 0 0 0\nv 1e30 0 0\nv 0 0 1e30\nf 1 2 3\n", "km across"},
      {"fbx", "x", "bad.fbx"}};
  for (const auto& [extension, bytes, reason] : cases) {
    const std::string path = write_in(folder, "bad." + extension, bytes);
    const std::string message = refusal_of([&] { read_scene_file(path); });
    EXPECT_THAT(message, HasSubstr("bad." + extension)) << bytes.substr(0, 60);
    EXPECT_THAT(message, HasSubstr(reason)) << bytes.substr(0, 60);
    EXPECT_THAT(message, testing::Not(HasSubstr("\n")));
  }
  EXPECT_THAT(refusal_of([] { read_scene_file("/nowhere/room.obj"); }), HasSubstr("no such file"));
  EXPECT_THAT(refusal_of([&] { read_scene_file(folder.path.string()); }), HasSubstr("format"));
}

TEST(BadScenes, EveryTruncationIsAnErrorOrAShorterScene) {
  const std::vector<std::pair<std::string, std::string>> files{{"obj", obj_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"ply", ply_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"off", off_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"stl", stl_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"glb", two_triangles_glb()},
                                                               {"pcd", pcd_header("ascii", 2) + "1 2 3 0\n4 5 6 0\n"}};
  for (const auto& [extension, bytes] : files) {
    for (size_t length = 0; length < bytes.size(); length += 7) {
      try {
        const SceneFile file = parse_scene(bytes.substr(0, length), extension, "cut." + extension);
        EXPECT_FALSE(file.scene.empty());
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("cut." + extension));
      }
    }
  }
}

TEST(BadScenes, RandomDamageIsAnErrorOrAScene) {
  Npz archive;
  archive.tensors["points"] = torch::rand({5, 3});
  const std::vector<std::pair<std::string, std::string>> files{{"obj", obj_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"ply", ply_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"off", off_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"stl", stl_of(OpenRoom(), Axis::y_up, 1)},
                                                               {"glb", two_triangles_glb()},
                                                               {"gltf", gltf_of(R"([{"mesh":0}])")},
                                                               {"pcd", pcd_header("ascii", 2) + "1 2 3 0\n4 5 6 0\n"},
                                                               {"xyz", "1 2 3\n4, 5, 6\n"},
                                                               {"npz", npz_bytes(archive)}};
  std::mt19937_64 random(1);
  const std::array<const char*, 8> snippets{"-1", "99999999999", "nan", "1e39", "\n", "\\\n", "0", "4294967295"};
  for (const auto& [extension, bytes] : files) {
    for (int round = 0; round < 300; ++round) {
      std::string damaged = bytes;
      for (uint64_t edits = 1 + random() % 4; edits > 0 && !damaged.empty(); --edits) {
        const size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged.erase(at, 1 + random() % 8);
            break;
          case 2:
            damaged.insert(at, snippets[random() % snippets.size()]);
            break;
          default:
            damaged.replace(at, std::min<size_t>(2, damaged.size() - at), snippets[random() % snippets.size()]);
        }
      }
      try {
        const SceneFile file = parse_scene(damaged, extension, "damaged." + extension);
        EXPECT_FALSE(file.scene.empty());
        for (const Mesh& mesh : file.scene.meshes) {
          EXPECT_TRUE(torch::isfinite(mesh.vertices).all().item<bool>());
          EXPECT_LT(mesh.faces.max().item<int64_t>(), mesh.vertices.size(0));
        }
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("damaged." + extension));
        EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
      }
    }
  }
}

TEST(SceneFile, RecordedRoom) {
  const std::string shared = shared_folder();
  if (shared.empty()) GTEST_SKIP() << "no shared folder";
  const std::string path = shared + "/data/trumans/room.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recorded room";
  const SceneFile file = read_scene_file(path);
  EXPECT_EQ(file.report.meshes, 12);  // ten objects, two of them of two materials
  EXPECT_GT(file.report.triangles, 10000);
  EXPECT_GT(file.report.upper[1] - file.report.lower[1], 2.0);
  EXPECT_LT(file.report.upper[1] - file.report.lower[1], 5.0);
  for (const Mesh& mesh : file.scene.meshes) EXPECT_FALSE(mesh.name.empty());
}

}  // namespace
}  // namespace inhabit
