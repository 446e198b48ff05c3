// Protects motion from being lost between files: whatever carries it (the root, a joint below the root, limbs that
// translate) is in every format that is written, and comes back from every one that is read. Truth is worked out from
// the first file alone (plain_kinematics.h).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "animator.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/bvh.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "io/plain_kinematics.h"
#include "io/replaced.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

Places places_in(const std::string& path) {
  const std::string extension = path.substr(path.rfind('.') + 1);
  if (extension == "npz") return places_in_npz(read_npz(path));
  const std::string text = read_whole_file(path);
  if (extension == "json") return places_in_json(text);
  if (extension == "glb") return places_in_glb(text);
  return places_in_bvh(text);
}

Places scaled(Places places, double scale) {
  for (auto& [name, path] : places)
    for (Eigen::Vector3d& place : path) place *= scale;
  return places;
}

/// Largest distance between two files' joints of one name, over all frames; `but` is left out. End sites that one file
/// lacks do not count.
double farthest(const Places& truth, const Places& found, const std::string& but = "") {
  double most = 0;
  size_t compared = 0;
  for (const auto& [name, path] : truth) {
    const auto other = found.find(name);
    if (name == but || (other == found.end() && name.find("_end") != std::string::npos)) continue;
    if (other == found.end() || other->second.size() != path.size()) return 1e9;
    ++compared;
    for (size_t f = 0; f < path.size(); ++f) most = std::max(most, (other->second[f] - path[f]).norm());
  }
  return compared > 3 ? most : 1e9;
}

double travelled(const std::vector<Eigen::Vector3d>& path) {
  double sum = 0;
  for (size_t f = 1; f < path.size(); ++f) sum += (path[f] - path[f - 1]).norm();
  return sum;
}

Places clip_places(const Clip& clip) {
  Places out;
  for (int64_t t = 0; t < clip.frames(); ++t)
    for (int j = 0; j < clip.skeleton.size(); ++j) {
      const torch::Tensor p = clip.joints[t][j].to(torch::kDouble);
      out[clip.skeleton.names[static_cast<size_t>(j)]].emplace_back(p[0].item<double>(), p[1].item<double>(),
                                                                    p[2].item<double>());
    }
  return out;
}

/// Writes `first` in every format, reads these and writes them in every format again: all hold `truth` (metres).
void expect_kept_everywhere(const TempFolder& folder, const std::string& first, const Places& truth,
                            const std::string& but) {
  const Clip clip = read_clip(first);
  EXPECT_LT(farthest(truth, clip_places(clip), but), 1e-4);
  for (const std::string one : {"bvh", "npz", "json", "glb"}) {
    Clip plain = clip;
    plain.file = {};  // centimetres, +Y up
    const std::string path = folder / ("one." + one);
    write_clip(path, plain);
    const double unit = one == "bvh" ? 0.01 : 1;
    EXPECT_LT(farthest(truth, scaled(places_in(path), unit), but), 1e-4) << one;
    Clip again = read_clip(path);
    EXPECT_LT(farthest(truth, clip_places(again), but), 1e-4) << one;
    EXPECT_LT((again.root_path() - clip.root_path()).norm(2, {1}).max().item<double>(), 1e-4) << one;
    EXPECT_EQ(again.translations.defined(), clip.translations.defined()) << one;
    again.file = {};
    for (const std::string two : {"bvh", "npz", "json", "glb"}) {
      write_clip(folder / ("two." + two), again);
      const double scale = two == "bvh" ? 0.01 : 1;
      EXPECT_LT(farthest(truth, scaled(places_in(folder / ("two." + two)), scale), but), 1e-4) << one << " " << two;
    }
  }
}

}  // namespace

TEST(RoundTrip, AJointBelowTheRootMayCarryTheBody) {
  const TempFolder folder;
  AnimatorFile file;
  file.world_root = true;
  file.frames = 40;
  write_atomically(folder / "walk.bvh", file.text());
  const Places truth = scaled(places_in_bvh(file.text()), 0.01);
  Notes notes;
  const Clip clip = read_clip(folder / "walk.bvh", {}, &notes);
  EXPECT_THAT(notes, testing::Contains(HasSubstr("the root goes where Hips")));
  EXPECT_FALSE(clip.translations.defined()) << "all other bones are rigid";
  const int hips = clip.skeleton.find("Hips");
  EXPECT_NEAR(clip.skeleton.offsets[hips][1].item<double>(), 0.9, 0.03) << "the root goes along below the hips";
  EXPECT_NEAR((clip.trans[39] - clip.trans[0]).norm().item<double>(),
              (truth.at("Hips")[39] - truth.at("Hips")[0]).norm(), 1e-4);
  EXPECT_GT(travelled(truth.at("Hips")), 0.7);
  EXPECT_EQ(clip.file.carrier, hips);
  expect_kept_everywhere(folder, folder / "walk.bvh", truth, "joint_Root");

  // Written as it was read, the root stands again and everything is where it was.
  write_clip(folder / "same.bvh", clip);
  EXPECT_LT(farthest(truth, scaled(places_in(folder / "same.bvh"), 0.01)), 1e-4);
  const std::string written = read_whole_file(folder / "same.bvh"), text = file.text();
  const auto words = [](const std::string& whole, const std::string& word) {
    size_t count = 0;
    for (size_t at = whole.find(word); at != std::string::npos; at = whole.find(word, at + 1)) ++count;
    return count;
  };
  for (const char* word : {"JOINT", "End Site", "CHANNELS 6"})
    EXPECT_EQ(words(written, word), words(text, word)) << word;

  // On the standard skeleton the pelvis travels too.
  const Clip standard = retarget(clip, "walk.bvh");
  EXPECT_LT((standard.root_path() - clip.joints.select(1, hips)).norm(2, {1}).max().item<double>(), 1e-5);
}

TEST(RoundTrip, LimbsMayTranslate) {
  const TempFolder folder;
  for (const bool world_root : {false, true}) {
    AnimatorFile file;
    file.stretching = true;
    file.world_root = world_root;
    file.frames = 40;
    write_atomically(folder / "walk.bvh", file.text());
    const Places truth = scaled(places_in_bvh(file.text()), 0.01);
    const Clip clip = read_clip(folder / "walk.bvh");
    ASSERT_TRUE(clip.translations.defined());
    expect_kept_everywhere(folder, folder / "walk.bvh", truth, world_root ? "joint_Root" : "");
    write_clip(folder / "same.bvh", clip);
    EXPECT_LT(farthest(truth, scaled(places_in(folder / "same.bvh"), 0.01)), 1e-4);
    // Half the frames, and a part of them, are those of the file.
    const Clip slow = resample(clip, 30);
    EXPECT_LT((slow.joints[7] - clip.joints[14]).norm(2, {1}).max().item<double>(), 1e-4);
    EXPECT_EQ(slice(clip, 3, 9).translations.size(0), 6);
  }
}

TEST(RoundTrip, TheCarrierMayHaveSiblings) {
  // Game skeletons keep targets of inverse kinematics beside the pelvis: these stay where they are.
  const TempFolder folder;
  AnimatorFile file;
  file.world_root = true;
  file.frames = 30;
  const std::string text = replaced(file.text(), "  JOINT Hips\n",
                                    "  JOINT ik_hand\n  {\n    OFFSET 30 100 0\n    CHANNELS 0\n    End Site\n    {\n"
                                    "      OFFSET 0 5 0\n    }\n  }\n  JOINT Hips\n");
  write_atomically(folder / "walk.bvh", text);
  const Clip clip = read_clip(folder / "walk.bvh");
  EXPECT_GT((clip.trans[29] - clip.trans[0]).norm().item<double>(), 0.5);
  const Places truth = scaled(places_in_bvh(text), 0.01);
  EXPECT_LT(farthest(truth, clip_places(clip), "joint_Root"), 1e-4);
  write_clip(folder / "same.bvh", clip);
  EXPECT_LT(farthest(truth, scaled(places_in(folder / "same.bvh"), 0.01)), 1e-4);
}

TEST(RoundTrip, JointsThatStandMayLieBetweenRootAndCarrier) {
  const TempFolder folder;
  AnimatorFile file;
  file.world_root = file.world_chain = true;
  file.frames = 40;
  std::string text = file.text();
  text.replace(text.find("    JOINT Hips\n"), 15,
               "    JOINT ik_hand\n    {\n      OFFSET 30 100 0\n      CHANNELS 0\n      End Site\n      {\n"
               "        OFFSET 0 5 0\n      }\n    }\n    JOINT Hips\n");
  write_atomically(folder / "walk.bvh", text);
  const Clip clip = read_clip(folder / "walk.bvh");
  EXPECT_GT((clip.trans[39] - clip.trans[0]).norm().item<double>(), 0.7);
  const Places truth = scaled(places_in_bvh(text), 0.01);
  Places rest = truth, found = clip_places(clip);
  for (const char* gone : {"joint_Root", "World"}) rest.erase(gone), found.erase(gone);
  EXPECT_LT(farthest(rest, found), 1e-4);
  write_clip(folder / "same.bvh", clip);
  EXPECT_LT(farthest(truth, scaled(places_in(folder / "same.bvh"), 0.01)), 1e-4) << "both stand again";
}

TEST(RoundTrip, ARootThatGoesItselfIsLeftAlone) {
  const TempFolder folder;
  AnimatorFile file;
  file.world_root = true;
  file.frames = 30;
  Clip clip = read_clip((write_atomically(folder / "walk.bvh", file.text()), folder / "walk.bvh"));
  clip.file = {};
  // The root walks, the hips only sway: nothing is to be moved to the root.
  torch::Tensor places = clip.skeleton.offsets.unsqueeze(0).repeat({30, 1, 1});
  places.select(1, 1).select(1, 0).add_(0.02 * torch::sin(torch::arange(30) * 0.3));
  set_translations(clip, places);
  const torch::Tensor before = clip.joints.clone();
  EXPECT_EQ(carry_by_root(clip), -1);
  EXPECT_TRUE(torch::equal(before, clip.joints));
  write_clip(folder / "sway.bvh", clip);
  EXPECT_LT(farthest(clip_places(clip), scaled(places_in(folder / "sway.bvh"), 0.01)), 1e-4);
  EXPECT_LT((read_clip(folder / "sway.bvh").root_path() - clip.root_path()).norm(2, {1}).max().item<double>(), 1e-4);
}

TEST(RoundTrip, FilesKeepTheirUnitAxesAndChannels) {
  const TempFolder folder;
  for (const bool z_up : {false, true})
    for (const double unit : {0.01, 1.0, 10.0})
      for (const std::string order : {"XYZ", "XZY"}) {
        AnimatorFile file;
        file.unit = unit;
        file.order = order;
        file.z_up = z_up;
        file.frames = 20;
        write_atomically(folder / "in.bvh", file.text());
        const Clip clip = read_clip(folder / "in.bvh");
        EXPECT_EQ(clip.file.z_up, z_up);
        EXPECT_NEAR(clip.joints[0][0][1].item<double>(), 0.9, 1e-3) << "upright";
        write_clip(folder / "out.bvh", clip);
        const std::string in = file.text(), out = read_whole_file(folder / "out.bvh");
        EXPECT_LT(farthest(places_in_bvh(in), places_in_bvh(out)), 0.02 * unit) << z_up << unit << order;
        EXPECT_EQ(replaced(out.substr(0, out.find("OFFSET")), "\t", "  "), in.substr(0, in.find("OFFSET")));
        EXPECT_THAT(out, HasSubstr(std::string("CHANNELS 3 ") + order[0] + "rotation " + order[1] + "rotation " +
                                   order[2] + "rotation"));
      }
}

TEST(RoundTrip, AcclaimBonesMayTranslateToo) {
  const TempFolder folder;
  const std::string bones =
      ":version 1.10\n:units\n  length 0.45\n  angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n"
      " position 0 0 0\n orientation 0 0 0\n:bonedata\n"
      " begin\n name back\n direction 0 1 0\n length 8\n axis 0 0 0 XYZ\n dof rx ry rz tx ty tz\n end\n"
      " begin\n name thigh\n direction 0 -1 0\n length 8\n axis 0 0 90 XYZ\n dof rx\n end\n"
      " begin\n name shin\n direction 0 -1 0\n length 8\n axis 0 90 0 XYZ\n dof rx tx\n end\n"
      ":hierarchy\n begin\n root back thigh\n thigh shin\n end\n";
  const std::string motion =
      ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 16 2 0 0 0\nback 0 0 0 0 0 0\nthigh 0\nshin 0 0\n"
      "2\nroot 1 17 4 0 90 0\nback 0 0 0 1 2 3\nthigh 90\nshin 0 2\n"
      "3\nroot 1 17 5 10 80 -5\nback 15 -25 35 1 2 3\nthigh 40\nshin 30 1\n";
  write_atomically(folder / "a.asf", bones);
  write_atomically(folder / "a.amc", motion);
  const Clip clip = read_clip(folder / "a.amc");
  const double unit = 0.0254 / 0.45;
  const auto expect_at = [&](const char* joint, double x, double y, double z) {
    const torch::Tensor at = clip.joints[1][clip.skeleton.find(joint)] / unit;
    EXPECT_LT((at - torch::tensor({x, y, z}, torch::kFloat)).norm().item<double>(), 1e-4) << joint << at;
  };
  // The root's rotation by 90 degrees takes (x, y, z) to (z, y, -x).
  expect_at("back", 1 + 3, 17 + 2, 4 - 1);
  // The thigh rotates by as much about its own x, which is the world's y: 180 degrees with the root's. The shin's own x
  // is -z at rest, which that takes to z.
  expect_at("shin", 1, 17 - 8, 4 + 2);
  const Places truth = scaled(places_in_acclaim(bones, motion), unit);
  EXPECT_LT(farthest(truth, clip_places(clip)), 1e-4);
  for (const std::string one : {"bvh", "npz", "json", "glb"}) {
    write_clip(folder / ("one." + one), clip);
    EXPECT_LT(farthest(truth, scaled(places_in(folder / ("one." + one)), one == "bvh" ? 0.01 : 1)), 1e-4) << one;
  }
}

TEST(RoundTrip, ExponentialMapsKeepTheirTravel) {
  const TempFolder folder;
  for (const ExpmapSkeleton kind : {ExpmapSkeleton::h36m, ExpmapSkeleton::cmu}) {
    const bool steps = kind == ExpmapSkeleton::h36m;
    const double unit = steps ? 0.001 : 0.0254 / 0.45;
    const Skeleton& skeleton = expmap_skeleton(kind);
    std::string text;
    for (int t = 0; t < 12; ++t) {
      // Ahead by 2 cm in each row, upright but for a little.
      const double ahead = 0.02 / unit * (steps ? 1 : t), tilt = 0.02 * std::sin(0.9 * t);
      const double root[] = {0, 0, ahead, tilt, 0.1 * std::sin(0.3 * t), -tilt};
      for (int k = 0; k < 3 + 3 * skeleton.size(); ++k)
        text += (k ? "," : "") + std::to_string(k < 6 ? root[k] : 0.1 * std::sin(0.3 * t + k));
      text += "\n";
    }
    write_atomically(folder / "walk.txt", text);
    const Places truth = places_in_expmap_text(text, skeleton, unit, steps);
    EXPECT_GT(travelled(truth.at("Hips")), 0.2);
    expect_kept_everywhere(folder, folder / "walk.txt", truth, "");
  }
}

TEST(RoundTrip, TheUnitIsThatOfTheBonesNotOfTheTrajectory) {
  AnimatorFile file;
  file.world_root = true;
  file.frames = 30;
  const std::string far = replaced(file.text(), "OFFSET 0.000000 92.000000 0.000000", "OFFSET 0.8 93.9 -4520");
  EXPECT_EQ(parse_bvh(far, "far.bvh").unit, "centimetres");
  file.unit = 40;
  EXPECT_THAT(refusal_of([&] { parse_bvh(file.text(), "big.bvh"); }), HasSubstr("--scale"));
}

TEST(Upright, WhateverTheFilesAxisAndWhateverIsSaid) {
  const TempFolder folder;
  for (const bool z_up : {false, true}) {
    AnimatorFile file;
    file.order = "XZY";
    file.z_up = z_up;
    file.frames = 30;
    write_atomically(folder / "walk.bvh", file.text());
    Clip arrays = read_clip(folder / "walk.bvh");
    arrays.file.format = "npz";
    arrays.file.z_up = z_up;
    write_clip(folder / "walk.npz", arrays);
    EXPECT_NEAR(places_in(folder / "walk.npz").at("Hips")[0][z_up ? 2 : 1], 0.9, 0.03);
    for (const std::string name : {"walk.bvh", "walk.npz"}) {
      const std::string path = folder / name;
      const auto expect_upright = [&](UpAxis told) {
        ClipReadOptions options;
        options.up = told;
        const Clip clip = read_clip(path, options);
        const int head = clip.skeleton.find("Head"), hips = clip.skeleton.find("Hips");
        const torch::Tensor trunk = (clip.joints.select(1, head) - clip.joints.select(1, hips)).mean(0);
        EXPECT_GT(trunk[1].item<double>(), 0.5) << path;
        EXPECT_NEAR(clip.joints[0][hips][1].item<double>(), 0.9, 0.03) << path;
        EXPECT_LT((clip.joints - arrays.joints).norm(2, {2}).max().item<double>(), 1e-3) << path;
      };
      expect_upright(UpAxis::automatic);
      if (z_up) {
        expect_upright(UpAxis::z);
        ClipReadOptions options;
        options.up = UpAxis::y;  // as told, for who lies: but it is said
        Notes notes;
        EXPECT_NEAR(read_clip(path, options, &notes).joints[0][0][2].item<double>(), 0.9, 0.03);
        EXPECT_THAT(notes, testing::Contains(HasSubstr("+Y is taken for up as told")));
      } else {
        expect_upright(UpAxis::y);
        ClipReadOptions options;
        options.up = UpAxis::z;
        EXPECT_THAT(refusal_of([&] { read_clip(path, options); }), HasSubstr("has +Y up, not +Z"));
      }
    }
  }
}

TEST(Upright, WhoLiesOnTheFloorLies) {
  const TempFolder folder;
  AnimatorFile file;
  file.order = "XZY";
  file.z_up = true;  // along +Z, but on a floor y = 0
  file.frames = 10;
  std::string text = file.text();
  write_atomically(folder / "lying.bvh", text);
  Clip clip = read_clip(folder / "lying.bvh", [] {
    ClipReadOptions options;
    options.up = UpAxis::y;
    return options;
  }());
  const double low = clip.joints.select(2, 1).min().item<double>();
  clip.trans.select(1, 1).sub_(low);
  clip.trans.select(1, 2).add_(1.5);
  clip.file = {};
  write_clip(folder / "floor.bvh", clip);
  EXPECT_FALSE(read_clip(folder / "floor.bvh").file.z_up);
}

}  // namespace inhabit
