#include "inhabit/interact/reseat_set.h"

#include <exception>
#include <filesystem>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/interact/reseat.h"
#include "inhabit/interact/seated.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/chairs.h"

namespace inhabit::interact {
namespace {

/// A chair that clips are carried over to, the only object of its scene.
struct NewChair {
  Scene scene;
  std::string name;
};

/// The one chair of a file, under the name chair_0.
NewChair read_chair(const std::string& file) {
  Scene scene = read_scene_file(file).scene;
  std::erase_if(scene.meshes, [](const Mesh& mesh) { return mesh.faces.numel() == 0; });
  if (scene.meshes.empty()) throw Error(file, "has no mesh");
  for (size_t m = 0; m < scene.meshes.size(); ++m)
    scene.meshes[m].name = m == 0 ? "chair_0" : "chair_0." + std::to_string(m);
  scene.name = file;
  try {
    find_chair(scene, "chair_0");
  } catch (const Error& error) {
    throw Error(file, error.what());
  }
  return {scene, "chair_0"};
}

NewChair drawn_chair(std::mt19937_64& random) {
  Room room;
  room.furniture.push_back(draw_chair(random));
  return {room.scene(), room.object_name(0)};
}

enum class Outcome { made, nobody_sits, no_fit };

struct Made {
  Outcome outcome = Outcome::no_fit;
  DatasetClip entry;
  int64_t contacts = 0;
};

Made make_one(const Dataset& from, const Dataset& out, const std::vector<NewChair>& files, const DatasetClip& source,
              int64_t index, uint64_t seed) {
  constexpr int kChairsTried = 8;
  Made made;
  if (source.scene.empty()) return made;
  const Clip clip = load_clip(from, source);
  const Scene scene = load_scene(from, source.scene);
  if (stays_of(clip).empty() || !chair_of(clip, scene)) {
    made.outcome = Outcome::nobody_sits;
    return made;
  }
  std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(index)));
  for (int attempt = 0; attempt < kChairsTried; ++attempt) {
    const NewChair chair = files.empty() ? drawn_chair(random) : files[random() % files.size()];
    std::optional<Reseated> found;
    try {
      found = reseat(clip, scene, chair.scene, chair.name, false);
    } catch (const Error&) {
      continue;  // no place for a hand, or a stool too small to be a seat
    }
    if (!found->good()) continue;
    made.entry = {numbered("clips/", index, ".npz"), numbered("scenes/reseated_", index, ".glb"), source.split, 0,
                  source.source};
    write_scene(out, made.entry.scene, found->scene);
    write_clip(out, made.entry, found->clip);
    made.outcome = Outcome::made;
    made.contacts = found->contacts;
    return made;
  }
  return made;
}

}  // namespace

ReseatResult reseat_dataset(const std::string& from, const std::string& folder, const ReseatOptions& options) {
  const Dataset source = open_dataset(from);
  const std::vector<DatasetClip> clips = source.split(options.split);
  if (clips.empty()) throw Error(from, "has no clips in split \"" + options.split + "\"");
  std::vector<NewChair> files;
  for (const std::string& file : options.chairs) files.push_back(read_chair(file));
  ReseatResult result;
  result.dataset = create_dataset(folder, source.actions);
  result.dataset.rate = source.rate;
  nlohmann::json names = nlohmann::json::array();
  for (const std::string& file : options.chairs) names.push_back(std::filesystem::path(file).filename().string());
  result.dataset.provenance = {{"command", "inhabit synth reseat"},
                               {"seed", options.seed},
                               {"split", options.split},
                               {"chairs", names},
                               {"of", source.provenance}};
  std::vector<Made> made(clips.size());
  std::exception_ptr failed;
  int64_t done = 0;
#pragma omp parallel for schedule(dynamic)
  for (size_t i = 0; i < clips.size(); ++i) {
    try {
      const torch::NoGradGuard no_gradient;
      made[i] = make_one(source, result.dataset, files, clips[i], static_cast<int64_t>(i), options.seed);
    } catch (...) {
#pragma omp critical(inhabit_reseat)
      failed = std::current_exception();
    }
#pragma omp critical(inhabit_reseat)
    if (options.progress) options.progress(++done, static_cast<int64_t>(clips.size()));
  }
  if (failed) std::rethrow_exception(failed);
  for (Made& one : made) {
    result.nobody_sits += one.outcome == Outcome::nobody_sits ? 1 : 0;
    result.no_fit += one.outcome == Outcome::no_fit ? 1 : 0;
    if (one.outcome != Outcome::made) continue;
    result.contacts += one.contacts;
    result.dataset.clips.push_back(std::move(one.entry));
  }
  if (result.dataset.clips.empty()) throw Error(from, "has no clip that could be carried over to another chair");
  write_index(result.dataset);
  return result;
}

}  // namespace inhabit::interact
