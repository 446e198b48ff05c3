#pragma once
#include "forecast/walker.h"
#include "inhabit/data/native.h"

/// A data set in `folder`: for each of train, val and test a clip of 120 frames who goes at 1.2 m/s in one pose through
/// a room of its own, the path of walker(); one clip more, of training, has no scene. @param source the recording that
/// they are said to be of; empty: generated
inline std::string write_walkers(const std::string& folder, double rate = 30, double swing = 0,
                                 const std::string& source = "") {
  inhabit::Dataset data = inhabit::create_dataset(folder, {});
  data.rate = rate;
  int number = 0;
  const auto add = [&](const std::string& split, const std::string& scene) {
    inhabit::DatasetClip entry{"clips/" + std::to_string(number) + ".npz", scene, split, 0, source};
    inhabit::Clip clip = walker(120, 1.2, 0.9 * number, swing);
    clip.rate = rate;
    inhabit::write_clip(data, entry, clip);
    data.clips.push_back(entry);
    ++number;
  };
  for (const char* split : {"train", "val", "test"}) {
    const std::string scene = std::string("scenes/") + split + ".glb";
    inhabit::write_scene(data, scene, inhabit::floor_scene());
    add(split, scene);
  }
  add("train", "");
  inhabit::write_index(data);
  return folder;
}
