#include <filesystem>
#include <memory>

#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/data/motion_set.h"
#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"

namespace fs = std::filesystem;

namespace inhabit {

void add_motion_set(ImportSet& set, const std::string& source) {
  Notes notes;
  const auto motions = std::make_shared<std::map<std::string, ActionMotion>>();
  try {
    for (ActionMotion& motion : read_motion_set(source, 30, &notes)) {
      std::string name = motion.split + "/" + motion.name;
      while (motions->count(name) != 0) name += "_";
      set.recordings.push_back({.name = name, .split = motion.split, .action = motion.action});
      if (std::find(set.actions.begin(), set.actions.end(), motion.action) == set.actions.end())
        set.actions.push_back(motion.action);
      motions->emplace(name, std::move(motion));
    }
  } catch (const Error& e) {
    set.missing.emplace_back(e.what());
  }
  static const std::string kLeftOut = "left out: ";
  for (const std::string& note : notes) {
    const bool broken = note.rfind(kLeftOut, 0) == 0;
    (broken ? set.broken : set.missing).push_back(broken ? note.substr(kLeftOut.size()) : note);
  }
  set.splits = "the paper's";
  set.read = [motions](const ImportRecording& r) { return ImportedMotion{motions->at(r.name).clip, {}}; };
}

// Of the paper: train/ACTION/ACTION_N.txt and test/ACTION/ACTION_N.txt (motion_set.h). Of mocap.cs.cmu.edu:
// SUBJECT/SUBJECT_N.amc with SUBJECT.asf beside.
ImportSet open_cmu(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  if (fs::is_directory(folder + "/train") || fs::is_directory(folder + "/test")) {
    add_motion_set(set, "cmu:" + folder);
    return set;
  }
  for (const std::string& path : files_below(folder, [](const std::string& f) { return extension_of(f) == "amc"; })) {
    const std::string name = name_below(folder, path);
    const std::string stem = fs::path(path).stem().string();
    set.recordings.push_back({.name = name, .person = stem.substr(0, stem.find('_'))});
  }
  if (set.recordings.empty()) set.missing.emplace_back("train/ and test/ (text), or SUBJECT/SUBJECT_N.amc");
  set.read = [folder, reading](const ImportRecording& r) {
    return ImportedMotion{read_clip(folder + "/" + r.name + ".amc", reading), {}};
  };
  return set;
}

}  // namespace inhabit
