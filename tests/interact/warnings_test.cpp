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

}  // namespace
}  // namespace inhabit::interact
