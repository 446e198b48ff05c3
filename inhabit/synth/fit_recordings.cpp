#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "inhabit/data/dataset_items.h"
#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "inhabit/io/many_files.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/floor.h"
#include "inhabit/motion/mirror.h"
#include "inhabit/motion/plausible.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/synth/fit.h"
#include "inhabit/synth/passages.h"
#include "inhabit/synth/person.h"

namespace inhabit {

namespace {

constexpr double kHighBall =
    0.12;  // metres: a foot that high stands on something else than the floor, or is in the air
constexpr double kLongestJump = 0.7;  // seconds
constexpr double kBelowFloor = -0.06;
constexpr double kHardestMove = 350;  // m/s^2 of a joint: kicks, throws and landings of recordings stay under 270

struct Recording {
  std::string file, split;
};

/// (T) bool: frames that a flat floor at y = 0 explains.
torch::Tensor on_floor(const Clip& clip) {
  const torch::Tensor high = clip.joints.select(2, 1).slice(1, 10, 12).amin(1) > kHighBall;
  const torch::Tensor low = clip.joints.select(2, 1).amin(1) < kBelowFloor;
  torch::Tensor out = torch::ones({clip.frames()}, torch::kBool);
  const auto jump = static_cast<int64_t>(kLongestJump * clip.rate);
  for (int64_t t = 0, first = 0; t <= clip.frames(); ++t) {
    if (t < clip.frames() && high[t].item<bool>()) continue;
    if (t - first > jump) out.slice(0, first, t).fill_(false);
    first = t + 1;
  }
  return out & ~low;
}

/// (T) bool: frames in which a joint leaps as no body does: a file's rest pose before its motion, limbs that changed
/// places, a frame that is missing.
torch::Tensor broken(const Clip& clip) {
  torch::Tensor out = torch::zeros({clip.frames()}, torch::kBool);
  if (clip.frames() < 3) return out;
  const double squared = clip.rate * clip.rate;
  const torch::Tensor hard = torch::diff(clip.joints, 2, 0).norm(2, 2).amax(1) * squared > kHardestMove;
  for (int64_t k = 0; k < 3; ++k) out.slice(0, k, clip.frames() - 2 + k).logical_or_(hard);
  return out;
}

std::vector<Recording> split_recordings(const FittingOptions& options) {
  const size_t n = options.train.size();
  const size_t held_out = options.test.empty() && n >= 3 ? std::max<size_t>(1, n / 10) : 0;
  std::vector<Recording> out;
  for (size_t i = 0; i < n; ++i) {
    const bool val = options.val.empty() && i % 10 == 9;
    out.push_back({options.train[i], i >= n - held_out ? "test" : val ? "val" : "train"});
  }
  for (const auto& [files, split] : {std::pair(&options.val, "val"), std::pair(&options.test, "test")})
    for (const std::string& file : *files) {
      if (std::any_of(out.begin(), out.end(), [&](const Recording& r) { return r.file == file; }))
        throw Error(file, "is given twice: for training, validation and testing there are files of their own");
      out.push_back({file, split});
    }
  for (const Recording& r : out)
    if (!std::filesystem::exists(r.file)) throw Error(r.file, "there is no such file");
  return out;
}

/// Stretches of 123 to 165 frames that follow one another from a random start. In so short a time less of the floor is
/// walked on, so that more can stand where a straight path would pass.
std::vector<Clip> stretches_of(const Clip& piece, std::mt19937_64& random) {
  constexpr int kShortest = 123, kLongest = 165;
  std::vector<Clip> out;
  const auto frames = static_cast<int>(piece.frames());
  for (int first = uniform_int(random, 0, std::clamp(frames - kShortest, 0, kShortest)); first + kShortest <= frames;) {
    const int last = std::min(frames, first + uniform_int(random, kShortest, kLongest));
    out.push_back(slice(piece, first, last));
    first = last;
  }
  return out;
}

/// The pieces of a recording in their rooms, put into `clips`, and as facts how many seconds were recorded and how many
/// of them have a room.
nlohmann::json furnish_recording(const Dataset& out, const Recording& recording, size_t number,
                                 const FittingOptions& options, std::vector<DatasetClip>& clips) {
  const std::string name = std::filesystem::path(recording.file).filename().string();
  const bool train = recording.split == "train";
  Notes notes;
  const Clip source = read_clip(recording.file, options.reading, &notes);
  std::erase_if(notes, [](const std::string& note) { return !is_doubt(note); });
  double kept = 0;
  std::mt19937_64 random(item_seed(options.seed, number));
  const auto furnish = [&](const Clip& motion, const std::string& id) {
    interruption_point();
    const std::optional<FittedRoom> fitted =
        fit_room(motion, builtin_body(), random, options.chords,
                 options.decoys && !train ? Furnishing::decoys : Furnishing::around, options.passages);
    if (!fitted || (train && options.only_on_chords && fitted->on_chords == 0)) return false;
    DatasetClip& entry =
        clips.emplace_back(DatasetClip{"clips/" + id + ".npz", "scenes/" + id + ".glb", recording.split, 0, name});
    write_scene(out, entry.scene, fitted->room.scene());
    write_clip(out, entry, fitted->clip);
    return true;
  };
  const std::vector<Clip> pieces = prepare_recording(source, recording.file, options.seconds);
  for (size_t p = 0; p < pieces.size(); ++p) {
    bool any = false;
    for (int r = 0; r < options.rooms_per_clip; ++r) {
      const std::string id = std::to_string(number) + "_" + std::to_string(p) + "_" + std::to_string(r);
      const Clip motion = train && options.mirrored && r % 2 == 1 ? mirrored(pieces[p]) : pieces[p];
      std::vector<Clip> parts;
      if (train && chance(random, options.stretches)) parts = stretches_of(motion, random);
      if (parts.empty()) any |= furnish(motion, id);
      for (size_t k = 0; k < parts.size(); ++k) any |= furnish(parts[k], id + "_" + std::to_string(k));
    }
    if (any) kept += pieces[p].seconds();
  }
  std::string skipped;
  if (clips.empty()) {
    skipped = recording.file + ": makes no clip: ";
    if (notes.empty())
      skipped +=
          pieces.empty() ? "no 2 s of it are on a flat floor and without leaps" : "no room could be fitted around it";
    skipped += fmt::format("{}", fmt::join(notes, "; "));
    notes.clear();
  }
  Notes doubts;
  add_notes(doubts, std::move(notes), recording.file);
  return {{"seconds", source.seconds()}, {"kept", kept}, {"skipped", skipped}, {"doubts", doubts}};
}

void remove_clips(const Dataset& dataset, const std::vector<DatasetClip>& clips) {
  for (const DatasetClip& clip : clips)
    for (const std::string& file : {clip.file, clip.scene})
      std::filesystem::remove(std::filesystem::path(dataset.folder) / file);
}

/// The folders of a data set that will not be, where nothing is in them.
void remove_folders(const Dataset& dataset) {
  std::error_code filled;
  for (const char* sub : {"clips", "scenes", ""})
    std::filesystem::remove(std::filesystem::path(dataset.folder) / sub, filled);
}

/// All that rooms depend on.
nlohmann::json job_of(const FittingOptions& o, const std::vector<Recording>& recordings) {
  nlohmann::json files = nlohmann::json::array();
  for (const Recording& r : recordings) files.push_back({r.file, r.split});
  const ClipReadOptions& reading = o.reading;
  nlohmann::json job = {
      {"recordings", files},
      {"seed", o.seed},
      {"rooms_per_clip", o.rooms_per_clip},
      {"seconds", o.seconds},
      {"mirrored", o.mirrored},
      {"stretches", o.stretches},
      {"only_on_chords", o.only_on_chords},
      {"decoys", o.decoys},
      {"chords", {o.chords.tried, o.chords.shortest, o.chords.longest}},
      {"reading", {static_cast<int>(reading.up), reading.scale, reading.rate, reading.level, reading.asf}}};
  if (o.passages > 0) job["passages"] = o.passages;
  return job;
}

}  // namespace

std::vector<Clip> prepare_recording(const Clip& source, const std::string& subject, double seconds, double extent) {
  Clip clip = retarget(source, subject);
  if (std::abs(clip.rate - kSynthRate) > 1e-6) clip = resample(clip, kSynthRate);
  if (clip.frames() < 2) throw Error(subject, "is one pose, no motion");
  clip = transformed(clip, {0, {0, -floor_under(clip), 0}});
  std::vector<Clip> out;
  const int64_t longest = std::max<int64_t>(2, std::llround(seconds * kSynthRate)),
                least = std::llround(2 * kSynthRate);
  // Even pieces, and shorter ones where the person goes far.
  std::function<void(int64_t, int64_t)> cut = [&](int64_t first, int64_t last) {
    const torch::Tensor path = clip.joints.slice(0, first, last).select(1, 0);
    const double far =
        std::get<0>((std::get<0>(path.max(0)) - std::get<0>(path.min(0))).index_select(0, torch::tensor({0, 2})).max(0))
            .item<double>();
    if (last - first < least) return;
    if (last - first > longest || far > extent) {
      const int64_t parts = last - first > longest ? (last - first + longest - 1) / longest : 2;
      for (int64_t i = 0; i < parts; ++i)
        cut(first + (last - first) * i / parts, first + (last - first) * (i + 1) / parts);
      return;
    }
    out.push_back(slice(clip, first, last));
  };
  const torch::Tensor good = on_floor(clip) & ~broken(clip);
  for (int64_t t = 0, first = 0; t <= clip.frames(); ++t) {
    if (t < clip.frames() && good[t].item<bool>()) continue;
    if (t > first) cut(first, t);
    first = t + 1;
  }
  return out;
}

void add_recordings(FittingOptions& options, const std::vector<std::string>& named) {
  for (const std::string& file : motion_files(named)) {
    bool test = false;
    for (const auto& part : std::filesystem::path(file).parent_path()) test |= part == "test";
    (test ? options.test : options.train).push_back(file);
  }
  for (auto* kept : {&options.val, &options.test}) *kept = motion_files(*kept);
}

Dataset fit_recordings(const std::string& folder, const FittingOptions& options) {
  if (options.train.empty() && options.val.empty() && options.test.empty())
    throw Error("no recordings to fit rooms around");
  if (options.rooms_per_clip < 1) throw Error("the number of rooms per clip must be at least 1");
  if (!(options.seconds >= 2 && options.seconds <= 600)) throw Error("the length of a piece must be 2 to 600 seconds");
  if (!(options.stretches >= 0 && options.stretches <= 1))
    throw Error("the fraction of stretches", "is not from 0 to 1");
  check_chords(options.chords);
  check_passages(options.passages);
  const std::vector<Recording> recordings = split_recordings(options);
  Dataset out = create_dataset(folder, fitted_actions(), options.shard);
  std::vector<int64_t> mine;
  for (int64_t i = 0; i < static_cast<int64_t>(recordings.size()); ++i)
    if (options.shard.has(i)) mine.push_back(i);
  DatasetItems made;
  try {
    made = make_items(out, job_of(options, recordings), mine, options.progress, [&](int64_t i) {
      DatasetItem item;
      try {
        item.facts =
            furnish_recording(out, recordings[static_cast<size_t>(i)], static_cast<size_t>(i), options, item.clips);
      } catch (const Error& e) {
        remove_clips(out, item.clips);  // nothing half-written
        if (recordings.size() == 1) throw;
        item.clips.clear();
        item.facts = {{"seconds", 0}, {"kept", 0}, {"skipped", e.what()}, {"doubts", nlohmann::json::array()}};
      }
      return item;
    });
  } catch (const Error&) {
    remove_folders(out);
    throw;
  }
  double seconds = 0, kept = 0;
  nlohmann::json sources = nlohmann::json::array(), skipped = sources, doubts = sources;
  for (const auto& [i, item] : made) {
    seconds += item.facts.at("seconds").get<double>(), kept += item.facts.at("kept").get<double>();
    for (const nlohmann::json& doubt : item.facts.value("doubts", nlohmann::json::array())) doubts.push_back(doubt);
    if (!item.facts.at("skipped").get<std::string>().empty()) {
      skipped.push_back(item.facts.at("skipped"));
      continue;
    }
    sources.push_back(std::filesystem::path(recordings[static_cast<size_t>(i)].file).filename().string());
  }
  if (out.whole && out.clips.empty()) {
    remove_folders(out);
    const auto first = skipped.front().get<std::string>();
    throw recordings.size() == 1 ? Error(first) : Error("no recording can be used; of the first: " + first);
  }
  out.provenance = {{"command", "inhabit synth fit"},
                    {"seed", options.seed},
                    {"rooms_per_clip", options.rooms_per_clip},
                    {"seconds", options.seconds},
                    {"mirrored", options.mirrored},
                    {"on_chord", options.chords.tried},
                    {"decoys", options.decoys},
                    {"recorded_minutes", seconds / 60},
                    {"furnished_minutes", kept / 60},
                    {"recordings", sources}};
  if (options.passages > 0) out.provenance["passages"] = options.passages;
  if (!skipped.empty()) out.provenance["skipped"] = skipped;
  if (!doubts.empty()) out.provenance["doubts"] = doubts;
  finish_items(out);
  return out;
}

}  // namespace inhabit
