// Protects what is said of a motion whose keys, paths or contacts are not as they were asked for.
#include "inhabit/inbetween/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace inhabit::inbetween {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Result result() {
  Result out;
  out.motion.rate = 30;
  out.keys = {0, 30, 60, 90, 120, 150, 180};
  return out;
}

TEST(InbetweenWarnings, NothingIsSaidOfAMotionThatIsAsItWasAskedFor) {
  Result r = result();
  r.contact_gaps = {0.02};
  EXPECT_THAT(warnings_of(r, {"the chair"}), IsEmpty());
}

TEST(InbetweenWarnings, AFloorThatIsAssumedAndASceneWithoutAnInsideAreNoted) {
  Result r = result();
  r.scene = floor_scene();
  EXPECT_THAT(notes_of(r), IsEmpty());
  r.floor_assumed = true;
  EXPECT_THAT(notes_of(r), ElementsAre("no scene given: a flat floor under the feet is assumed"));
  r.floor_assumed = false;
  r.scene = {"scan.ply", {}, torch::zeros({4, 3})};
  EXPECT_THAT(notes_of(r), ElementsAre("scan.ply: is a point cloud: where a body is inside it cannot be told"));
}

TEST(InbetweenWarnings, HowNoisyKeysAreTakenToBeIsNoted) {
  Result r = result();
  r.scene = floor_scene();
  r.noise = 1.25;
  EXPECT_THAT(notes_of(r), ElementsAre("keys are taken to be off by 1.2 degrees and 1.2 cm (--noise)"));
}

TEST(InbetweenWarnings, TheDeepestKeysAreNamedFirst) {
  Result r = result();
  r.key_immersions = {{30, 0.02, "table_0"}, {90, 0.17, "sofa_1"}};
  EXPECT_THAT(
      warnings_of(r, {}),
      ElementsAre("2 of 7 key poses are inside the scene: at 3.00 s, 170 mm in sofa_1; 1.00 s, 20 mm in table_0"));
  r.key_immersions = {{0, 0.01, "a"},  {30, 0.02, "b"},  {60, 0.03, "c"},
                      {90, 0.04, "d"}, {120, 0.05, "e"}, {150, 0.06, "f"}};
  EXPECT_THAT(
      warnings_of(r, {}),
      ElementsAre("6 of 7 key poses are inside the scene: at 5.00 s, 60 mm in f; 4.00 s, 50 mm in e; 3.00 s, 40 mm "
                  "in d; 2.00 s, 30 mm in c; 1.00 s, 20 mm in b; ..."));
}

TEST(InbetweenWarnings, PathsAndContactsAreNamedByTimeAndName) {
  Result r = result();
  r.unreached = {60};
  r.contact_gaps = {0.01, 0.352};
  EXPECT_THAT(warnings_of(r, {"--contact first", "--target second"}),
              ElementsAre("no path around what stands before the key at 2.00 s was found",
                          "--target second is missed by 0.35 m: places are in metres, within reach"));
}

}  // namespace
}  // namespace inhabit::inbetween
