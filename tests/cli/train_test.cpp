// Protects `inhabit train forecast`: every stage leaves its network in the model file, a run that was interrupted goes
// on to the numbers of one that was not, and what cannot be trained is refused in one line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "cli/tiny_rooms.h"
#include "inhabit/data/native.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/io/safetensors.h"

namespace inhabit {
namespace {

using nlohmann::json;

const std::string kSmallBaselines =
    "baselines.ltd_hidden=16 baselines.ltd_blocks=2 baselines.hisrep_hidden=16 baselines.hisrep_blocks=2 "
    "baselines.dmgnn_width=2 baselines.slt_goal=16 baselines.slt_path=4 baselines.slt_pose=8";
const std::string kShipped = INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors";

std::map<std::string, torch::Tensor> of_network(const SafeTensors& file, const std::string& prefix) {
  std::map<std::string, torch::Tensor> out;
  for (const auto& entry : file.tensors)
    if (entry.first.rfind(prefix, 0) == 0) out.insert(entry);
  return out;
}

std::vector<json> log_of(const std::string& model) {
  std::istringstream text(read_whole_file(model + ".log.jsonl"));
  std::vector<json> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
  return lines;
}

TEST(Train, EveryStageLeavesItsNetworkInTheModelFile) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder), model = folder / "model.safetensors";
  const CommandResult r = run_command("train forecast --stage all --data " + data + " --out " + model +
                                      " --set decoder=recurrent training.contact_steps=2 training.motion_steps=4"
                                      " training.adapt_steps=2 training.contact_batch=2 training.motion_batch=2"
                                      " " +
                                      kSmallBaselines);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const SafeTensors trained = read_safetensors(model);
  const SafeTensors shipped = read_safetensors(kShipped);
  EXPECT_EQ(trained.metadata.at("system"), shipped.metadata.at("system"));
  EXPECT_THAT(trained.metadata.at("config"), ::testing::HasSubstr("\"preset\":\"compact\""));
  for (const char* network :
       {"contact_net.", "motion_net.", "no_contact_net.", "ltd_net.", "hisrep_net.", "dmgnn_net.", "slt_net."})
    EXPECT_GT(of_network(trained, network).size(), 10U) << network;
  EXPECT_FALSE(std::filesystem::exists(model + ".checkpoint.safetensors"));

  std::map<std::string, int64_t> last_step;
  for (const json& line : log_of(model)) {
    last_step[line.at("stage")] = line.at("step");
    if (line.contains("validation"))
      EXPECT_TRUE(line["validation"].is_number()) << line;  // JSON has no NaN: it would read null
    else
      for (const auto& [name, value] : line.at("losses").items()) EXPECT_TRUE(value.is_number()) << name;
  }
  EXPECT_EQ(last_step, (std::map<std::string, int64_t>{{"contact", 2},
                                                       {"motion", 4},
                                                       {"no_contact", 4},
                                                       {"ltd", 4},
                                                       {"hisrep", 4},
                                                       {"dmgnn", 4},
                                                       {"slt", 4},
                                                       {"adapt", 2}}));

  const CommandResult f = run_command("forecast " + kWalk + " --model " + model + " -o " + folder / "f.npz");
  EXPECT_EQ(f.exit_code, 0) << f.err;

  // A stage of its own keeps what the file holds of the others.
  ASSERT_EQ(run_command("train forecast --stage motion --set decoder=recurrent training.contact_steps=2 "
                        "training.motion_steps=4 training.adapt_steps=2"
                        " training.contact_batch=2 training.motion_batch=2 " +
                        kSmallBaselines + " --seed 9 --data " + data + " --out " + model)
                .exit_code,
            0);
  const SafeTensors after = read_safetensors(model);
  for (const auto& [name, tensor] : of_network(trained, "contact_net."))
    EXPECT_TRUE(torch::equal(after.tensors.at(name), tensor)) << name;
  EXPECT_FALSE(
      torch::equal(after.tensors.at("motion_net.x_enc.weight"), trained.tensors.at("motion_net.x_enc.weight")));
  ASSERT_EQ(run_command("train forecast --stage contact --set decoder=recurrent training.contact_steps=2 "
                        "training.motion_steps=4 training.adapt_steps=2"
                        " training.contact_batch=2 training.motion_batch=2 " +
                        kSmallBaselines + " --data " + data + " --out " + model)
                .exit_code,
            0);
  const SafeTensors last = read_safetensors(model);
  for (const auto& [name, tensor] : of_network(after, "motion_net."))
    EXPECT_TRUE(torch::equal(last.tensors.at(name), tensor)) << name;

  // A baseline of another size than that of --from begins anew; the other networks come along, with their sizes.
  const std::string larger = folder / "larger.safetensors";
  const CommandResult l =
      run_command("train forecast --stage ltd --from " + model + " --data " + data + " --out " + larger +
                  " --set decoder=recurrent training.motion_steps=1 baselines.ltd_hidden=24 baselines.ltd_blocks=2");
  ASSERT_EQ(l.exit_code, 0) << l.err;
  const SafeTensors grown = read_safetensors(larger);
  for (const char* network : {"contact_net.", "motion_net.", "hisrep_net.", "dmgnn_net.", "slt_net."})
    for (const auto& [name, tensor] : of_network(last, network))
      EXPECT_TRUE(torch::equal(grown.tensors.at(name), tensor)) << name;
  EXPECT_EQ(grown.tensors.at("ltd_net.in.bias").size(0), 24);
  const CommandResult e = run_command("eval forecast --data " + data + " --split val --model " + larger);
  ASSERT_EQ(e.exit_code, 0) << e.err;
  for (const char* row : {"LTD", "HisRep", "DMGNN", "SLT*"}) EXPECT_THAT(e.out, ::testing::HasSubstr(row));
}

TEST(Train, ThePresetsOwnStagesGiveAModelThatForecasts) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder), model = folder / "model.safetensors";
  const CommandResult r = run_command("train forecast --data " + data + " --out " + model +
                                      " --set training.contact_steps=2 training.motion_steps=4 articulated.width=16"
                                      " training.hypotheses_steps=2 articulated.hypotheses=3"
                                      " training.contact_batch=2 training.motion_batch=2");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const SafeTensors trained = read_safetensors(model);
  for (const char* network : {"contact_net.", "articulated_net.", "hypotheses_net."})
    EXPECT_GT(of_network(trained, network).size(), 10U) << network;
  EXPECT_TRUE(of_network(trained, "motion_net.").empty());
  const CommandResult f = run_command("forecast " + kWalk + " --model " + model + " -o " + folder / "f.npz");
  EXPECT_EQ(f.exit_code, 0) << f.err;
  const CommandResult several =
      run_command("forecast " + kWalk + " --samples 3 --model " + model + " -o " + folder / "s.npz");
  EXPECT_EQ(several.exit_code, 0) << several.err;
  EXPECT_EQ(read_clips(folder / "s.npz").size(), 3U);
  const CommandResult table = run_command("eval forecast --data " + data + " --split val --model " + model);
  EXPECT_EQ(table.exit_code, 0) << table.err;
  for (const char* row : {"predicted contact", "likeliest of 3", "best of 3"})
    EXPECT_THAT(table.out, ::testing::HasSubstr(row));
  std::filesystem::create_directory(folder / "none");
  expect_refused("forecast " + kWalk + " --samples 4 --model " + model + " -o " + folder / "none/s.npz",
                 {"samples", "3 ways to go on"}, folder / "none");
  const CommandResult further = run_command("train forecast --stage hypotheses --from " + model + " --data " + data +
                                            " --out " + folder / "further.safetensors" +
                                            " --set articulated.width=16 articulated.hypotheses=3"
                                            " training.hypotheses_steps=1 training.motion_batch=2");
  ASSERT_EQ(further.exit_code, 0) << further.err;
  const SafeTensors after = read_safetensors(folder / "further.safetensors");
  for (const char* network : {"contact_net.", "articulated_net."})
    for (const auto& [name, tensor] : of_network(trained, network))
      EXPECT_TRUE(torch::equal(after.tensors.at(name), tensor)) << name << " stays as it is";
  EXPECT_FALSE(
      torch::equal(after.tensors.at("hypotheses_net.out.bias"), trained.tensors.at("hypotheses_net.out.bias")));
  const CommandResult e = run_command("eval contacts --data " + data + " --split val --model " + model);
  EXPECT_EQ(e.exit_code, 0) << e.err;
  for (const char* part : {"feet on the floor", "all others", "left_wrist", "L = 12", "precision"})
    EXPECT_THAT(e.out, ::testing::HasSubstr(part));
}

/// As `torchrun` starts them; that their weights are those of one process is protected by tests/train.
TEST(Train, TwoProcessesMakeOneModel) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder), model = folder / "model.safetensors",
                    port = std::to_string(20000 + ::getpid() % 20000),
                    train = std::string(command_at_hand()) +
                            " train forecast --stage contact --set decoder=recurrent training.contact_steps=2"
                            " training.motion_steps=1 training.adapt_steps=1 training.contact_batch=1"
                            " training.motion_batch=1 --data " +
                            data + " --out " + model;
  const CommandResult r =
      run_program("sh -c 'export WORLD_SIZE=2 MASTER_PORT=" + port + "; RANK=1 " + train + " & other=$!; RANK=0 " +
                  train + "; echo rank 0 ended with $?; wait $other; echo rank 1 ended with $?'");
  EXPECT_THAT(r.out, ::testing::HasSubstr("rank 0 ended with 0")) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("rank 1 ended with 0")) << r.err;
  const std::string said = r.out + r.err, wrote = "wrote " + model;
  EXPECT_NE(said.find(wrote), std::string::npos) << said;
  EXPECT_EQ(said.find(wrote), said.rfind(wrote)) << "one of them writes";
  std::set<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path)) left.insert(entry.path().filename());
  EXPECT_EQ(left, (std::set<std::string>{"model.safetensors", "model.safetensors.log.jsonl", "rooms"}));
  EXPECT_GT(of_network(read_safetensors(model), "contact_net.").size(), 10U);
  std::vector<int64_t> steps;
  for (const json& line : log_of(model))
    if (line.contains("losses")) steps.push_back(line.at("step"));
  EXPECT_EQ(steps, (std::vector<int64_t>{1, 2})) << "one of them logs";
}

/// Resuming itself is protected by tests/forecast/train_test.cpp; here, what a shell is told.
TEST(Train, AnInterruptedRunEndsWith130AndSaysHowToGoOn) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder), model = folder / "m.safetensors", said = folder / "said";
  // A pipe: `read` waits for the first line that the run says, and the run is far from its end then.
  const CommandResult r = run_program(
      "sh -c 'mkfifo " + said + "; " INHABIT_COMMAND " train forecast --stage motion --set" +
      " decoder=recurrent training.motion_steps=100000 training.motion_batch=2 --data " + data + " --out " + model +
      " >" + said + " & pid=$!; exec 3<" + said + "; read line <&3; kill -INT $pid; cat <&3; wait $pid'");
  EXPECT_EQ(r.exit_code, 130) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("--resume goes on from there"));
  EXPECT_TRUE(std::filesystem::exists(model + ".checkpoint.safetensors"));
}

struct Refused : TempFolder {
  std::string out = *this / "out";
  Refused() { std::filesystem::create_directory(out); }
  void expect(const std::string& options, const std::vector<std::string>& parts) const {
    expect_refused(
        "train forecast --set training.motion_steps=1 training.contact_steps=1 training.adapt_steps=1 "
        "training.contact_batch=1 training.motion_batch=1 " +
            options,
        parts, out);
  }
};

TEST(Train, RefusesDataThatCannotBeTrainedOn) {
  const Refused bad;
  const std::string out = " --out " + bad.out + "/m.safetensors";
  bad.expect("--data " + bad / "none" + out, {bad / "none", "no such file"});
  bad.expect("--data " INHABIT_SOURCE_DIR "/examples/data" + out,
             {"examples/data", "is no data set but a folder of motion"});
  ASSERT_EQ(run_command("synth rooms --clips 1 --seconds 4 --out " + bad / "one").exit_code, 0);
  bad.expect("--data " + bad / "one" + out, {bad / "one", "no validation window"});
  ASSERT_EQ(run_command("synth rooms --clips 3 --clips-per-room 1 --seconds 2.5 --out " + bad / "short").exit_code, 0);
  bad.expect("--data " + bad / "short" + out, {bad / "short", "no training window of 90 frames"});
  const std::string holes = make_tiny_rooms(bad);
  std::filesystem::remove(holes + "/" + open_dataset(holes).split("val").back().file);
  bad.expect("--data " + holes + out, {holes + "/clips/", "there is no such file"});
}

TEST(Train, GoesOnWithoutClipsThatCannotBeReadAndSaysSo) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder);
  const auto clips = open_dataset(data).split("train");
  ASSERT_EQ(clips.size(), 2U);
  std::filesystem::resize_file(data + "/" + clips[0].file, 200);
  const CommandResult r = run_command(
      "train forecast --stage motion --set decoder=recurrent training.motion_steps=1 training.motion_batch=1 --data " +
      data + " --out " + folder / "m.safetensors");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  for (const std::string& part :
       {"skipped: " + data + "/" + clips[0].file + ": ", data + ": 1 of 2 clips were skipped"})
    EXPECT_THAT(r.out + r.err, ::testing::HasSubstr(part));
}

TEST(Train, RefusesToResumeAdaptOrWriteWhatIsNotThere) {
  const Refused bad;
  const std::string data = "--data " + make_tiny_rooms(bad), out = " --out " + bad.out + "/m.safetensors";
  bad.expect(data + out + " --resume", {"m.safetensors.checkpoint.safetensors", "no such file"});
  bad.expect(data + out + " --set decoder=recurrent --stage adapt",
             {"m.safetensors", "lacks the contact or the motion network"});
  bad.expect(data + out + " --stage adapt",
             {"stage 'adapt'", "there are contact, motion, hypotheses, ltd, hisrep, dmgnn, slt"});
  bad.expect(data + out + " --stage motion", {"m.safetensors", "lacks the contact network"});
  bad.expect(data + " --out " + bad / "none/m.safetensors", {"none/m.safetensors", "there is no folder"});

  const std::string contact = bad / "contact.safetensors";
  ASSERT_EQ(run_command("train forecast " + data +
                        " --stage contact --set decoder=recurrent training.motion_steps=1 training.contact_steps=1"
                        " training.adapt_steps=1 training.contact_batch=1 training.motion_batch=1 --out " +
                        contact)
                .exit_code,
            0);
  const std::string before = read_whole_file(contact);
  bad.expect(data + " --set decoder=recurrent --stage adapt --out " + contact,
             {contact, "lacks the contact or the motion network"});
  EXPECT_EQ(read_whole_file(contact), before);
}

TEST(Train, RefusesOptionsThatMakeNoSense) {
  const Refused bad;
  const std::string given = "--data " INHABIT_SOURCE_DIR "/examples/data --out " + bad.out + "/m.safetensors ";
  bad.expect(given + "--preset huge", {"preset", "huge"});
  bad.expect(given + "--stage last", {"stage", "last"});
  bad.expect(given + "--device tpu", {"device", "tpu"});
  expect_refused("train forecast --set training.contact_batch=0 " + given, {"training.contact_batch"}, bad.out);
  expect_refused("train forecast --set training.motion_steps=-3 " + given, {"training.motion_steps"}, bad.out);
}

}  // namespace
}  // namespace inhabit
