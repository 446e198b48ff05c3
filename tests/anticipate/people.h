#pragma once
#include <cmath>

#include "forecast/walker.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/data/native.h"

/// Somebody of the built-in body at 25 frames a second: "walk" goes on at 1 m/s with swinging limbs, a step a second,
/// "wave" stands and waves the right arm. People differ by `number`, in phase and heading.
inline inhabit::Clip person(const std::string& action, int64_t frames, int number = 0) {
  const int64_t skipped = 7 * number % 25;
  inhabit::Clip clip = walker(frames + skipped, action == "walk" ? 1.2 : 0.0, 0.8 * number, action == "walk" ? 1 : 0);
  if (action == "wave") {
    const torch::Tensor t = torch::arange(frames + skipped).to(torch::kFloat32) / 25;
    clip.rotations.select(1, 17).select(1, 2).copy_(0.2 + 0.5 * torch::sin(7 * t));
    clip.rotations.select(1, 19).select(1, 1).copy_(0.8 + 0.4 * torch::sin(7 * t + 1));
    clip.joints = inhabit::joint_positions(clip.skeleton, clip.rotations, clip.trans);
  }
  clip.rate = 25;
  return inhabit::slice(clip, skipped, skipped + frames);
}

/// Recordings of both actions, two of each.
inline std::vector<inhabit::anticipate::Sequence> people(int64_t frames) {
  std::vector<inhabit::anticipate::Sequence> out;
  for (const char* action : {"walk", "wave"})
    for (int number = 0; number < 2; ++number)
      out.push_back({std::string(action) + "_" + std::to_string(number), action,
                     inhabit::anticipate::joint_features(person(action, frames, number).joints)});
  return out;
}

/// A native data set in `folder` with recordings of both actions in every split: two to train on, a short one to
/// validate, with room for one window, and one to test.
inline std::string write_people(const std::string& folder, int64_t frames) {
  inhabit::Dataset data = inhabit::create_dataset(folder, {"walk", "wave"});
  data.rate = 25;
  int number = 0;
  for (const char* split : {"train", "train", "val", "test"})
    for (int64_t action = 0; action < 2; ++action) {
      inhabit::DatasetClip entry{"clips/" + std::to_string(number) + ".npz", "", split, 0, ""};
      const int64_t length = std::min<int64_t>(frames, std::string(split) == "val" ? 20 : frames);
      inhabit::Clip clip = person(data.actions[static_cast<size_t>(action)], length, number++);
      clip.action_names = data.actions;
      clip.action = torch::full({length}, action, torch::kInt64);
      inhabit::write_clip(data, entry, clip);
      data.clips.push_back(entry);
    }
  inhabit::write_index(data);
  return folder;
}
