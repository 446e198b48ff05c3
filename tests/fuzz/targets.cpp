#include "targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "folder_of_bytes.h"
#include "inhabit/anticipate/config.h"
#include "inhabit/anticipate/label_agreement.h"
#include "inhabit/anticipate/model_file.h"
#include "inhabit/body/body_model.h"
#include "inhabit/data/dataset_items.h"
#include "inhabit/data/import_clip.h"
#include "inhabit/data/import_set.h"
#include "inhabit/data/import_state.h"
#include "inhabit/data/measured_parts.h"
#include "inhabit/data/motion_set.h"
#include "inhabit/data/native.h"
#include "inhabit/data/vposer.h"
#include "inhabit/error.h"
#include "inhabit/forecast/config.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/control_text.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/methods.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/motion_autoencoder.h"
#include "inhabit/interact/config.h"
#include "inhabit/interact/contact_script.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/io/asf_amc.h"
#include "inhabit/io/bvh.h"
#include "inhabit/io/cdf.h"
#include "inhabit/io/clip_json.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/cloud_sequence.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/fbx_repair.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/png_mask.h"
#include "inhabit/io/pose_line.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/io/torch_file.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/pose_stream.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/nn/parameters.h"
#include "inhabit/reconstruct/camera.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/serve/message.h"
#include "inhabit/train/checkpoint.h"
#include "inhabit/version.h"
#include "inhabit/view/charts.h"

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

/// A folder for readers that look around in one, in memory where the system has such a place; removed at the end.
const std::string& own_folder() {
  static const std::string folder = [] {
    const bool memory = std::filesystem::is_directory("/dev/shm");
    const std::string path = (memory ? "/dev/shm/inhabit_fuzz_" : "/tmp/inhabit_fuzz_") + std::to_string(getpid());
    std::filesystem::create_directories(path);
    return path;
  }();
  [[maybe_unused]] static const int registered = std::atexit([] { std::filesystem::remove_all(own_folder()); });
  return folder;
}

void write_file(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Up to the first zero byte, and what follows it: two files in one input.
std::pair<std::string_view, std::string_view> two_files(std::string_view bytes) {
  const size_t cut = std::min(bytes.find('\0'), bytes.size());
  return {bytes.substr(0, cut), bytes.substr(std::min(cut + 1, bytes.size()))};
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
  for (const NamedBytes& loose : pieces_of(bytes)) {
    const Npz piece = parse_npz(loose.bytes, "fuzz");
    for (const auto& [key, value] : piece.tensors) npz.tensors[loose.name] = value;
    for (const auto& [key, value] : piece.strings) npz.strings[loose.name] = value;
    for (const auto& [key, value] : piece.skipped) npz.skipped[loose.name] = value;
  }
  return npz;
}

bool fuzz_npz(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_npz(bytes, "fuzz"); });
}
bool fuzz_pickle(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const Pickle pickle = parse_pickle(bytes, "fuzz");
    for (const PickleValue* value : pickle.root->items)
      if (value->kind == PickleValue::Kind::array) pickle.numbers(*value, "array");
  });
}
bool fuzz_torch_file(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const Pickle file = parse_torch(bytes, "fuzz");
    for (const PickleValue* value : file.root->items)
      if (value->kind == PickleValue::Kind::array) file.numbers(*value, "array");
  });
}
bool fuzz_cdf(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_cdf(bytes, "fuzz"); });
}
bool fuzz_fbx(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { repaired_fbx(std::string(bytes), "fuzz"); });
}
bool fuzz_clip_npz(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { clips_from_npz(arrays_of(bytes), "fuzz"); });
}
bool fuzz_clouds(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const CloudSequence clouds = clouds_from_npz(arrays_of(bytes), "fuzz");
    for (int64_t t = 0; t < std::min<int64_t>(clouds.frames, 100); ++t) clouds.read(t);
  });
}

bool fuzz_smpl_model(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { smpl_model_from_npz(arrays_of(bytes), "fuzz"); });
}
bool fuzz_clip_json(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_clip_json(bytes, "fuzz"); });
}
bool fuzz_training_log(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_training_log(bytes, "fuzz"); });
}
bool fuzz_score_chart(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_score_chart(bytes, "fuzz"); });
}
bool fuzz_bvh(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    Clip clip = parse_bvh(bytes, "fuzz").clip;
    if (is_z_up(clip, UpAxis::automatic, "fuzz", nullptr)) rotate_upright(clip);
    carry_by_root(clip);
    restore_trajectory(clip);
  });
}
bool fuzz_asf_amc(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const auto [asf, amc] = two_files(bytes);
    parse_asf_amc(asf, "fuzz.asf", amc, "fuzz.amc");
  });
}
bool fuzz_expmap_text(const uint8_t* data, size_t size) {
  return survive(data, size,
                 [](std::string_view bytes) { expmap_motion(parse_expmap_channels(bytes, "fuzz"), "fuzz"); });
}
bool fuzz_safetensors(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { read_safetensors(path); });
}
/// dataset.json, and after a zero byte the arrays of its first clip.
bool fuzz_dataset(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const auto [index, arrays] = two_files(bytes);
    write_file(own_folder() + "/dataset.json", index);
    const Dataset dataset = open_dataset(own_folder());
    if (!arrays.empty() && !dataset.clips.empty())
      clip_from_arrays(dataset, dataset.clips.front(), arrays_of(arrays), "fuzz");
  });
}
/// What another of two shards says of the clips that it made.
bool fuzz_shard(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    std::filesystem::create_directories(own_folder() + "/shards");
    write_file(own_folder() + "/shards/2-of-2.json", bytes);
    Dataset dataset;
    dataset.folder = own_folder();
    dataset.shard = {1, 2};
    gather_items(dataset, {});
  });
}
/// What a run that was ended has made: its lines but the first, which names the library's version. Clips and scenes are
/// those of two files that are there.
bool fuzz_unfinished(const uint8_t* data, size_t size) {
  static const std::string folder = [] {
    const std::string path = own_folder() + "/unfinished";
    for (const char* file : {"clips/a.npz", "scenes/a.glb"}) {
      std::filesystem::create_directories(std::filesystem::path(path + "/" + file).parent_path());
      write_file(path + "/" + file, "whole");
    }
    return path;
  }();
  return survive(data, size, [](std::string_view lines) {
    const nlohmann::json head = {{"version", INHABIT_VERSION}, {"job", "fuzz"}};
    write_file(folder + "/unfinished.jsonl", head.dump() + "\n" + std::string(lines));
    Dataset dataset;
    dataset.folder = folder;
    if (make_items(dataset, "fuzz", {}, {}, {}).empty()) throw Error("fuzz", "holds no item");
  });
}
/// What an import keeps to go on later.
bool fuzz_import_state(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    std::filesystem::create_directories(own_folder() + "/imported");
    write_file(own_folder() + "/imported/import.json", bytes);
    ImportState(own_folder() + "/imported", "prox");
  });
}
/// What another of two processes measured for an evaluation of four items.
bool fuzz_measured_part(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const std::string table = own_folder() + "/table.json";
    write_file(table + ".2-of-2.part", bytes);
    std::map<std::string, torch::Tensor> measured = {{"error", torch::zeros({4, 2})},
                                                     {"frames", torch::zeros({4}, torch::kInt64)}};
    MeasuredParts({1, 2}, table, "fuzz").complete({0, 1, 2, 3}, measured);
  });
}
/// One recording of a set of actions, up to the clip that training is given.
bool fuzz_motion_set(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    std::filesystem::create_directories(own_folder() + "/train/walking");
    write_file(own_folder() + "/train/walking/walking_1.txt", bytes);
    read_motion_set("cmu:" + own_folder(), 25);
  });
}
/// A data set as its owners hand it out: the format's name, a line break, and the files of its folder. It is accepted
/// where a recording, and its scene if there is one, can be imported.
bool fuzz_import(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    const size_t cut = std::min(bytes.find('\n'), bytes.size());
    const std::string folder = own_folder() + "/import";
    write_folder(folder, bytes.substr(std::min(cut + 1, bytes.size())));
    const ImportSet set = open_import_set(std::string(bytes.substr(0, cut)), folder);
    std::optional<Error> refused = Error(folder, "holds nothing that can be imported");
    for (const ImportRecording& recording : set.recordings) {
      try {
        validate(prepared_motion(set, recording).clip, recording.name);
        if (!recording.scene.empty() && set.scene) set.scene(recording);
        refused.reset();
      } catch (const Error&) {  // the next one may be whole
      }
    }
    if (refused) throw *refused;
  });
}
/// What every system does with a clip that was read: any skeleton at any rate to the standard one.
bool fuzz_retarget(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) {
    retarget(resample(parse_clip_json(bytes, "fuzz"), 30, "fuzz"), "fuzz");
  });
}
/// A configuration of any of the systems.
bool fuzz_config(const uint8_t* data, size_t size) {
  const bool forecast =
      survive(data, size, [](std::string_view text) { forecast::config_from_json(std::string(text), "fuzz"); });
  const bool anticipate =
      survive(data, size, [](std::string_view text) { anticipate::config_from_json(std::string(text), "fuzz"); });
  const bool inbetween =
      survive(data, size, [](std::string_view text) { inbetween::config_from_json(std::string(text), "fuzz"); });
  const bool interact =
      survive(data, size, [](std::string_view text) { interact::config_from_json(std::string(text), "fuzz"); });
  return forecast || anticipate || inbetween || interact;
}
bool fuzz_forecast_model(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { forecast::load_networks(path); });
}
bool fuzz_anticipate_model(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { anticipate::load_networks(path); });
}
bool fuzz_inbetween_model(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { inbetween::load_networks(path); });
}
bool fuzz_interact_model(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { interact::load_networks(path); });
}
bool fuzz_checkpoint(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) {
    torch::nn::Linear layer(3, 2);
    torch::optim::AdamW optimizer(layer->parameters(), torch::optim::AdamWOptions(1e-3));
    std::map<std::string, torch::Tensor> average;
    const auto state = load_checkpoint(path, *layer, optimizer, average);
    for (const char* key : {"step", "seconds", "best", "best_step"}) checkpoint_number(state, key, path);
  });
}
/// What is typed after --keyframes, and after a line break --joints.
bool fuzz_keyframes(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view text) {
    const size_t cut = std::min(text.find('\n'), text.size());
    inbetween::key_frames(std::string(text.substr(0, cut)), 100);
    inbetween::key_groups(std::string(text.substr(std::min(cut + 1, text.size()))));
  });
}
/// Options whose texts have a form of their own, one a line: "--keep every:30,head".
bool fuzz_option_text(const uint8_t* data, size_t size) {
  static const Clip clip = [] {
    Clip out;
    out.skeleton = expmap_skeleton(ExpmapSkeleton::cmu);
    out.joints = torch::zeros({100, out.skeleton.size(), 3});
    return out;
  }();
  const auto read_option = [](std::string_view name, const std::string& text) {
    if (name == "--keep") {
      refine::Options options;
      refine::add_kept(text, clip, options);
    } else if (name == "--row") {
      inbetween::Config config;
      inbetween::Options options;
      inbetween::take_settings(inbetween::other_settings(text).settings, config, options);
    } else if (name == "--contact") {
      inbetween::parse_contact(text, clip.skeleton);
    } else if (name == "--target") {
      inbetween::parse_target(text, clip.skeleton);
    } else if (name == "--root-path") {
      inbetween::parse_path_point(text);
    } else if (name == "--shard") {
      parse_shard(text);
    } else {
      throw Error("fuzz", "is no such option");
    }
  };
  return survive(data, size, [&](std::string_view text) {
    std::optional<Error> refused;
    if (text.empty()) refused = Error("fuzz", "holds no option");
    while (!text.empty()) {
      const std::string_view line = next_line(text);
      const size_t cut = std::min(line.find(' '), line.size());
      try {
        read_option(line.substr(0, cut), std::string(line.substr(std::min(cut + 1, line.size()))));
      } catch (const Error& error) {
        refused = error;
      }
    }
    if (refused) throw *refused;
  });
}
/// The labels of `intentions --compare`: an archive, or its arrays as pieces.
bool fuzz_labels(const uint8_t* data, size_t size) {
  static const std::vector<anticipate::Sequence> recordings = [] {
    std::vector<anticipate::Sequence> out(2);
    out[0].name = "a", out[0].action = "walk", out[0].split = "train";
    out[1].name = "b", out[1].action = "wave", out[1].split = "test";
    return out;
  }();
  return survive(data, size, [](std::string_view bytes) {
    const std::string path = own_folder() + "/labels.npz";
    write_file(path, bytes.substr(0, 2) == "PK" ? std::string(bytes) : stored_zip(pieces_of(bytes)));
    anticipate::label_agreement(path, recordings, {torch::arange(6), torch::zeros({5}, torch::kInt64)}, 30);
  });
}
bool fuzz_vposer(const uint8_t* data, size_t size) {
  return survive_file(data, size, [](const std::string& path) { read_vposer(path).decode(torch::zeros({2, 32})); });
}
/// A file of motion features: its header and, after a zero byte, what its two megabytes of numbers are over and over.
bool fuzz_motion_features(const uint8_t* data, size_t size) {
  static const size_t bytes_of_numbers = [] {
    SafeTensors all;
    nn::collect_parameters(*inbetween::MotionAutoencoder(), "", all);
    size_t sum = 0;
    for (const auto& [name, tensor] : all.tensors) sum += tensor.nbytes();
    return sum;
  }();
  return survive(data, size, [](std::string_view bytes) {
    const auto [header, pattern] = two_files(bytes);
    std::string file;
    for (int k = 0; k < 8; ++k) file += static_cast<char>(uint64_t{header.size()} >> (8 * k) & 0xFF);
    file += header;
    const size_t whole = file.size() + bytes_of_numbers;
    while (file.size() < whole) file += pattern.empty() ? std::string_view("\0", 1) : pattern;
    file.resize(whole);
    write_file(own_folder() + "/features.safetensors", file);
    inbetween::load_motion_autoencoder(own_folder() + "/features.safetensors");
  });
}
/// A series of contacts on a chair with a back rest.
bool fuzz_contact_script(const uint8_t* data, size_t size) {
  static const interact::Chair chair = [] {
    MeshBuilder builder;
    builder.box({0, 0.225, 0}, {0.25, 0.225, 0.25});
    builder.box({0, 0.65, -0.28}, {0.25, 0.2, 0.03});
    Scene scene = floor_scene();
    scene.meshes.push_back(builder.mesh("chair_0", {0.5F, 0.4F, 0.3F}));
    return interact::find_chair(scene, "chair_0");
  }();
  return survive(data, size, [](std::string_view text) { interact::parse_contact_script(text, "fuzz", chair); });
}
bool fuzz_camera(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view text) { reconstruct::parse_camera(text, "fuzz"); });
}
/// A mask of 6 by 8 pixels: an image of another size is refused before it is read.
bool fuzz_mask_png(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view bytes) { parse_mask_png(bytes, 6, 8, "fuzz"); });
}
/// What a page sends to the server.
bool fuzz_message(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view text) { serve::parse_message(text); });
}
/// Lines of a stream of poses, as `inhabit stream` takes them: names, people, times, and what is seen of them.
bool fuzz_pose_lines(const uint8_t* data, size_t size) {
  return survive(data, size, [](std::string_view text) {
    std::optional<PoseStream> stream;
    std::optional<Error> refused;
    while (!text.empty()) {
      try {
        const StreamLine line = parse_stream_line(next_line(text));
        if (const auto* joints = std::get_if<JointNames>(&line)) {
          stream.emplace(PoseStreamOptions{.names = joints->names, .parents = joints->parents, .people = 3}, 1, 0.1);
          continue;
        }
        const auto& pose = std::get<PoseLine>(line);
        if (!stream) stream.emplace(PoseStreamOptions{.people = 3}, 1, 0.1);
        stream->push(pose.person, pose.time, pose.joints);
        for (const PoseStream::Due& due : stream->take()) {
          const Clip seen = due.window->clip(30, 30);
          validate(seen, due.person);
          retarget(seen, due.person);
        }
      } catch (const Error& error) {
        refused = error;
      }
    }
    if (refused) throw *refused;
    if (!stream) throw Error("fuzz", "holds no pose");
  });
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
  for (const char* name : {"clip_npz", "smpl_model", "dataset", "motion_set", "import", "retarget", "pose_lines"})
    if (target == name) builtin_body();
}

const std::vector<FuzzTarget>& fuzz_targets() {
  static const std::vector<FuzzTarget> targets = {
      {"npz", fuzz_npz},
      {"pickle", fuzz_pickle},
      {"torch_file", fuzz_torch_file},
      {"cdf", fuzz_cdf},
      {"fbx", fuzz_fbx},
      {"clip_npz", fuzz_clip_npz},
      {"smpl_model", fuzz_smpl_model},
      {"clouds", fuzz_clouds},
      {"clip_json", fuzz_clip_json},
      {"training_log", fuzz_training_log},
      {"score_chart", fuzz_score_chart},
      {"bvh", fuzz_bvh},
      {"asf_amc", fuzz_asf_amc},
      {"expmap_text", fuzz_expmap_text},
      {"safetensors", fuzz_safetensors},
      {"dataset", fuzz_dataset},
      {"shard", fuzz_shard},
      {"unfinished", fuzz_unfinished},
      {"import_state", fuzz_import_state},
      {"measured_part", fuzz_measured_part},
      {"motion_set", fuzz_motion_set},
      {"import", fuzz_import},
      {"retarget", fuzz_retarget},
      {"config", fuzz_config},
      {"forecast_model", fuzz_forecast_model},
      {"anticipate_model", fuzz_anticipate_model},
      {"inbetween_model", fuzz_inbetween_model},
      {"interact_model", fuzz_interact_model},
      {"checkpoint", fuzz_checkpoint},
      {"keyframes", fuzz_keyframes},
      {"option_text", fuzz_option_text},
      {"labels", fuzz_labels},
      {"vposer", fuzz_vposer},
      {"motion_features", fuzz_motion_features},
      {"contact_script", fuzz_contact_script},
      {"camera", fuzz_camera},
      {"mask_png", fuzz_mask_png},
      {"message", fuzz_message},
      {"pose_lines", fuzz_pose_lines},
      {"obj", fuzz_scene<'o', 'b', 'j'>},
      {"ply", fuzz_scene<'p', 'l', 'y'>},
      {"off", fuzz_scene<'o', 'f', 'f'>},
      {"stl", fuzz_scene<'s', 't', 'l'>},
      {"glb", fuzz_scene<'g', 'l', 'b'>},
      {"gltf", fuzz_scene<'g', 'l', 't', 'f'>},
      {"scene_npz", fuzz_scene<'n', 'p', 'z'>},
      {"pcd", fuzz_scene<'p', 'c', 'd'>},
      {"xyz", fuzz_scene<'x', 'y', 'z'>},
  };
  return targets;
}
