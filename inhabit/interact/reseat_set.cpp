#include "inhabit/interact/reseat_set.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <numeric>
#include <optional>

#include "inhabit/data/dataset_items.h"
#include "inhabit/error.h"
#include "inhabit/interact/seated.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/random.h"
#include "inhabit/metrics/foot_skating.h"
#include "inhabit/scene/objects.h"
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
  std::erase_if(scene.meshes, [](const Mesh& mesh) { return mesh.faces.numel() == 0 || is_floor(mesh.name); });
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

/// A chair stretched or shrunk by up to an eighth along each of its own axes.
NewChair rescaled_chair(const Scene& scene, const Chair& chair, std::mt19937_64& random) {
  Eigen::Isometry3d to_chair = chair.frame.inverse();
  Eigen::Matrix3d scale = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) scale(i, i) = uniform(random, 0.88, 1.125);
  const Eigen::Matrix3d change = chair.frame.linear() * scale * to_chair.linear();
  const Eigen::Vector3d origin = chair.frame.translation();
  torch::Tensor by = torch::empty({3, 3}), about = torch::empty({3});
  for (int r = 0; r < 3; ++r) {
    about[r] = origin[r];
    for (int c = 0; c < 3; ++c) by[r][c] = change(r, c);
  }
  NewChair out{{}, chair.name};
  out.scene.name = scene.name;
  for (const Mesh& mesh : scene.meshes) {
    if (object_of_mesh(mesh.name) != chair.name) continue;
    out.scene.meshes.push_back(mesh);
    out.scene.meshes.back().vertices = torch::matmul(mesh.vertices - about, by.t()) + about;
  }
  return out;
}

struct Made {
  bool nobody_sits = false;
  std::string fault;  ///< empty: made
  DatasetClip entry;
  int64_t contacts = 0;
  ReseatFit fit;
  FootSkating before, after;
};

/// ReseatFit's, in order.
constexpr std::array kFit = {&ReseatFit::hand_gap, &ReseatFit::pelvis_gap, &ReseatFit::depth, &ReseatFit::elsewhere,
                             &ReseatFit::slide,    &ReseatFit::beyond,     &ReseatFit::bent};

DatasetItem to_item(const Made& made) {
  DatasetItem out;
  if (!made.nobody_sits && made.fault.empty()) out.clips = {made.entry};
  nlohmann::json fit = nlohmann::json::array();
  for (const auto member : kFit) fit.push_back(made.fit.*member);
  out.facts = {{"nobody_sits", made.nobody_sits},
               {"fault", made.fault},
               {"contacts", made.contacts},
               {"fit", fit},
               {"before", {made.before.frames, made.before.skating}},
               {"after", {made.after.frames, made.after.skating}}};
  return out;
}

Made from_item(const DatasetItem& item) {
  const nlohmann::json& facts = item.facts;
  Made out;
  out.nobody_sits = facts.at("nobody_sits");
  out.fault = facts.at("fault");
  out.contacts = facts.at("contacts");
  for (size_t k = 0; k < kFit.size(); ++k) out.fit.*kFit[k] = facts.at("fit").at(k);
  out.before = {facts.at("before").at(0), facts.at("before").at(1)};
  out.after = {facts.at("after").at(0), facts.at("after").at(1)};
  if (!item.clips.empty()) out.entry = item.clips.front();
  return out;
}

class ReseatJob {
 public:
  ReseatJob(const Dataset& from, const Dataset& out, const ReseatOptions& options)
      : from_(from), out_(out), options_(options) {
    for (const std::string& file : options.files) files_.push_back(read_chair(file));
    if (options.chairs == NewChairs::files && files_.empty()) throw Error("chairs", "names no file");
  }

  Made make(const DatasetClip& source, int64_t index) const {
    constexpr int kSolved = 8, kDrawn = 48;
    Made made;
    made.nobody_sits = true;
    if (source.scene.empty()) return made;
    const Clip clip = load_clip(from_, source);
    const Scene scene = load_scene(from_, source.scene);
    const auto chair = stays_of(clip).empty() ? std::nullopt : chair_of(clip, scene);
    if (!chair) return made;
    made.nobody_sits = false;
    made.fault = "no place for what a hand touches";
    std::mt19937_64 random(item_seed(options_.seed, static_cast<uint64_t>(index)));
    for (int drawn = 0, solved = 0; drawn < kDrawn && solved < kSolved; ++drawn) {
      const NewChair next = options_.chairs == NewChairs::files        ? files_[random() % files_.size()]
                            : options_.chairs == NewChairs::procedural ? drawn_chair(random)
                                                                       : rescaled_chair(scene, *chair, random);
      std::optional<Reseated> found;
      try {
        found = reseat(clip, scene, next.scene, next.name, {false, options_.frame_by_frame});
      } catch (const Error&) {
        continue;  // no place for a hand, or a stool too small to be a seat
      }
      ++solved;
      made.fault = found->fit.fault();
      if (!made.fault.empty()) continue;
      write(source, index, clip, *found, made);
      return made;
    }
    return made;
  }

 private:
  void write(const DatasetClip& source, int64_t index, const Clip& before, const Reseated& found, Made& made) const {
    made.entry = {numbered("clips/", index, ".npz"), numbered("scenes/reseated_", index, ".glb"), source.split, 0,
                  source.source};
    write_scene(out_, made.entry.scene, found.scene);
    write_clip(out_, made.entry, found.clip);
    made.contacts = found.contacts;
    made.fit = found.fit;
    made.before = foot_skating(before);
    made.after = foot_skating(found.clip);
  }

  const Dataset& from_;
  const Dataset& out_;
  const ReseatOptions& options_;
  std::vector<NewChair> files_;
};

nlohmann::json provenance_of(const Dataset& source, const ReseatOptions& options) {
  nlohmann::json chairs = nlohmann::json::array();
  for (const std::string& file : options.files) chairs.push_back(std::filesystem::path(file).filename().string());
  if (options.chairs != NewChairs::files) chairs = options.chairs == NewChairs::procedural ? "procedural" : "rescaled";
  return {{"command", "inhabit synth reseat"},
          {"seed", options.seed},
          {"split", options.split},
          {"chairs", chairs},
          {"frame_by_frame", options.frame_by_frame},
          {"of", source.provenance}};
}

void collect(const DatasetItems& made, ReseatResult& result) {
  FootSkating before, after;
  for (const auto& [index, item] : made) {
    const Made one = from_item(item);
    ++result.clips;
    result.nobody_sits += one.nobody_sits ? 1 : 0;
    if (one.nobody_sits) continue;
    if (!one.fault.empty()) {
      ++result.no_fit[one.fault];
      continue;
    }
    result.contacts += one.contacts;
    result.fits.push_back(one.fit);
    before.frames += one.before.frames, before.skating += one.before.skating;
    after.frames += one.after.frames, after.skating += one.after.skating;
  }
  result.skating_before = before.fraction();
  result.skating = after.fraction();
}

}  // namespace

ReseatResult reseat_dataset(const std::string& from, const std::string& folder, const ReseatOptions& options) {
  const Dataset source = open_dataset(from);
  const std::vector<DatasetClip> clips = source.split(options.split);
  if (clips.empty()) throw Error(from, "has no clips in split \"" + options.split + "\"");
  ReseatResult result;
  const ReseatJob job(source, result.dataset, options);  // reads the chairs before a folder is made
  result.dataset = create_dataset(folder, source.actions);
  result.dataset.rate = source.rate;
  result.dataset.provenance = provenance_of(source, options);
  nlohmann::json work = result.dataset.provenance;
  work["from"] = from;
  work["files"] = options.files;
  for (const DatasetClip& clip : clips) work["of_clips"].push_back({clip.file, clip.frames, clip.source});
  std::vector<int64_t> all(clips.size());
  std::iota(all.begin(), all.end(), 0);
  collect(make_items(result.dataset, work, all, options.progress,
                     [&](int64_t i) {
                       const torch::NoGradGuard no_gradient;
                       return to_item(job.make(clips[static_cast<size_t>(i)], i));
                     }),
          result);
  if (result.dataset.clips.empty()) {
    std::error_code ignored;
    for (const char* part : {"clips", "scenes", ""})  // where these are empty
      std::filesystem::remove(std::filesystem::path(folder) / part, ignored);
    throw Error(from, "has no clip that could be carried over: " + summary(result));
  }
  finish_items(result.dataset);
  return result;
}

std::string summary(const ReseatResult& result) {
  int64_t unfit = 0;
  std::string why;
  for (const auto& [fault, count] : result.no_fit) {
    unfit += count;
    why += fmt::format("{}{} {}", why.empty() ? " (" : ", ", count, fault);
  }
  std::string out = fmt::format("left out: {} clips in which nobody sits, {} that fit no chair{}", result.nobody_sits,
                                unfit, why.empty() ? "" : why + ")");
  if (result.fits.empty()) return out;
  const auto figures = [&](const char* name, double ReseatFit::*value) {
    std::vector<double> all;
    for (const ReseatFit& fit : result.fits) all.push_back(100 * (fit.*value));
    std::sort(all.begin(), all.end());
    return fmt::format("{} {:.2f} (at most {:.2f})", name, all[all.size() / 2], all.back());
  };
  return fmt::format("{} of {} clips with a seated person carried over, {} hand contacts; {}\n", result.fits.size(),
                     result.clips - result.nobody_sits, result.contacts, out) +
         fmt::format(
             "cm, median and largest of the clips: {}, {}, {}, {}; foot skating {:.2f} % of frames before, "
             "{:.2f} % after",
             figures("palm to contact", &ReseatFit::hand_gap), figures("skin to seat", &ReseatFit::pelvis_gap),
             figures("depth", &ReseatFit::depth), figures("standing feet moved", &ReseatFit::slide),
             100 * result.skating_before, 100 * result.skating);
}

}  // namespace inhabit::interact
