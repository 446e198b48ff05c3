#include <algorithm>
#include <cstdio>
#include <tuple>

#include "inhabit/error.h"
#include "inhabit/interact/reseat_set.h"
#include "inhabit/synth/activity.h"
#include "inhabit/synth/blocked.h"
#include "inhabit/synth/chair_life.h"
#include "inhabit/synth/chairs.h"
#include "inhabit/synth/check.h"
#include "inhabit/synth/fit.h"
#include "inhabit/synth/generate.h"
#include "inputs.h"
#include "interrupted.h"
#include "progress.h"
#include "verbs.h"

namespace {

using inhabit::Bar;
using inhabit::Dataset;

const char* const kGoOn = "what is made is kept, and the same command makes the rest";

void add_passages(CLI::App& verb, double& passages) {
  verb.add_option(
          "--passages", passages,
          "Furniture close by on both sides of walks: fraction of the places tried, 0 to 1; not in rooms with decoys")
      ->capture_default_str();
}

void add_rooms(CLI::App& synth) {
  struct Given {
    std::string out, shard;
    inhabit::GenerateOptions options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand("rooms", "Make rooms and people who live in them");
  verb->add_option("--out", given->out, "Folder of the data set")->required();
  verb->add_option("--clips", given->options.clips, "Number of clips")->capture_default_str();
  verb->add_option("--seed", given->options.seed, "Seed; the same seed gives the same bytes")->capture_default_str();
  verb->add_option("--seconds", given->options.seconds, "Length of each clip")->capture_default_str();
  verb->add_option("--clips-per-room", given->options.clips_per_room, "Clips in each room")->capture_default_str();
  verb->add_option(
          "--on-chord", given->options.chords.tried,
          "Furniture on straight lines between poses that the person does not take: fraction of them tried, 0 to 1; "
          "such clips have a room of their own")
      ->capture_default_str();
  add_passages(*verb, given->options.passages);
  add_shard(*verb, given->shard);
  verb->callback([given] {
    given->options.shard = shard_of(given->shard);
    given->options.progress = progress_of("clips");
    const GoesOnLater later(kGoOn);
    std::printf("%s\n", summary(inhabit::generate_rooms(given->out, given->options)).c_str());
  });
}

void add_chairs(CLI::App& synth) {
  struct Given {
    std::string out, shard;
    inhabit::ChairsOptions options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand("chairs", "Make people who walk up to chairs and sit on them");
  verb->add_option("--out", given->out, "Folder of the data set")->required();
  verb->add_option("--minutes", given->options.minutes, "Minutes of motion")->capture_default_str();
  verb->add_option("--subjects", given->options.subjects, "Number of people")->capture_default_str();
  verb->add_option("--chairs", given->options.chairs, "Number of chairs")->capture_default_str();
  verb->add_option("--linger", given->options.linger,
                   "Seconds that half of the people stand about at most before they set off, and after walking off")
      ->capture_default_str();
  verb->add_option("--kinds", given->options.kinds, "Kinds of chairs; all by default")
      ->check(CLI::IsMember(inhabit::chair_kinds()));
  verb->add_option("--parts", given->options.parts,
                   "Parts of chairs that hands take hold of, each as often; by default what people do")
      ->check(CLI::IsMember(inhabit::seat_part_names()));
  verb->add_option("--seed", given->options.seed, "Seed; the same seed gives the same bytes")->capture_default_str();
  add_shard(*verb, given->shard);
  verb->callback([given] {
    given->options.shard = shard_of(given->shard);
    given->options.progress = progress_of("clips");
    const GoesOnLater later(kGoOn);
    std::printf("%s\n", summary(inhabit::generate_chairs(given->out, given->options)).c_str());
  });
}

void add_reseat(CLI::App& synth) {
  using inhabit::interact::NewChairs;
  struct Given {
    std::string data, out;
    std::vector<std::string> chairs;
    inhabit::interact::ReseatOptions options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand("reseat", "Carry people on chairs over to other chairs");
  verb->add_option("--data", given->data, "Data set of people on chairs, made or recorded")->required();
  verb->add_option("--chairs", given->chairs,
                   "Files of a chair each, or procedural: drawn at random, or rescaled: their own in other sizes")
      ->required();
  verb->add_option("--out", given->out, "Folder of the data set")->required();
  verb->add_option("--split", given->options.split, "Clips that are carried over")
      ->check(CLI::IsMember({"train", "val", "test", "all"}))
      ->capture_default_str();
  verb->add_flag("--frame-by-frame", given->options.frame_by_frame, "Every frame on its own, not smooth in time");
  verb->add_option("--seed", given->options.seed, "Seed; the same seed gives the same bytes")->capture_default_str();
  verb->callback([given] {
    given->options.progress = progress_of("clips");
    const bool one = given->chairs.size() == 1;
    if (one && given->chairs[0] == "procedural") {
      given->options.chairs = NewChairs::procedural;
    } else if (one && given->chairs[0] == "rescaled") {
      given->options.chairs = NewChairs::rescaled;
    } else {
      given->options.chairs = NewChairs::files;
      given->options.files = given->chairs;
    }
    const GoesOnLater later(kGoOn);
    const auto result = inhabit::interact::reseat_dataset(given->data, given->out, given->options);
    std::printf("%s\n%s\n", summary(result.dataset).c_str(), summary(result).c_str());
  });
}

void add_fit(CLI::App& synth) {
  struct Given {
    std::string out, shard;
    std::vector<std::string> mocap;
    std::pair<int, int> chord_frames;
    inhabit::FittingOptions options;
  };
  auto given = std::make_shared<Given>();
  given->chord_frames = {given->options.chords.shortest, given->options.chords.longest};
  CLI::App* verb = synth.add_subcommand("fit", "Furnish rooms around recorded motion");
  verb->add_option(
          "--mocap", given->mocap,
          "Recordings (.npz, .bvh, .amc, .txt), folders of them or patterns; those in a folder called test are "
          "kept for testing")
      ->required();
  verb->add_option("--val", given->options.val, "Recordings kept for validation; else every tenth of the others");
  verb->add_option("--test", given->options.test, "Recordings kept for testing");
  add_reading(*verb, given->options.reading, "the recordings");
  verb->add_option("--out", given->out, "Folder of the data set")->required();
  verb->add_option("--rooms-per-clip", given->options.rooms_per_clip, "Rooms around each piece")->capture_default_str();
  verb->add_option("--seconds", given->options.seconds, "Longest piece of a recording")->capture_default_str();
  verb->add_flag("--mirrored,!--not-mirrored", given->options.mirrored,
                 "Every second room of training around the mirror image of the motion (the default)");
  verb->add_option(
          "--stretches", given->options.stretches,
          "Fraction of the rooms of training that are around stretches of 4.1 to 5.5 s, where more can stand in "
          "the way")
      ->capture_default_str();
  verb->add_flag("--only-on-chord", given->options.only_on_chords,
                 "Leave out rooms of training in which nothing stands on a straight line");
  verb->add_flag(
      "--decoys", given->options.decoys,
      "Rooms of validation and testing tell less of where people go: seats and tables that they pass by, one "
      "more near each that they use, no wall within 1 m, no passages and nothing on straight lines");
  verb->add_option(
          "--on-chord", given->options.chords.tried,
          "Furniture on straight lines between poses that the person did not take: fraction of them tried, 0 to 1")
      ->capture_default_str();
  add_passages(*verb, given->options.passages);
  verb->add_option("--chord-frames", given->chord_frames, "Fewest and most frames between such poses")
      ->capture_default_str();
  verb->add_option("--seed", given->options.seed, "Seed; the same seed gives the same bytes")->capture_default_str();
  add_shard(*verb, given->shard);
  verb->callback([given] {
    given->options.shard = shard_of(given->shard);
    add_recordings(given->options, given->mocap);
    std::tie(given->options.chords.shortest, given->options.chords.longest) = given->chord_frames;
    given->options.progress = progress_of("recording");
    const GoesOnLater later(kGoOn);
    const Dataset made = inhabit::fit_recordings(given->out, given->options);
    say(made.provenance.value("doubts", inhabit::Notes()));
    std::printf("%s\n", summary(made).c_str());
    std::printf("%.1f minutes were recorded, %.1f of them have rooms\n",
                made.provenance.at("recorded_minutes").get<double>(),
                made.provenance.at("furnished_minutes").get<double>());
    const auto skipped = made.provenance.value("skipped", std::vector<std::string>());
    end_of({static_cast<int64_t>(made.provenance.at("recordings").size()), skipped});
  });
}

void add_check(CLI::App& synth) {
  struct Given {
    std::string folder, split = "all";
    bool json = false;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand("check", "Measure a data set's motion; exit code 1 where a bar is missed");
  verb->add_option("folder", given->folder, "Folder of the data set")->required();
  verb->add_option("--split", given->split, "train, val, test or all")->capture_default_str();
  verb->add_flag("--json", given->json, "Print JSON");
  verb->callback([given] {
    const Dataset dataset = inhabit::open_dataset(given->folder);
    if (dataset.split(given->split).empty())
      throw inhabit::Error(given->folder, "has no clips in split \"" + given->split + "\"");
    const std::vector<Bar> bars = inhabit::check_motion(dataset, given->split, progress_of("clips"));
    std::printf("%s", given->json ? (bars_json(bars).dump(1) + "\n").c_str() : bars_text(bars).c_str());
    if (!std::all_of(bars.begin(), bars.end(), [](const Bar& bar) { return bar.pass(); })) throw CLI::RuntimeError(1);
  });
}

void add_blocked(CLI::App& synth) {
  struct Given {
    std::string folder, split = "train";
    inhabit::BlockedOptions options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand(
      "blocked", "Count windows in which the straight path between keys collides and the motion does not");
  verb->add_option("folder", given->folder, "Folder of the data set")->required();
  verb->add_option("--split", given->split, "train, val, test or all")->capture_default_str();
  verb->add_option("--frames", given->options.frames, "Frames of a window")->capture_default_str();
  verb->add_option("--every", given->options.every, "Frames between keys")->capture_default_str();
  verb->add_option("--stride", given->options.stride, "Frames between the starts of windows")->capture_default_str();
  verb->add_option("--clips", given->options.clips, "At most so many clips, evenly spread; 0: all")
      ->capture_default_str();
  verb->callback([given] {
    const auto found = inhabit::blocked_windows(inhabit::open_dataset(given->folder), given->split, given->options);
    if (found.windows == 0) throw inhabit::Error(given->folder, "has no window of that length in a scene");
    const auto percent = [&](int64_t n) { return 100 * static_cast<double>(n) / static_cast<double>(found.windows); };
    std::printf("%s: %lld windows of %lld clips; blocked %.1f %%, colliding themselves %.1f %%\n",
                given->folder.c_str(), static_cast<long long>(found.windows), static_cast<long long>(found.clips),
                percent(found.blocked), percent(found.colliding));
    std::printf("frames that collide: straight %.4f, real %.4f\n", found.straight, found.real);
  });
}

void add_activity(CLI::App& synth) {
  struct Given {
    std::string folder, split = "all";
    double cutoff = 6;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = synth.add_subcommand("activity", "Measure how people move, by what they do");
  verb->add_option("folder", given->folder, "Folder of the data set")->required();
  verb->add_option("--split", given->split, "train, val, test or all")->capture_default_str();
  verb->add_option("--low-pass", given->cutoff, "Hz at which the low-pass of the last two columns halves the power")
      ->capture_default_str();
  verb->callback([given] {
    const auto found = inhabit::dynamics_by_activity(inhabit::open_dataset(given->folder), given->split, given->cutoff);
    std::printf("%s", text_of(activity_table(found)).c_str());
  });
}

}  // namespace

void add_synth(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("synth", "Make data sets: rooms, people in them, rooms around recordings");
  verb->require_subcommand(1);
  add_rooms(*verb);
  add_chairs(*verb);
  add_reseat(*verb);
  add_fit(*verb);
  add_check(*verb);
  add_blocked(*verb);
  add_activity(*verb);
}
