#include "inhabit/motion/landmarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/io/expmap_text.h"
#include "refusal_of.h"

using namespace inhabit;

namespace {

// A skeleton from "name parent" pairs, parents by name.
Skeleton tree(const std::vector<std::pair<std::string, std::string>>& joints) {
  Skeleton out;
  for (const auto& [name, parent] : joints) {
    out.parents.push_back(parent.empty() ? -1 : out.find(parent));
    out.names.push_back(name);
  }
  out.offsets = torch::full({out.size(), 3}, 0.1);
  return out;
}

// The names of one tool for: root, spine, chest, neck, head; left thigh, shin, foot, toe; left collar, arm, forearm,
// hand; the right side's.
Skeleton person(const std::vector<std::string>& n) {
  return tree({{n[0], ""},     {n[1], n[0]},   {n[2], n[1]},   {n[3], n[2]},   {n[4], n[3]},   {n[5], n[0]},
               {n[6], n[5]},   {n[7], n[6]},   {n[8], n[7]},   {n[9], n[2]},   {n[10], n[9]},  {n[11], n[10]},
               {n[12], n[11]}, {n[13], n[0]},  {n[14], n[13]}, {n[15], n[14]}, {n[16], n[15]}, {n[17], n[2]},
               {n[18], n[17]}, {n[19], n[18]}, {n[20], n[19]}});
}

void expect_person(const Landmarks& found) {
  EXPECT_EQ(found.pelvis, 0);
  EXPECT_EQ(found.thorax, 2);
  EXPECT_EQ(found.neck, 3);
  EXPECT_EQ(found.head, 4);
  EXPECT_EQ(found.spine, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(found.hip, (std::array<int, 2>{5, 13}));
  EXPECT_EQ(found.knee, (std::array<int, 2>{6, 14}));
  EXPECT_EQ(found.ankle, (std::array<int, 2>{7, 15}));
  EXPECT_EQ(found.toe, (std::array<int, 2>{8, 16}));
  EXPECT_EQ(found.collar, (std::array<int, 2>{9, 17}));
  EXPECT_EQ(found.shoulder, (std::array<int, 2>{10, 18}));
  EXPECT_EQ(found.elbow, (std::array<int, 2>{11, 19}));
  EXPECT_EQ(found.wrist, (std::array<int, 2>{12, 20}));
}

TEST(Landmarks, StandardJointsAreKnownByTheNamesOfAFileToo) {
  Skeleton file = builtin_body().skeleton;
  file.names[20] = "LeftHand";
  file.names[9] = "Chest";
  EXPECT_EQ(standard_joint_called("left_wrist", file), 20);
  EXPECT_EQ(standard_joint_called("LeftHand", file), 20);
  EXPECT_EQ(standard_joint_called("LeftHand", {}), -1);
  EXPECT_EQ(standard_joint_called("tail", file), -1);
  EXPECT_NE(joint_names_for(file).find("right_wrist; of the file "), std::string::npos) << joint_names_for(file);
  EXPECT_NE(joint_names_for(file).find("LeftHand"), std::string::npos);
  EXPECT_EQ(joint_names_for({}).find("of the file"), std::string::npos);
}

}  // namespace

TEST(Landmarks, KnowsTheNamesOfManyTools) {
  const std::vector<std::vector<std::string>> tools = {
      {"mixamorig:Hips",         "mixamorig:Spine",         "mixamorig:Spine2",   "mixamorig:Neck",
       "mixamorig:Head",         "mixamorig:LeftUpLeg",     "mixamorig:LeftLeg",  "mixamorig:LeftFoot",
       "mixamorig:LeftToeBase",  "mixamorig:LeftShoulder",  "mixamorig:LeftArm",  "mixamorig:LeftForeArm",
       "mixamorig:LeftHand",     "mixamorig:RightUpLeg",    "mixamorig:RightLeg", "mixamorig:RightFoot",
       "mixamorig:RightToeBase", "mixamorig:RightShoulder", "mixamorig:RightArm", "mixamorig:RightForeArm",
       "mixamorig:RightHand"},
      {"Bip01 Pelvis",     "Bip01 Spine",     "Bip01 Spine1",     "Bip01 Neck",       "Bip01 Head",
       "Bip01 L Thigh",    "Bip01 L Calf",    "Bip01 L Foot",     "Bip01 L Toe0",     "Bip01 L Clavicle",
       "Bip01 L UpperArm", "Bip01 L Forearm", "Bip01 L Hand",     "Bip01 R Thigh",    "Bip01 R Calf",
       "Bip01 R Foot",     "Bip01 R Toe0",    "Bip01 R Clavicle", "Bip01 R UpperArm", "Bip01 R Forearm",
       "Bip01 R Hand"},
      {"pelvis", "spine_01", "spine_02",   "neck_01",    "head",       "thigh_l",    "calf_l",
       "foot_l", "ball_l",   "clavicle_l", "upperarm_l", "lowerarm_l", "hand_l",     "thigh_r",
       "calf_r", "foot_r",   "ball_r",     "clavicle_r", "upperarm_r", "lowerarm_r", "hand_r"},
      {"DEF-spine",       "DEF-spine.001", "DEF-spine.002", "DEF-neck",       "DEF-head",        "DEF-thigh.L",
       "DEF-shin.L",      "DEF-foot.L",    "DEF-toe.L",     "DEF-shoulder.L", "DEF-upper_arm.L", "DEF-forearm.L",
       "DEF-hand.L",      "DEF-thigh.R",   "DEF-shin.R",    "DEF-foot.R",     "DEF-toe.R",       "DEF-shoulder.R",
       "DEF-upper_arm.R", "DEF-forearm.R", "DEF-hand.R"},
      {"J_Bip_C_Hips",     "J_Bip_C_Spine",    "J_Bip_C_Chest",    "J_Bip_C_Neck",     "J_Bip_C_Head",
       "J_Bip_L_UpperLeg", "J_Bip_L_LowerLeg", "J_Bip_L_Foot",     "J_Bip_L_ToeBase",  "J_Bip_L_Shoulder",
       "J_Bip_L_UpperArm", "J_Bip_L_LowerArm", "J_Bip_L_Hand",     "J_Bip_R_UpperLeg", "J_Bip_R_LowerLeg",
       "J_Bip_R_Foot",     "J_Bip_R_ToeBase",  "J_Bip_R_Shoulder", "J_Bip_R_UpperArm", "J_Bip_R_LowerArm",
       "J_Bip_R_Hand"},
      {"Hips",      "Chest",      "Chest2",     "Neck",         "Head",          "LeftHip",    "LeftKnee",
       "LeftAnkle", "LeftToe",    "LeftCollar", "LeftShoulder", "LeftElbow",     "LeftWrist",  "RightHip",
       "RightKnee", "RightAnkle", "RightToe",   "RightCollar",  "RightShoulder", "RightElbow", "RightWrist"},
      {"hip",   "abdomen", "chest",   "neck",    "head",     "lThigh",   "lShin",
       "lFoot", "lToe",    "lCollar", "lShldr",  "lForeArm", "lHand",    "rThigh",
       "rShin", "rFoot",   "rToe",    "rCollar", "rShldr",   "rForeArm", "rHand"},
      // Xsens' own, Rokoko's, OptiTrack's, an arbitrary prefix and suffix, Rigify's metarig.
      {"Pelvis",        "L5",        "T8",           "Neck",          "Head",          "LeftUpperLeg", "LeftLowerLeg",
       "LeftFoot",      "LeftToe",   "LeftShoulder", "LeftUpperArm",  "LeftForeArm",   "LeftHand",     "RightUpperLeg",
       "RightLowerLeg", "RightFoot", "RightToe",     "RightShoulder", "RightUpperArm", "RightForeArm", "RightHand"},
      {"Hips",      "Spine1",    "Spine2",       "Neck",          "Head",        "LeftThigh",    "LeftShin",
       "LeftFoot",  "LeftToe",   "LeftShoulder", "LeftArm",       "LeftForeArm", "LeftHand",     "RightThigh",
       "RightShin", "RightFoot", "RightToe",     "RightShoulder", "RightArm",    "RightForeArm", "RightHand"},
      {"Skeleton 001_Hip",   "Skeleton 001_Ab",        "Skeleton 001_Chest", "Skeleton 001_Neck",
       "Skeleton 001_Head",  "Skeleton 001_LThigh",    "Skeleton 001_LShin", "Skeleton 001_LFoot",
       "Skeleton 001_LToe",  "Skeleton 001_LShoulder", "Skeleton 001_LUArm", "Skeleton 001_LFArm",
       "Skeleton 001_LHand", "Skeleton 001_RThigh",    "Skeleton 001_RShin", "Skeleton 001_RFoot",
       "Skeleton 001_RToe",  "Skeleton 001_RShoulder", "Skeleton 001_RUArm", "Skeleton 001_RFArm",
       "Skeleton 001_RHand"},
      {"Bob_hips_jnt",       "Bob_spine1_jnt",     "Bob_spine2_jnt",     "Bob_neck_jnt",       "Bob_head_jnt",
       "Bob_thigh_l_jnt",    "Bob_calf_l_jnt",     "Bob_foot_l_jnt",     "Bob_toe_l_jnt",      "Bob_clavicle_l_jnt",
       "Bob_upperarm_l_jnt", "Bob_lowerarm_l_jnt", "Bob_hand_l_jnt",     "Bob_thigh_r_jnt",    "Bob_calf_r_jnt",
       "Bob_foot_r_jnt",     "Bob_toe_r_jnt",      "Bob_clavicle_r_jnt", "Bob_upperarm_r_jnt", "Bob_lowerarm_r_jnt",
       "Bob_hand_r_jnt"},
      {"spine",  "spine.001", "spine.002",  "spine.003",   "spine.004",   "thigh.L",   "shin.L",
       "foot.L", "toe.L",     "shoulder.L", "upper_arm.L", "forearm.L",   "hand.L",    "thigh.R",
       "shin.R", "foot.R",    "toe.R",      "shoulder.R",  "upper_arm.R", "forearm.R", "hand.R"},
      {"pelvis",     "spine1",      "spine3",      "neck",          "head",           "left_hip",    "left_knee",
       "left_ankle", "left_foot",   "left_collar", "left_shoulder", "left_elbow",     "left_wrist",  "right_hip",
       "right_knee", "right_ankle", "right_foot",  "right_collar",  "right_shoulder", "right_elbow", "right_wrist"}};
  for (const auto& names : tools) {
    SCOPED_TRACE(names[0]);
    expect_person(find_landmarks(person(names), "a"));
  }
}

TEST(Landmarks, TheHeadOfASpineIsBeforeItsEndSite) {
  Skeleton rigify = person({"spine",  "spine.001", "spine.002",  "spine.003",   "spine.004",   "thigh.L",   "shin.L",
                            "foot.L", "toe.L",     "shoulder.L", "upper_arm.L", "forearm.L",   "hand.L",    "thigh.R",
                            "shin.R", "foot.R",    "toe.R",      "shoulder.R",  "upper_arm.R", "forearm.R", "hand.R"});
  rigify.names.emplace_back("spine.004_end");
  rigify.parents.push_back(4);
  rigify.offsets = torch::full({rigify.size(), 3}, 0.1);
  expect_person(find_landmarks(rigify, "rigify.bvh"));
}

TEST(Landmarks, CmuJointsBeforeTheLimbsAreNoHipsAndShoulders) {
  const Skeleton& cmu = expmap_skeleton(ExpmapSkeleton::cmu);
  const Landmarks found = find_landmarks(cmu, "cmu");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.hip[0])], "LeftUpLeg");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.knee[1])], "RightLeg");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.shoulder[1])], "RightArm");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.collar[0])], "LeftShoulder");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.thorax)], "Spine1");
  EXPECT_EQ(cmu.names[static_cast<size_t>(found.neck)], "Neck");
}

TEST(Landmarks, SaysWhichPartIsMissing) {
  const auto error = [](const Skeleton& skeleton) {
    return refusal_of([&] { return find_landmarks(skeleton, "dog.bvh"); });
  };
  EXPECT_EQ(error(tree({{"Bone", ""}, {"Bone2", "Bone"}})),
            "dog.bvh: no joint of the skeleton (2 joints: Bone, Bone2) stands for the left hip");
  Skeleton cyclic = tree({{"a", ""}, {"b", "a"}, {"c", "b"}});
  cyclic.parents[1] = 2;
  EXPECT_THAT(error(cyclic), testing::HasSubstr("cycle"));
  // All parts hang in one chain.
  EXPECT_THAT(error(tree({{"head", ""},
                          {"LeftShoulder", "head"},
                          {"LeftElbow", "LeftShoulder"},
                          {"LeftWrist", "LeftElbow"},
                          {"RightShoulder", "head"},
                          {"RightElbow", "RightShoulder"},
                          {"RightWrist", "RightElbow"},
                          {"LeftHip", "head"},
                          {"LeftKnee", "LeftHip"},
                          {"LeftAnkle", "LeftKnee"},
                          {"RightHip", "head"},
                          {"RightKnee", "RightHip"},
                          {"RightAnkle", "RightKnee"}})),
              testing::HasSubstr("not that of a person"));
}
