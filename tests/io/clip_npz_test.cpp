#include "inhabit/io/clip_npz.h"

#include <gtest/gtest.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/files.h"
#include "inhabit/math/rotation.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

constexpr int64_t T = 5;

/// A clip with everything that a clip can hold, on a skeleton that is nobody's standard.
Clip full_clip() {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.skeleton.offsets = clip.skeleton.offsets * 1.07 + 0.001;
  clip.rate = 29.97;
  clip.rotations = 0.3 * torch::randn({T, 22, 3});
  clip.trans = torch::randn({T, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  clip.betas = torch::randn({8});
  clip.gender = "female";
  clip.source_body = "smplx";
  clip.source_betas = torch::randn({16});
  clip.action_names = {"walk", "sit down"};
  clip.action = torch::randint(0, 2, {T}, torch::kInt64);
  clip.contact = torch::randint(0, 2, {T, 22}).to(torch::kFloat32);
  clip.hand_targets = torch::randn({T, 2, 4});
  clip.object_names = {"chair_0"};
  clip.object_pose = torch::randn({T, 1, 6});
  return clip;
}

void expect_same(const Clip& a, const Clip& b) {
  EXPECT_EQ(a.skeleton.names, b.skeleton.names);
  EXPECT_EQ(a.skeleton.parents, b.skeleton.parents);
  EXPECT_EQ(a.rate, b.rate);
  EXPECT_EQ(a.gender, b.gender);
  EXPECT_EQ(a.source_body, b.source_body);
  EXPECT_EQ(a.action_names, b.action_names);
  EXPECT_EQ(a.object_names, b.object_names);
  const std::vector<std::pair<torch::Tensor, torch::Tensor>> pairs = {{a.skeleton.offsets, b.skeleton.offsets},
                                                                      {a.joints, b.joints},
                                                                      {a.rotations, b.rotations},
                                                                      {a.trans, b.trans},
                                                                      {a.betas, b.betas},
                                                                      {a.source_betas, b.source_betas},
                                                                      {a.action, b.action},
                                                                      {a.contact, b.contact},
                                                                      {a.hand_targets, b.hand_targets},
                                                                      {a.object_pose, b.object_pose}};
  for (size_t i = 0; i < pairs.size(); ++i) {
    ASSERT_EQ(pairs[i].first.defined(), pairs[i].second.defined()) << i;
    if (pairs[i].first.defined()) {
      EXPECT_TRUE(torch::equal(pairs[i].first, pairs[i].second)) << i;
    }
  }
}

Npz amass(const torch::Tensor& pose, const torch::Tensor& trans) {
  Npz npz;
  npz.tensors["poses"] = pose.reshape({pose.size(0), -1}).to(torch::kFloat64);
  npz.tensors["trans"] = trans.to(torch::kFloat64);
  npz.tensors["betas"] = torch::ones({16}, torch::kFloat64);
  npz.tensors["mocap_framerate"] = torch::tensor(120.0, torch::kFloat64);
  npz.strings["gender"] = {{}, {"b'male'"}};
  return npz;
}

std::string npz_error(const Npz& npz, const ClipReadOptions& options = {}) {
  return refusal_of([&] { return clip_from_npz(npz, "file", options); });
}

TEST(ClipNpz, OwnClipsRoundTripBitByBit) {
  torch::manual_seed(1);
  const TempFolder folder;
  const Clip clip = full_clip();
  write_clip_npz(folder / "clip.npz", clip);
  expect_same(read_clip_npz(folder / "clip.npz"), clip);

  Clip positions = clip;  // without rotations, on a tree of four joints
  positions.skeleton = {{"a", "b", "c", "d"}, {-1, 0, 1, 1}, torch::randn({4, 3})};
  positions.joints = torch::randn({T, 4, 3});
  positions.rotations = positions.trans = positions.contact = positions.betas = torch::Tensor();
  expect_same(clip_from_npz(npz_from_clip(positions, "x"), "x"), positions);
  positions.rotations = torch::randn({T, 4, 3});
  positions.trans = torch::randn({T, 3});
  expect_same(clip_from_npz(npz_from_clip(positions, "x"), "x"), positions);
}

TEST(ClipNpz, EverySpellingGivesTheSameMotion) {
  torch::manual_seed(2);
  const torch::Tensor body = 0.2 * torch::randn({T, 22, 3}), trans = torch::randn({T, 3});
  const torch::Tensor hands = torch::randn({T, 30, 3}), face = torch::randn({T, 3, 3});
  const Clip smplh = clip_from_npz(amass(torch::cat({body, hands}, 1), trans), "smplh");
  EXPECT_EQ(smplh.rate, 120);
  EXPECT_EQ(smplh.gender, "male");
  EXPECT_EQ(smplh.source_body, "smplh");
  EXPECT_EQ(smplh.source_betas.size(0), 16);
  EXPECT_FALSE(smplh.betas.defined());  // another body's shape
  EXPECT_TRUE(torch::equal(smplh.rotations, body));
  EXPECT_TRUE(torch::allclose(smplh.joints, joint_positions(smplh.skeleton, smplh.rotations, smplh.trans)));

  for (const auto& pose : {body, torch::cat({body, torch::zeros({T, 2, 3})}, 1), torch::cat({body, face, hands}, 1)}) {
    const Clip clip = clip_from_npz(amass(pose, trans), "poses");
    EXPECT_TRUE(torch::equal(clip.rotations, body)) << pose.sizes();
  }
  auto in_parts = [&](const char* root_name, const char* body_name, const char* trans_name, const char* rate_name) {
    Npz npz;
    npz.tensors[root_name] = body.narrow(1, 0, 1).reshape({T, 3});
    npz.tensors[body_name] = body.narrow(1, 1, 21).reshape({T, 63});
    npz.tensors[trans_name] = trans;
    npz.tensors[rate_name] = torch::tensor({60}, torch::kInt32);
    return npz;
  };
  for (const auto& npz : {in_parts("root_orient", "pose_body", "trans", "mocap_frame_rate"),
                          in_parts("global_orient", "body_pose", "transl", "fps"),
                          in_parts("orient", "body_pose", "translation", "frame_rate")}) {
    const Clip clip = clip_from_npz(npz, "parts");
    EXPECT_TRUE(torch::equal(clip.rotations, body));
    EXPECT_EQ(clip.rate, 60);
  }
  // Every spelling of SMPL-X is SMPL-X, whose pelvis rests 13 cm lower than SMPL-H's.
  for (const char* name : {"smplx", "smplx_locked_head", "SMPL-X", "SMPLX_NEUTRAL"}) {
    Npz named = in_parts("root_orient", "pose_body", "trans", "mocap_frame_rate");
    named.strings["surface_model_type"] = {{}, {name}};
    const Clip clip = clip_from_npz(named, "named");
    EXPECT_EQ(clip.source_body, "smplx") << name;
    EXPECT_NEAR((clip.root_path() - trans)[0][1].item<float>(), -0.351F, 1e-5) << name;
  }
  Npz matrices = in_parts("global_orient", "body_pose", "transl", "fps");
  matrices.tensors["global_orient"] = axis_angle_to_matrix(body.narrow(1, 0, 1));
  matrices.tensors["body_pose"] = axis_angle_to_matrix(body.narrow(1, 1, 21));
  matrices.tensors["betas"] = torch::zeros({T, 10});
  const Clip clip = clip_from_npz(matrices, "matrices");
  EXPECT_TRUE(torch::allclose(clip.rotations, body, 1e-4, 1e-5));
  EXPECT_EQ(clip.source_betas.sizes(), std::vector<int64_t>{10});
}

TEST(ClipNpz, ZUpFilesAreTurned) {
  torch::manual_seed(3);
  torch::Tensor upright = 0.1 * torch::randn({T, 22, 3});
  const torch::Tensor trans = torch::randn({T, 3});
  Notes notes;
  const Clip y_up = clip_from_npz(amass(upright, trans), "y", {}, &notes);
  EXPECT_NE(notes.back().find("+Y is up"), std::string::npos);

  // The same motion in a z-up world: about x by +90 degrees, (x, y, z) -> (x, -z, y), around the model's pelvis.
  const torch::Tensor rotation = torch::tensor({1.F, 0.F, 0.F, 0.F, 0.F, -1.F, 0.F, 1.F, 0.F}).view({3, 3});
  const torch::Tensor pelvis = torch::tensor({-0.002F, -0.223F, 0.028F});
  torch::Tensor rotated = upright.clone();
  rotated.select(1, 0).copy_(matrix_to_axis_angle(rotation.matmul(axis_angle_to_matrix(upright.select(1, 0)))));
  const Npz z_file = amass(rotated, (trans + pelvis).matmul(rotation.t()) - pelvis);
  notes.clear();
  const Clip z_up = clip_from_npz(z_file, "z", {}, &notes);
  EXPECT_NE(notes.back().find("rotated"), std::string::npos);
  EXPECT_TRUE(torch::allclose(z_up.joints, y_up.joints, 1e-4, 1e-4));
  ClipReadOptions as_is;
  as_is.up = UpAxis::y;
  EXPECT_TRUE(torch::allclose(clip_from_npz(z_file, "z", as_is).joints, y_up.joints.matmul(rotation.t()), 1e-4, 1e-4));
}

TEST(ClipNpz, PositionsAloneGetTheirOwnBoneLengths) {
  const Skeleton& builtin = builtin_body().skeleton;
  const torch::Tensor joints =
      joint_positions(builtin, torch::zeros({T, 22, 3}), torch::tensor({0.F, 1.F, 0.F}).expand({T, 3})) * 1.1;
  Npz npz;
  npz.tensors["arr_0"] = joints;
  const Clip clip = clip_from_npz(npz, "joints.npy");
  EXPECT_TRUE(torch::equal(clip.joints, joints));
  EXPECT_FALSE(clip.rotations.defined());
  EXPECT_TRUE(torch::allclose(clip.skeleton.offsets.slice(0, 1), builtin.offsets.slice(0, 1) * 1.1, 1e-4, 1e-5));
}

TEST(ClipNpz, BadFilesAreNamedWithTheirFault) {
  const torch::Tensor body = torch::zeros({T, 22, 3}), trans = torch::zeros({T, 3});
  auto changed = [&](const std::function<void(Npz&)>& change) {
    Npz npz = amass(body, trans);
    change(npz);
    return npz_error(npz);
  };
  auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  };
  expect(changed([](Npz& n) { n.tensors.erase("poses"); }), "no motion");
  expect(changed([](Npz& n) { n.tensors["poses"] = torch::zeros({T, 60}); }), "pose of 20 joints");
  expect(changed([](Npz& n) { n.tensors["poses"] = torch::zeros({T, 65}); }), "neither (T, 3J)");
  expect(changed([](Npz& n) { n.tensors["poses"] = torch::zeros({0, 66}); }), "no frames");
  expect(changed([](Npz& n) { n.tensors["poses"][2][5] = std::nan(""); }), "not finite");
  expect(changed([](Npz& n) { n.tensors["trans"][1][0] = INFINITY; }), "not finite");
  expect(changed([](Npz& n) { n.tensors["trans"] = torch::zeros({T + 1, 3}); }), "trans is not");
  expect(changed([](Npz& n) { n.tensors["mocap_framerate"] = torch::tensor(-5); }), "frame rate");
  expect(changed([](Npz& n) { n.tensors["mocap_framerate"] = torch::tensor(1e9); }), "frame rate");
  expect(changed([](Npz& n) { n.tensors["mocap_framerate"] = torch::tensor(NAN); }), "frame rate");
  expect(changed([](Npz& n) { n.tensors["mocap_framerate"] = torch::zeros({2}); }), "not one number");
  expect(changed([](Npz& n) {
           n.tensors.erase("poses");
           n.skipped["poses"] = "a pickled Python object";
         }),
         "pickled");

  torch::manual_seed(4);
  auto own = [](const std::function<void(Npz&)>& change) {
    Npz npz = npz_from_clip(full_clip(), "x");
    change(npz);
    return npz_error(npz);
  };
  expect(own([](Npz& n) { n.tensors["parents"][3] = 7; }), "before its parent");
  expect(own([](Npz& n) { n.tensors["parents"][3] = 99; }), "does not exist");
  expect(own([](Npz& n) { n.tensors["joints"] = torch::zeros({T, 21, 3}); }), "joints has the wrong shape");
  expect(own([](Npz& n) { n.tensors["action"] = torch::zeros({T + 1}, torch::kInt64); }), "action has the wrong");
  expect(own([](Npz& n) { n.strings["joint_names"].values.pop_back(); }), "differ in number");
}

TEST(ClipsNpz, MotionsWrittenTogetherComeBackBitByBit) {
  torch::manual_seed(5);
  const TempFolder folder;
  const Clip first = full_clip();
  std::vector<Clip> clips;
  for (int s = 0; s < 3; ++s) {
    Clip clip = first;  // the same person's
    clip.rotations = 0.3 * torch::randn({T, 22, 3});
    clip.trans = torch::randn({T, 3});
    clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
    clip.action = torch::randint(0, 2, {T}, torch::kInt64);
    clip.contact = torch::randint(0, 2, {T, 22}).to(torch::kFloat32);
    clip.object_pose = torch::randn({T, 1, 6});
    clips.push_back(clip);
  }
  const torch::Tensor labels = torch::randint(0, 8, {3, T}, torch::kInt64);
  write_clips_npz(folder / "futures.npz", clips, {{"intention", labels}, {"nothing", torch::Tensor()}});
  const std::vector<Clip> back = read_clips_npz(folder / "futures.npz");
  ASSERT_EQ(back.size(), 3U);
  for (size_t s = 0; s < 3; ++s) expect_same(back[s], clips[s]);
  const std::vector<Clip> samples = read_samples(folder / "futures.npz");
  ASSERT_EQ(samples.size(), 3U);
  for (size_t s = 0; s < 3; ++s) expect_same(samples[s], clips[s]);
  const Npz arrays = read_npz(folder / "futures.npz");
  EXPECT_EQ(arrays.tensors.at("joints").sizes(), (std::vector<int64_t>{3, T, 22, 3}));
  EXPECT_EQ(arrays.tensors.at("root_path").sizes(), (std::vector<int64_t>{3, T, 3}));
  EXPECT_TRUE(torch::equal(arrays.tensors.at("intention"), labels));
  EXPECT_FALSE(arrays.has("nothing"));

  write_clips_npz(folder / "one.npz", {clips[1]});  // one future is a file of futures too
  expect_same(read_clip_npz(folder / "one.npz"), clips[1]);
  write_clip_npz(folder / "plain.npz", clips[2]);
  ASSERT_EQ(read_clips_npz(folder / "plain.npz").size(), 1U);
  expect_same(read_clips_npz(folder / "plain.npz")[0], clips[2]);
}

TEST(ClipsNpz, SayInOneLineWhatIsWrong) {
  torch::manual_seed(6);
  const TempFolder folder;
  const Clip clip = full_clip();
  write_clips_npz(folder / "two.npz", {clip, clip});
  EXPECT_EQ(refusal_of([&] { read_clip_npz(folder / "two.npz"); }),
            folder / "two.npz" + ": holds 2 motions where one is wanted");
  EXPECT_NE(refusal_of([&] { write_clips_npz(folder / "none.npz", {}); }).find("no motion to write"),
            std::string::npos);
  EXPECT_NE(refusal_of([&] {
              write_clips_npz(folder / "none.npz", {clip, slice(clip, 0, 3)});
            }).find("differ in"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "none.npz"));

  const Npz good = read_npz(folder / "two.npz");
  const auto refused = [&](const std::function<void(Npz&)>& change) {
    Npz bad = good;
    for (auto& [name, tensor] : bad.tensors) tensor = tensor.clone();
    change(bad);
    return refusal_of([&] { clips_from_npz(bad, "bad.npz"); });
  };
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_EQ(message.rfind("bad.npz: ", 0), 0U) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  EXPECT_EQ(refused([](Npz&) {}), "");
  expect(refused([](Npz& n) { n.tensors["trans"] = n.tensors["trans"][0]; }), "trans has not the sample dimension");
  expect(refused([](Npz& n) { n.tensors["action"] = n.tensors["action"].slice(0, 0, 1); }), "action has not the");
  expect(refused([](Npz& n) { n.tensors["contact"] = torch::tensor(1.0F); }), "contact has not the");
  expect(refused([](Npz& n) { n.tensors["joints"] = torch::zeros({3, T, 22, 3}); }), "has not the sample dimension");
  expect(refused([](Npz& n) { n.tensors["joints"] = torch::zeros({2, T, 21, 3}); }), "joints has the wrong shape");
  expect(refused([](Npz& n) { n.tensors["joints"] = torch::zeros({2, T, 22, 3, 1}); }), "");
  expect(refused([](Npz& n) {
           for (auto& [name, tensor] : n.tensors)
             if (tensor.dim() > 0 && tensor.size(0) == 2) tensor = tensor.slice(0, 0, 0);
         }),
         "");
  expect(refused([](Npz& n) { n.tensors["joints"][1][2][3][0] = std::nan(""); }), "not finite");
}

TEST(ClipNpz, ReadsARecordedSequence) {
  if (shared_folder().empty()) GTEST_SKIP() << "no recordings beside the project";
  Notes notes;
  const Clip clip = read_clip_npz(shared_folder() + "/data/trumans/2023-02-12_22-16-01.npz", {}, &notes);
  EXPECT_EQ(clip.frames(), 2660);
  EXPECT_EQ(clip.rate, 30);
  EXPECT_EQ(clip.source_body, "smplx");
  EXPECT_NE(notes.back().find("+Y is up"), std::string::npos);
  const float ankles = clip.joints.select(2, 1).narrow(1, 7, 2).min().item<float>();
  EXPECT_GT(ankles, 0.0F);  // the person walks on the floor y = 0
  EXPECT_LT(ankles, 0.15F);
}

}  // namespace
}  // namespace inhabit
