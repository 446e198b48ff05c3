#include "inhabit/view/file_cards.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/view/charts.h"

namespace inhabit {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostCards = 200;
constexpr double kCardRate = 15, kCardSeconds = 60;

/// What a thumbnail needs: joints, at most a minute of them, some fifteen a second.
PagePerson figure_of(const Clip& clip, std::string name) {
  const int64_t step = std::max<int64_t>(1, std::llround(clip.rate / kCardRate));
  const int64_t frames = std::min(clip.frames(), static_cast<int64_t>(std::ceil(kCardSeconds * clip.rate)));
  PagePerson person;
  person.name = std::move(name);
  person.clip.skeleton = clip.skeleton;
  person.clip.rate = clip.rate / static_cast<double>(step);
  person.clip.joints = clip.joints.slice(0, 0, frames, step);
  return person;
}

PageCard motion_card(const Clip& clip, const std::string& name) {
  PageCard card;
  card.name = name;
  card.note = fmt::format("{:.1f} s, {:g} frames a second, {} joints", clip.seconds(), clip.rate, clip.skeleton.size());
  if (clip.seconds() > kCardSeconds) card.note += fmt::format("; the first {:g} s", kCardSeconds);
  card.person = figure_of(clip, name);
  return card;
}

PageCard scene_card(Scene scene, const std::string& name) {
  int64_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.faces.defined() ? mesh.faces.size(0) : 0;
  const int64_t points = scene.points.defined() ? scene.points.size(0) : 0;
  PageCard card;
  card.name = name;
  card.note =
      fmt::format("{} mesh{}, {} triangles", scene.meshes.size(), scene.meshes.size() == 1 ? "" : "es", triangles);
  if (points > 0) card.note += fmt::format(", {} points", points);
  card.scene = std::make_shared<const Scene>(std::move(scene));
  return card;
}

PageCard chart_card(PageChart chart, const std::string& name, const char* what) {
  PageCard card;
  card.name = name;
  card.note = what;
  card.chart = std::move(chart);
  return card;
}

PageCard card_of(const std::string& path, const std::string& name, const ClipReadOptions& reading, Notes& notes) {
  const std::string extension = extension_of(path);
  if (extension == "jsonl") return chart_card(read_training_log(path), name, "training log");
  if (extension == "json" && is_score_table(path)) return chart_card(read_score_chart(path), name, "evaluation");
  const bool motion = is_clip_file(path);
  if (!motion && is_scene_extension(extension)) return scene_card(read_scene_file(path).scene, name);
  if (!motion) throw Error(path, "is no motion, scene, training log, evaluation or scores");
  const std::vector<Clip> clips = read_for_view(path, reading, notes);
  PageCard card = motion_card(clips.front(), name);
  if (clips.size() > 1) card.note += ", the first of " + std::to_string(clips.size());
  return card;
}

/// Whether a file in a folder is worth a try: what else lies there needs no word.
bool may_be_shown(const fs::path& path) {
  const std::string extension = extension_of(path.string());
  if (extension == "npz" || extension == "npy" || extension == "jsonl" || is_scene_extension(extension)) return true;
  return extension == "bvh" || extension == "amc" || extension == "txt" || extension == "json";
}

/// Whether a file of this extension that cannot be shown need not be damaged.
bool may_be_anything(const fs::path& path) {
  const std::string extension = extension_of(path.string());
  return extension == "txt" || extension == "json";
}

void add_data_set(std::vector<PageCard>& cards, const std::string& folder, Notes& notes) {
  const Dataset data = open_dataset(folder);
  std::map<std::string, std::shared_ptr<const Scene>> scenes;
  for (const DatasetClip& entry : data.clips) {
    if (cards.size() == kMostCards) break;
    PageCard card = motion_card(load_clip(data, entry), entry.file);
    if (!entry.scene.empty()) {
      auto& scene = scenes[entry.scene];
      if (scene == nullptr) scene = std::make_shared<const Scene>(load_scene(data, entry.scene));
      card.scene = scene;
      card.note += ", in " + entry.scene;
    }
    cards.push_back(std::move(card));
  }
  if (cards.size() < data.clips.size())
    notes.push_back(fmt::format("{}: the first {} of {} clips", folder, cards.size(), data.clips.size()));
}

void add_folder(std::vector<PageCard>& cards, const std::string& folder, const ClipReadOptions& reading, Notes& notes,
                std::vector<std::string>& all_skipped) {
  if (fs::exists(fs::path(folder) / "dataset.json")) return add_data_set(cards, folder, notes);
  std::vector<fs::path> files;
  std::error_code failed;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, failed), end;
  for (; !failed && at != end; at.increment(failed))
    if (at->is_regular_file(failed) && may_be_shown(at->path())) files.push_back(at->path());
  if (failed) throw Error(folder, "cannot be read: " + failed.message());
  std::sort(files.begin(), files.end());
  const size_t before = cards.size();
  std::vector<std::string> skipped;
  size_t tried = 0, others = 0;
  for (const fs::path& file : files) {
    if (cards.size() == kMostCards) break;
    ++tried;
    try {
      Notes own;  // what was detected in each of many files is more than one wants to read
      cards.push_back(card_of(file.string(), file.lexically_relative(folder).string(), reading, own));
    } catch (const Error& e) {
      if (may_be_anything(file))
        ++others;
      else
        skipped.emplace_back(e.what());
    }
  }
  if (cards.size() == before) {
    const std::string why =
        skipped.empty() ? "" : fmt::format(" ({} tried; skipped {})", skipped.size(), skipped.front());
    throw Error(folder, "holds nothing that can be shown" + why);
  }
  if (others > 0) notes.push_back(fmt::format("{}: {} .txt and .json files that show nothing", folder, others));
  all_skipped.insert(all_skipped.end(), skipped.begin(), skipped.end());
  if (tried < files.size()) notes.push_back(fmt::format("{}: the first {} of {} files", folder, tried, files.size()));
}

}  // namespace

bool is_shown_as_cards(const std::string& path) {
  const std::string extension = extension_of(path);
  return fs::is_directory(path) || extension == "jsonl" ||
         (extension == "json" && fs::exists(path) && is_score_table(path));
}

std::vector<Clip> read_for_view(const std::string& path, const ClipReadOptions& reading, Notes& notes) {
  Notes own;
  std::vector<Clip> clips = read_clips(path, reading, &own);
  add_notes(notes, std::move(own), path);
  for (Clip& clip : clips) clip = retarget_if_known(clip, path);
  return clips;
}

std::string cards_title(const std::vector<std::string>& paths) {
  const fs::path first = fs::path(paths.front()).lexically_normal();
  const std::string title = (first.has_filename() ? first : first.parent_path()).filename().string();
  return paths.size() == 1 ? title : fmt::format("{} and {} more", title, paths.size() - 1);
}

std::vector<PageCard> cards_of(const std::vector<std::string>& paths, const ClipReadOptions& reading, Notes& notes,
                               std::vector<std::string>& skipped) {
  std::vector<PageCard> cards;
  for (const std::string& path : paths) {
    if (fs::is_directory(path))
      add_folder(cards, path, reading, notes, skipped);
    else
      cards.push_back(card_of(path, fs::path(path).filename().string(), reading, notes));
  }
  return cards;
}

}  // namespace inhabit
