#include "targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "inhabit/body/body_model.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/io/asf_amc.h"
#include "inhabit/io/bvh.h"
#include "inhabit/io/clip_json.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/locomotion.h"

namespace {

using namespace inhabit;

template <typename Read>
bool survive(const uint8_t* data, size_t size, const Read& read) {
  const torch::NoGradGuard no_gradient;
  try {
    read(std::string_view(reinterpret_cast<const char*>(data), size));
    return true;
  } catch (const Error&) {
    return false;  // what a reader says to bad input
  }
}

std::string& folder_to_remove() {
  static std::string folder;
  return folder;
}

/// For readers that take a path: the bytes as a file in memory.
template <typename Read>
bool survive_file(const uint8_t* data, size_t size, const Read& read) {
  const int file = memfd_create("fuzz", 0);
  if (file < 0 || write(file, data, size) != static_cast<ssize_t>(size)) std::abort();
  const bool accepted = survive(data, size, [&](std::string_view) { read("/proc/self/fd/" + std::to_string(file)); });
  close(file);
  return accepted;
}

/// Arrays of an archive, or of loose pieces (name, zero byte, 32-bit length, .npy): in an archive nearly every mutation
/// ends at a checksum.
Npz arrays_of(std::string_view bytes) {
  if (bytes.substr(0, 2) == "PK" || bytes.find("NUMPY") == 1) return parse_npz(bytes, "fuzz");
  Npz npz;
  for (size_t zero = 0; (zero = bytes.find('\0')) != std::string_view::npos && bytes.size() - zero > 4;) {
    const std::string name(bytes.substr(0, zero));
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + zero + 1, 4);
    bytes.remove_prefix(zero + 5);
    const Npz piece = parse_npz(bytes.substr(0, length), "fuzz");
    for (const auto& [key, value] : piece.tensors) npz.tensors[name] = value;
    for (const auto& [key, value] : piece.strings) npz.strings[name] = value;
    for (const auto& [key, value] : piece.skipped) npz.skipped[name] = value;
    bytes.remove_prefix(std::min<size_t>(length, bytes.size()));
  }
  return npz;
}

bool fuzz_npz(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_npz(bytes, "fuzz"); });
}
bool fuzz_clip_npz(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { clips_from_npz(arrays_of(bytes), "fuzz"); });
}
bool fuzz_smpl_model(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { smpl_model_from_npz(arrays_of(bytes), "fuzz"); });
}
bool fuzz_clip_json(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_clip_json(bytes, "fuzz"); });
}
bool fuzz_bvh(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    Clip clip = parse_bvh(bytes, "fuzz").clip;
    if (is_z_up(clip, UpAxis::automatic, "fuzz", nullptr)) turn_upright(clip);
    carry_by_root(clip);
    restore_trajectory(clip);
  });
}
/// Both files in one input, a zero byte between them.
bool fuzz_asf_amc(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const size_t cut = std::min(bytes.find('\0'), bytes.size());
    parse_asf_amc(bytes.substr(0, cut), "fuzz.asf", bytes.substr(std::min(cut + 1, bytes.size())), "fuzz.amc");
  });
}
bool fuzz_expmap_text(const uint8_t* data, size_t size) {
  return survive(data, size,
                 [](std::string_view bytes) { expmap_motion(parse_expmap_channels(bytes, "fuzz"), "fuzz"); });
}
bool fuzz_safetensors(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { read_safetensors(path); });
}
/// dataset.json in a folder of its own, in memory where the system has such a place.
bool fuzz_dataset(const uint8_t* data, size_t size) {
  static const std::string folder = [] {
    const bool memory = std::filesystem::is_directory("/dev/shm");
    const std::string path = (memory ? "/dev/shm/inhabit_fuzz_" : "/tmp/inhabit_fuzz_") + std::to_string(getpid());
    std::filesystem::create_directories(path);
    folder_to_remove() = path;
    std::atexit([] { std::filesystem::remove_all(folder_to_remove()); });
    return path;
  }();
  std::ofstream(folder + "/dataset.json", std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return survive(data, size, [](std::string_view) { open_dataset(folder); });
}
/// To look for the up axis takes a hundred times as long as to read a small file: one input in sixteen is looked at.
template <char... extension>
bool fuzz_scene(const uint8_t* data, size_t size) {
  const UpAxis given = size % 2 == 0 ? UpAxis::z : UpAxis::y;
  const SceneReadOptions options = {.up = size % 16 == 0 ? UpAxis::automatic : given, .scale = {}};
  return survive(data, size,
                 [&](std::string_view bytes) { parse_scene(bytes, std::string{extension...}, "fuzz", options); });
}

}  // namespace

void prepare_fuzzing(const std::string& target) {
  if (target == "clip_npz" || target == "smpl_model") builtin_body();
}

const std::vector<FuzzTarget>& fuzz_targets() {
  static const std::vector<FuzzTarget> targets = {
      {"npz", fuzz_npz},
      {"clip_npz", fuzz_clip_npz},
      {"smpl_model", fuzz_smpl_model},
      {"clip_json", fuzz_clip_json},
      {"bvh", fuzz_bvh},
      {"asf_amc", fuzz_asf_amc},
      {"expmap_text", fuzz_expmap_text},
      {"safetensors", fuzz_safetensors},
      {"dataset", fuzz_dataset},
      {"obj", fuzz_scene<'o', 'b', 'j'>},
      {"ply", fuzz_scene<'p', 'l', 'y'>},
      {"off", fuzz_scene<'o', 'f', 'f'>},
      {"stl", fuzz_scene<'s', 't', 'l'>},
      {"glb", fuzz_scene<'g', 'l', 'b'>},
      {"pcd", fuzz_scene<'p', 'c', 'd'>},
      {"xyz", fuzz_scene<'x', 'y', 'z'>},
  };
  return targets;
}
