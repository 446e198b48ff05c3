#include "inhabit/data/motion_set.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

/// A file of one recording.
struct RecordingFile {
  fs::path path;
  std::string action, split;
  double tail = 0;         // fraction at its end that goes to another split
  std::string tail_split;  // which that is
};

void add_note(Notes* notes, const std::string& text) {
  if (notes != nullptr) notes->push_back(text);
}

/// Files ACTION_N.txt of one action, in order of N.
std::vector<fs::path> numbered_files(const fs::path& folder, const std::string& action) {
  std::map<int, fs::path> found;
  std::error_code none;
  for (auto it = fs::directory_iterator(folder, none); !none && it != fs::directory_iterator(); it.increment(none)) {
    const std::string stem = it->path().stem().string();
    if (it->path().extension() != ".txt" || stem.rfind(action + "_", 0) != 0) continue;
    const std::string number = stem.substr(action.size() + 1);
    if (!number.empty() && number.size() < 6 && number.find_first_not_of("0123456789") == std::string::npos)
      found[std::stoi(number)] = it->path();
  }
  std::vector<fs::path> out;
  out.reserve(found.size());
  for (const auto& [number, path] : found) out.push_back(path);
  return out;
}

std::vector<RecordingFile> cmu_files(const fs::path& folder, Notes* notes) {
  std::vector<RecordingFile> out;
  for (const char* action : {"basketball", "basketball_signal", "directing_traffic", "jumping", "running", "soccer",
                             "walking", "washwindow"}) {
    const auto train = numbered_files(folder / "train" / action, action),
               test = numbered_files(folder / "test" / action, action);
    if (train.empty()) add_note(notes, std::string("no training file of ") + action);
    if (test.empty())
      add_note(notes,
               std::string("no test file of ") + action +
                   (train.empty() ? "" : ": the last third of " + train.back().stem().string() + " is tested on"));
    for (size_t i = 0; i < train.size(); ++i) {
      const bool last = i + 1 == train.size();
      out.push_back(
          {train[i], action, last && train.size() > 2 ? "val" : "train", last && test.empty() ? 1.0 / 3 : 0, "test"});
    }
    for (const fs::path& path : test) out.push_back({path, action, "test", 0, ""});
  }
  return out;
}

std::vector<RecordingFile> h36m_files(const fs::path& folder, Notes* notes) {
  std::vector<RecordingFile> out;
  for (const char* subject : {"S1", "S5", "S6", "S7", "S8", "S9", "S11"}) {
    const bool test = std::string(subject) == "S5";
    for (const char* action :
         {"directions", "discussion", "eating", "greeting", "phoning", "posing", "purchases", "sitting", "sittingdown",
          "smoking", "takingphoto", "waiting", "walking", "walkingdog", "walkingtogether"}) {
      const auto files = numbered_files(folder / subject, action);
      if (files.empty()) add_note(notes, std::string("no file of ") + subject + " " + action);
      for (const fs::path& path : files)
        out.push_back({path, action, test ? "test" : "train", std::string(subject) == "S11" ? 0.2 : 0, "val"});
    }
  }
  return out;
}

std::vector<ActionMotion> read_recordings(const std::vector<RecordingFile>& files, double rate, Notes* notes,
                                          const Progress& progress) {
  std::vector<ActionMotion> out;
  const auto all = static_cast<int64_t>(files.size());
  for (int64_t i = 0; i < all; ++i) {
    if (progress) progress(i, all);
    const RecordingFile& file = files[static_cast<size_t>(i)];
    Clip clip;
    try {
      const std::string path = file.path.string();
      clip = retarget(resample(read_clip(path), rate, path), path);
    } catch (const Error& e) {
      add_note(notes, std::string("left out: ") + e.what());
      continue;
    }
    const auto cut = static_cast<int64_t>(static_cast<double>(clip.frames()) * (1 - file.tail));
    const std::string name = file.path.stem().string();
    if (cut > 0) out.push_back({name, file.action, file.split, slice(clip, 0, cut)});
    if (cut < clip.frames()) out.push_back({name, file.action, file.tail_split, slice(clip, cut, clip.frames())});
  }
  if (progress) progress(all, all);
  return out;
}

std::vector<ActionMotion> read_native(const std::string& folder, double rate, const Progress& progress) {
  const Dataset data = open_dataset(folder);
  std::vector<ActionMotion> out;
  const std::vector<size_t> at_hand = clips_at_hand(data, "all");
  const auto all = static_cast<int64_t>(at_hand.size());
  for (int64_t i = 0; i < all; ++i) {
    if (progress) progress(i, all);
    const DatasetClip& entry = data.clips[at_hand[static_cast<size_t>(i)]];
    const Clip clip = load_clip(data, entry);
    std::string action = "motion";
    if (clip.action.defined() && !data.actions.empty())
      action = data.actions[static_cast<size_t>(std::get<0>(clip.action.mode()).item<int64_t>())];
    const std::string path = data.folder + "/" + entry.file;
    out.push_back({entry.file, action, entry.split, retarget(resample(clip, rate, path), path)});
  }
  if (progress) progress(all, all);
  return out;
}

}  // namespace

std::vector<ActionMotion> read_motion_set(const std::string& source, double rate, Notes* notes,
                                          const Progress& progress) {
  const auto named = [&](const char* prefix) { return source.rfind(prefix, 0) == 0; };
  std::vector<ActionMotion> out;
  if (named("cmu:"))
    out = read_recordings(cmu_files(source.substr(4), notes), rate, notes, progress);
  else if (named("h36m:"))
    out = read_recordings(h36m_files(source.substr(5), notes), rate, notes, progress);
  else
    out = read_native(source, rate, progress);
  if (out.empty()) throw Error(source, "holds no motion that can be read");
  return out;
}

namespace {

std::map<std::string, int64_t> recordings_by_action(const std::vector<ActionMotion>& motions) {
  std::map<std::string, int64_t> out;
  for (const ActionMotion& motion : motions)
    if (motion.split != "test") ++out[motion.action];
  return out;
}

}  // namespace

std::vector<ActionMotion> left_out_fold(const std::vector<ActionMotion>& motions, int64_t folds, int64_t fold) {
  if (folds < 2 || fold < 0 || fold >= folds) throw Error("folds", "are two or more, and one of them is left out");
  const std::map<std::string, int64_t> count = recordings_by_action(motions);
  std::map<std::string, int64_t> next;
  std::vector<ActionMotion> out;
  for (const ActionMotion& motion : motions) {
    if (motion.split == "test") continue;
    const int64_t all = count.at(motion.action), number = next[motion.action]++;
    int64_t validated = (fold + 1) % all;
    while (all >= 3 && validated % folds == fold) validated = (validated + 1) % all;
    out.push_back(motion);
    out.back().split = number % folds == fold ? "left_out" : all >= 3 && number == validated ? "val" : "train";
  }
  return out;
}

int64_t single_folds(const std::vector<ActionMotion>& motions) {
  int64_t most = 0;
  for (const auto& [action, count] : recordings_by_action(motions)) most = std::max(most, count);
  return std::max<int64_t>(most, 2);
}

}  // namespace inhabit
