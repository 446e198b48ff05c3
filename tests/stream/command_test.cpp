// Protects `inhabit stream` as a robot runs it: every line in is answered or not by what docs/robots.md says, bad lines
// cost one line of error each, and the process goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/command.h"
#include "cli/refusal.h"
#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/io/pose_line.h"
#include "poses.h"

namespace inhabit {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::string kRoom = INHABIT_SOURCE_DIR "/examples/data/walk_room.glb";

std::string pose_line(double time, const std::string& person, const torch::Tensor& joints) {
  json places = json::array();
  for (int64_t j = 0; j < joints.size(0); ++j) {
    json& place = places.emplace_back(json::array());
    for (int64_t k = 0; k < 3; ++k) place.push_back(joints[j][k].item<float>());
  }
  return json{{"time", time}, {"person", person}, {"joints", places}}.dump() + "\n";
}

/// The lines that `inhabit stream ARGUMENTS` says to `input`.
std::vector<json> answers(const std::string& arguments, const std::string& input) {
  const TempFolder folder;
  std::ofstream(folder / "in") << input;
  const CommandResult r = run_command("stream " + arguments + " < " + folder / "in");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  std::vector<json> out;
  std::istringstream lines(r.out);
  for (std::string line; std::getline(lines, line);) out.push_back(json::parse(line));
  return out;
}

torch::Tensor places(const json& nested) {
  std::vector<float> numbers;
  for (const json& frame : nested)
    for (const json& joint : frame)
      for (const json& x : joint) numbers.push_back(x.get<float>());
  return torch::tensor(numbers).view({static_cast<int64_t>(nested.size()), -1, 3});
}

std::string recording(const std::string& person = "anna") {
  std::string out;
  for (int64_t t = 0; t < 60; ++t) out += pose_line(static_cast<double>(t) / 30, person, walk().joints[t]);
  return out;
}

TEST(StreamCommand, ForecastsAsTheFacadeDoes) {
  const auto lines = answers("forecast --rate 2 --scene " + kRoom, recording());
  ASSERT_EQ(lines.size(), 4);
  EXPECT_EQ(lines[0]["ready"], "forecast");
  EXPECT_EQ(lines[0]["names"].size(), 22);
  EXPECT_EQ(lines[0]["rate"], 30);
  const auto forecaster = forecast::ContactForecaster::load(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors");
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(lines[i]["person"], "anna");
    const auto end = static_cast<int64_t>(std::round(lines[i]["time"].get<double>() * 30)) + 1;
    EXPECT_EQ(end, static_cast<int64_t>(15 * (i + 1)));
    forecast::Options options;
    options.joints_alone = true;
    const auto expected = forecaster.run(slice(walk(), end - 30, end), walk_room(), options);
    EXPECT_LT(largest_difference(places(lines[i]["joints"]), expected.forecast.joints), 2e-4F);
  }
}

TEST(StreamCommand, TakesAModelByNameOrPath) {
  const auto said = [](const std::string& model) {
    return answers("forecast --rate 2 --model " + model + " --scene " + kRoom, recording());
  };
  const auto by_path = said(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors");
  ASSERT_EQ(by_path.size(), 4);
  EXPECT_EQ(said("forecast-compact"), by_path);
  EXPECT_EQ(said("forecast-compact.safetensors"), by_path);
  EXPECT_EQ(answers("anticipate --model anticipate-cmu", "").at(0)["ready"], "anticipate");
  const CommandResult r = run_command("stream anticipate --model no-such-model </dev/null");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(r.err, HasSubstr("no-such-model: there is no such file, nor a model of this name"));
}

TEST(StreamCommand, QuietSaysNothingBesideAnswers) {
  const auto err = [](const std::string& more) { return run_command("stream forecast" + more + " </dev/null").err; };
  EXPECT_THAT(err(""), HasSubstr("no scene given"));
  EXPECT_EQ(err(" --quiet"), "");
}

TEST(StreamCommand, AWorldWithZUpIsAnsweredInItself) {
  const auto y_up = answers("forecast --rate 1 --every 10", recording());
  std::string turned;
  for (int64_t t = 0; t < 60; ++t) {
    const torch::Tensor p = walk().joints[t];
    turned += pose_line(static_cast<double>(t) / 30, "anna",
                        torch::stack({p.select(1, 0), -p.select(1, 2), p.select(1, 1)}, 1));
  }
  const auto z_up = answers("forecast --rate 1 --every 10 --up z", turned);
  ASSERT_EQ(y_up.size(), 3);
  ASSERT_EQ(z_up.size(), 3);
  EXPECT_EQ(z_up[0]["rate"], 3);
  const torch::Tensor y = places(y_up[1]["joints"]), z = places(z_up[1]["joints"]);
  ASSERT_EQ(y.size(0), 6);
  EXPECT_LT(largest_difference(y.select(2, 1), z.select(2, 2)), 5e-4F);
  EXPECT_LT(largest_difference(y.select(2, 2), -z.select(2, 1)), 5e-4F);
}

TEST(StreamCommand, AnotherUpAxisOrUnitIsSaidOnceOfEachPerson) {
  std::string input;
  for (int64_t t = 0; t < 60; ++t) {
    const torch::Tensor p = walk().joints[t];
    const double time = static_cast<double>(t) / 30;
    input += pose_line(time, "well", p) + pose_line(time, "millimetres", p * 1000) +
             pose_line(time, "z-up", torch::stack({p.select(1, 0), -p.select(1, 2), p.select(1, 1)}, 1));
  }
  std::map<std::string, std::string> warnings;
  for (const json& line : answers("anticipate --rate 4 --samples 1", input))
    if (line.contains("warning")) warnings[line["person"]] += line["warning"].get<std::string>() + "|";
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_THAT(warnings["millimetres"], testing::MatchesRegex("implausible: the legs are [^|]* metres[^|]*\\|"));
  EXPECT_THAT(warnings["z-up"], testing::MatchesRegex("implausible: the person lies throughout; [^|]*--up z[^|]*\\|"));
}

TEST(StreamCommand, BadLinesAreAnsweredAndTheStreamGoesOn) {
  std::string input = "\n{\"time\":0\n";                              // line 2: cut short
  input += std::string((1 << 20) + 7, 'x') + "\n";                    // line 3: too long
  input += "{\"time\":0,\"person\":\"b\",\"joints\":[[NaN,0,0]]}\n";  // line 4
  input += "{\"time\":0,\"person\":\"b\",\"joints\":[[0,0,0]]}\n";    // line 5: one joint
  input += std::string(100000, '[') + "\n";                           // line 6
  input += std::string("\xff\xfe\0\x01", 4) + "\n";                   // line 7
  input += "{\"names\":[\"pelvis\",\"knee\"]}\n";                     // line 8: after the first pose
  input += recording();
  input += pose_line(1, "anna", walk().joints[0]);         // line 69: in the past
  input += "{\"time\":5,\"person\":\"anna\",\"joints\":";  // line 70: the end comes first
  const auto lines = answers("forecast --rate 1 --points 64 --every 60", input);
  std::vector<int> refused;
  int forecasts = 0;
  for (const json& line : lines) {
    if (line.contains("line")) refused.push_back(line["line"].get<int>());
    if (line.contains("joints")) ++forecasts;
  }
  EXPECT_THAT(refused, testing::ElementsAre(2, 3, 4, 5, 6, 7, 8, 69, 70));
  EXPECT_EQ(forecasts, 2);
}

TEST(StreamCommand, WhatCannotBeForecastSaysOfWhom) {
  std::string input;
  for (int64_t t = 0; t < 30; ++t) input += pose_line(static_cast<double>(t) / 30, "\"far\"", walk().joints[t] + 500);
  const auto lines = answers("forecast --scene " + kRoom, input);
  ASSERT_EQ(lines.size(), 2);
  EXPECT_EQ(lines[1]["person"], "\"far\"");
  EXPECT_THAT(lines[1]["error"].get<std::string>(), HasSubstr("lies within 2.50 m"));
}

TEST(StreamCommand, AnticipatesOtherNamesToo) {
  std::string input = "{\"names\":[";
  for (int j = 21; j >= 0; --j)
    input += "\"" + standard_joint_names()[static_cast<size_t>(j)] + "\"" + (j > 0 ? "," : "]}\n");
  for (int64_t t = 0; t < 30; ++t) input += pose_line(static_cast<double>(t) / 30, "7", walk().joints[t].flip(0));
  const auto lines = answers("anticipate --rate 1 --samples 3 --seconds 1", input);
  ASSERT_EQ(lines.size(), 2);
  EXPECT_EQ(lines[0]["ready"], "anticipate");
  ASSERT_EQ(lines[1]["futures"].size(), 3);
  EXPECT_EQ(lines[1]["futures"][0].size(), 25);
  EXPECT_EQ(lines[1]["labels"][0].size(), 25);
  const auto at = static_cast<int64_t>(std::round(lines[1]["time"].get<double>() * 30));
  EXPECT_LT(largest_difference(places(lines[1]["futures"][0])[0][0], walk().joints[at][0]), 0.15F);
}

TEST(StreamCommand, LiveLeavesOutWhatCannotBeKeptUpWith) {
  std::string input;
  for (int64_t t = 0; t < 3000; ++t) input += pose_line(static_cast<double>(t) / 30, "a", walk().joints[t % 90]);
  const auto live = answers("forecast --rate 30 --live --every 60 --points 64", input);
  EXPECT_GT(live.size(), 1);
  EXPECT_LT(live.size(), 2000) << "a hundred seconds of poses that are there at once";
  EXPECT_NEAR(live.back()["time"].get<double>(), 2999 / 30.0, 1e-6) << "the last word is of the last pose";
}

TEST(StreamCommand, BadArgumentsAreRefusedInOneLine) {
  const TempFolder folder;
  const std::string out = folder.path.string();
  expect_refused("stream", {"forecast, anticipate"}, out);
  expect_refused("stream forecast --scene " + folder / "none.glb", {"none.glb"}, out);
  expect_refused("stream forecast --model " + kRoom, {"walk_room.glb"}, out);
  for (const char* option :
       {"--rate 0", "--rate nan", "--up x", "--every 0", "--every 61", "--people 0", "--gap 1000", "--points 1"})
    expect_refused(std::string("stream forecast ") + option,
                   {std::string(option).substr(0, std::string(option).find(' '))}, out);
  expect_refused("stream anticipate --samples 0", {"--samples"}, out);
  expect_refused("stream anticipate --seconds 1e9", {"--seconds"}, out);
}

}  // namespace
}  // namespace inhabit
