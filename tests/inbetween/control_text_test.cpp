// Protects the words of --contact, --target and --root-path, and what is said where they are none.
#include "inhabit/inbetween/control_text.h"

#include <gmock/gmock.h>

#include "inhabit/body/palm.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using testing::HasSubstr;

TEST(ControlText, ContactsHaveAJointTimesAndAPlace) {
  const JointContact palm = parse_contact("left_hand,1.2,2,0.4,1.1,-0.3");
  EXPECT_EQ(palm.joint, 20);
  EXPECT_EQ(palm.offset, palm_offset(0).cast<double>().eval());
  EXPECT_EQ(palm.from, 1.2);
  EXPECT_EQ(palm.to, 2);
  EXPECT_EQ(palm.place, Eigen::Vector3d(0.4, 1.1, -0.3));
  const JointContact head = parse_contact("head, 0, +1 ,1e-1,  2,-3 ");
  EXPECT_EQ(head.joint, 15);
  EXPECT_TRUE(head.offset.isZero());
  EXPECT_EQ(head.place, Eigen::Vector3d(0.1, 2, -3));
  const auto refused = [](const std::string& text) { return refusal_of([&] { parse_contact(text); }); };
  EXPECT_EQ(refused("head,1,2,3"), "--contact head,1,2,3: has 3 numbers, 5 are wanted");
  EXPECT_EQ(refused("head"), "--contact head: has 0 numbers, 5 are wanted");
  EXPECT_EQ(refused("head,0,1,2,x,4"), "--contact head,0,1,2,x,4: 'x' is no number");
  for (const char* none : {"", " ", "1 2", "nan", "inf", "1e999", "0x", "1.5m"})
    EXPECT_THAT(refused(std::string("head,0,1,2,") + none + ",4"), HasSubstr("is no number")) << none;
  EXPECT_THAT(refused("nose,0,1,2,3,4"),
              HasSubstr("--contact nose,0,1,2,3,4: \"nose\" is no joint; there are left_hand"));
}

TEST(ControlText, TargetsAreContactsOfAMoment) {
  const JointContact target = parse_target("right_wrist@1.5=0.3,0.9,-0.2");
  EXPECT_EQ(target.joint, 21);
  EXPECT_EQ(target.from, 1.5);
  EXPECT_EQ(target.to, 1.5);
  EXPECT_EQ(target.place, Eigen::Vector3d(0.3, 0.9, -0.2));
  // Joints of files may have such names.
  Skeleton file = {{"root@=", "b"}, {-1, 0}, torch::zeros({2, 3})};
  EXPECT_THAT(refusal_of([&] { parse_target("root@=@1=0,0,0", file); }), HasSubstr("\"root@=\" is no joint"));
  for (const char* none : {"", "head", "head@1", "head=0,1,2", "head=0@1"})
    EXPECT_THAT(refusal_of([&] { parse_target(none); }), HasSubstr("is not JOINT@SECONDS=X,Y,Z")) << none;
  EXPECT_THAT(refusal_of([] { parse_target("head@=0,1,2"); }), HasSubstr("has 0 numbers, 1 are wanted"));
  EXPECT_THAT(refusal_of([] { parse_target("head@1=0,1"); }), HasSubstr("has 2 numbers, 3 are wanted"));
}

TEST(ControlText, PointsOfThePathHaveATime) {
  const PathPoint point = parse_path_point("1.5,0.25,-2");
  EXPECT_EQ(point.seconds, 1.5);
  EXPECT_EQ(point.place, Eigen::Vector2d(0.25, -2));
  EXPECT_EQ(refusal_of([] { parse_path_point("1,2"); }), "--root-path 1,2: has 2 numbers, 3 are wanted");
}

}  // namespace
}  // namespace inhabit::inbetween
