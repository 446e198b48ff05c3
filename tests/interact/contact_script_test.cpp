// Protects files of contacts: parts by name and points, hands that are left free, where to walk in the end, and what is
// wrong is said.
#include "inhabit/interact/contact_script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "inhabit/interact/contact_area.h"
#include "interact/sitter.h"
#include "refusal_of.h"

namespace inhabit::interact {
namespace {

using ::testing::HasSubstr;

TEST(ContactScript, HoldsPartsPointsAndAPlaceToWalkTo) {
  const Chair chair = find_chair(seat_scene(), "chair_0");
  const ContactScript script = parse_contact_script(
      R"([{"left": "front", "right": [0.1, 0.45, 0.2]}, {"left": "none", "right": null}, {"walk_to": [1, 2, 90]}])",
      "s.json", chair);
  ASSERT_EQ(script.contacts.size(), 2U);
  EXPECT_TRUE(script.contacts[0][0]->isApprox(contact_on(chair, "front", 0)));
  EXPECT_TRUE(script.contacts[0][1]->isApprox(Eigen::Vector3d(0.1, 0.45, 0.2)));
  EXPECT_FALSE(script.contacts[1][0] || script.contacts[1][1]);
  EXPECT_TRUE(script.then_walk->isApprox(Eigen::Vector3d(1, 2, M_PI / 2)));
  EXPECT_FALSE(parse_contact_script("[{}]", "s.json", chair).then_walk);
}

TEST(ContactScript, ReadsWhatContactsAreWrittenAs) {
  const Chair chair = find_chair(seat_scene(), "chair_0");
  const nlohmann::json text = contacts_json({{Eigen::Vector3d(0.5, 0.25, -1), std::nullopt}, {}});
  EXPECT_EQ(text.dump(), R"([{"left":[0.5,0.25,-1.0]},{}])");
  const ContactScript script = parse_contact_script(text.dump(), "s.json", chair);
  ASSERT_EQ(script.contacts.size(), 2U);
  EXPECT_EQ(*script.contacts[0][0], Eigen::Vector3d(0.5, 0.25, -1));
  EXPECT_FALSE(script.contacts[0][1] || script.contacts[1][0] || script.contacts[1][1]);
}

TEST(ContactScript, AHandsEntryIsNullAPartOrAPoint) {
  const auto place = [](const char* text) { return contact_place(nlohmann::json::parse(text)); };
  EXPECT_EQ(place("null"), ContactPlace());
  EXPECT_EQ(place("\"armrest\""), ContactPlace("armrest"));
  EXPECT_EQ(place("[1, 2.5, -3]"), ContactPlace(Eigen::Vector3d(1, 2.5, -3)));
  for (const char* wrong : {"3", "[1, 2]", "[1, 2, \"x\"]", "{}", "true"})
    EXPECT_EQ(refusal_of([&] { place(wrong); }), "neither a part of the chair nor [x, y, z]") << wrong;
}

TEST(ContactScript, SaysWhatIsWrong) {
  const Chair chair = find_chair(seat_scene(), "chair_0");
  const auto said = [&](const char* text) { return refusal_of([&] { parse_contact_script(text, "s.json", chair); }); };
  EXPECT_THAT(said("[{\"left\":"), HasSubstr("s.json: is JSON that is cut short"));
  EXPECT_THAT(said("{}"), HasSubstr("is no JSON list of contacts"));
  EXPECT_THAT(said("[]"), HasSubstr("is no JSON list of contacts"));
  EXPECT_THAT(said("[1]"), HasSubstr("no object"));
  EXPECT_THAT(said(R"([{"left": [1, 2]}])"), HasSubstr("left: neither a part"));
  EXPECT_THAT(said(R"([{"right": "roof"}])"), HasSubstr("roof"));
  EXPECT_THAT(said(R"([{"walk_to": [1, 2]}])"), HasSubstr("walk_to: is no [x, z, heading]"));
  EXPECT_THAT(said(R"([{"walk_to": [1, 2, 3]}, {}])"), HasSubstr("no last entry"));
  EXPECT_THAT(refusal_of([&] { read_contact_script("/nowhere/s.json", chair); }), HasSubstr("/nowhere/s.json"));
}

}  // namespace
}  // namespace inhabit::interact
