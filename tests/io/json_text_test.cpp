// Protects what JSON is refused for before it reaches a reader: where it ends to be JSON, and values nested so deep
// that to copy them would end the process.
#include "inhabit/io/json_text.h"

#include <gmock/gmock.h>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/config_fields.h"
#include "inhabit/io/describe.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

std::string json_refusal(const std::string& text) {
  return refusal_of([&] { parse_json(text, "x.json"); });
}

std::string nested(size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

TEST(JsonText, SaysWhereItIsNone) {
  EXPECT_EQ(json_refusal(""), "x.json: is empty, not JSON");
  EXPECT_EQ(json_refusal("{\n\"a\": 1,\n}"), "x.json: line 3 is not JSON");
  EXPECT_EQ(json_refusal("[1, 2"), "x.json: is JSON that is cut short");
  EXPECT_THAT(json_refusal("[NaN]"), HasSubstr("has NaN or Infinity"));
  EXPECT_THAT(json_refusal("[1e999]"), HasSubstr("too large"));
}

TEST(JsonText, ValuesMayLieAHundredDeep) {
  EXPECT_EQ(json_refusal(nested(100)), "");
  EXPECT_EQ(json_refusal(nested(101)), "x.json: has values over 100 deep in each other");
  EXPECT_EQ(json_refusal(nested(1'000'000)), "x.json: has values over 100 deep in each other");
  EXPECT_THAT(json_refusal("{\"a\": " + nested(100) + "}"), HasSubstr("100 deep"));
  EXPECT_EQ(json_refusal("[\"" + std::string(200, '[') + "\\\"{{\", " + nested(99) + "]"), "") << "brackets in a text";
  std::string many = "[";
  for (int k = 0; k < 200; ++k) many += nested(2) + ",";
  EXPECT_EQ(json_refusal(many + "0]"), "") << "one beside the other";
}

TEST(JsonText, WhatIsNestedTooDeepIsRefusedByThoseWhoCopyIt) {
  const std::string deep = nested(100'000);
  EXPECT_THAT(refusal_of([&] { config_object("{\"a\": " + deep + "}", "m.safetensors"); }),
              HasSubstr("m.safetensors: the configuration has values over 100 deep"));
  EXPECT_THAT(refusal_of([&] { setting_of("a=" + deep); }), HasSubstr("is no setting: KEY=VALUE"));
  const TempFolder folder;
  write_atomically(folder / "dataset.json", "{\"version\": 1, \"provenance\": " + deep + "}");
  EXPECT_THAT(refusal_of([&] { describe_file(folder / "dataset.json", {}); }), HasSubstr("dataset.json: has values"));
}

}  // namespace
}  // namespace inhabit
