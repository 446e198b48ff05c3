// Protects what is said of a motion onto a chair that is not what was wanted.
#include "inhabit/interact/warnings.h"

#include <gmock/gmock.h>

namespace inhabit::interact {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(InteractWarnings, SayThatNobodySatDownAndWhichContactsWereLeftOut) {
  const Eigen::Vector3d place(0.1, 0.45, 0.2);
  Result result;
  result.chair.name = "chair_0";
  result.seated = 60;
  result.contacts = {{place, std::nullopt}, {std::nullopt, place}, {std::nullopt, std::nullopt}};
  result.contact_error = {{0.01, std::nullopt}, {std::nullopt, 0.02}, {std::nullopt, std::nullopt}};
  EXPECT_THAT(warnings_of(result, 8), IsEmpty()) << "no hand was to go anywhere at the third";
  result.contact_error[1][1].reset();
  EXPECT_THAT(warnings_of(result, 8), ElementsAre("of 2 contacts 1 were begun within 8 s"));
  result.seated.reset();
  EXPECT_THAT(warnings_of(result, 2.5),
              ElementsAre("nobody sits on chair_0 within 2.5 s", "of 2 contacts 1 were begun within 2.5 s"));
}

TEST(InteractWarnings, SayThatNobodyWalkedOffOrCameWhereTheyWereToGo) {
  Result result;
  result.seated = 60;
  result.walk_error = 0.4;
  EXPECT_THAT(warnings_of(result, 20), IsEmpty());
  result.walk_error = 1.26;
  EXPECT_THAT(warnings_of(result, 20), ElementsAre("ends 1.3 m from the place to walk to, after 20 s"));
  result.walk_error = HUGE_VAL;
  EXPECT_THAT(warnings_of(result, 20), ElementsAre("nobody gets up to walk off within 20 s"));
}

}  // namespace
}  // namespace inhabit::interact
