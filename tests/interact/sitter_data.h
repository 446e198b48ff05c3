#pragma once
#include <string>

#include "inhabit/data/native.h"
#include "interact/sitter.h"

/// A data set in `folder`: a Sitter for each of train, val and test, each with a scene of its own.
inline std::string write_sitters(const std::string& folder) {
  inhabit::Dataset data = inhabit::create_dataset(folder, Sitter().clip.action_names);
  for (const char* split : {"train", "val", "test"}) {
    const std::string scene = std::string("scenes/") + split + ".glb";
    inhabit::write_scene(data, scene, seat_scene());
    inhabit::DatasetClip entry{std::string("clips/") + split + ".npz", scene, split, 0, ""};
    inhabit::write_clip(data, entry, Sitter().clip);
    data.clips.push_back(entry);
  }
  inhabit::write_index(data);
  return folder;
}
