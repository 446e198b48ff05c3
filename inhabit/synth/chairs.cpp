#include "inhabit/synth/chairs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "inhabit/data/dataset_items.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/person.h"
#include "inhabit/synth/seat.h"

namespace inhabit {
namespace {

// Minutes of the COUCH data set by interaction_names() (Table 4).
constexpr std::array<double, 6> kMinutes = {36.3, 29.4, 60.5, 36.5, 31.9, 15.1};

/// A clip to be made.
struct ChairJob {
  ChairTake take;
  int64_t chair = 0;
};

// Seeds of different kinds of draws.
enum Stream : uint64_t { kSubjects = 1, kSchedule = 2, kChairs = 1000, kClips = 1000000 };

/// The place of `name` among `names`. Throws Error(name, ...) where it is none of them. @param unless said then, such
/// as "is no kind of chair"
size_t place_among(const std::vector<std::string>& names, const std::string& name, const std::string& unless) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw Error(name, fmt::format("{}; there are {}", unless, fmt::join(names, ", ")));
  return static_cast<size_t>(found - names.begin());
}

template <class T>
void shuffle(std::vector<T>& items, std::mt19937_64& random) {
  for (size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random() % i]);
}

/// Takes until `minutes` are full, the type that lacks most next; then in random order on chair after chair.
std::vector<ChairJob> schedule(const ChairsOptions& options) {
  std::mt19937_64 random(item_seed(options.seed, kSchedule));
  double all = 0;
  for (const double m : kMinutes) all += m;
  std::array<double, kMinutes.size()> lacks{};
  for (size_t i = 0; i < kMinutes.size(); ++i) lacks[i] = 60 * options.minutes * kMinutes[i] / all;
  std::vector<SeatPart> parts;
  for (const std::string& part : options.parts)
    parts.push_back(static_cast<SeatPart>(place_among(seat_part_names(), part, "is no part of a seat")));
  std::vector<ChairJob> jobs;
  // Directions fill the circle evenly.
  double left = 60 * options.minutes, around = uniform(random, 0, 1);
  while (left > 0.5) {
    const auto type = static_cast<size_t>(std::max_element(lacks.begin(), lacks.end()) - lacks.begin());
    ChairJob job;
    job.take.interaction = static_cast<Interaction>(type);
    around = std::fmod(around + 0.6180339887498949, 1.0);
    job.take.direction = 2 * M_PI * around - M_PI;
    job.take.distance = uniform(random, 1.0, 5.0);
    const double walk = job.take.distance / 1.1 + 0.6 * std::abs(job.take.direction);
    const double stay = job.take.interaction == Interaction::free ? uniform(random, 7, 13) : uniform(random, 4, 11);
    job.take.seconds = std::clamp(6.5 + walk + stay, 12.0, 24.0);
    if (job.take.interaction == Interaction::locomotion) job.take.seconds = uniform(random, 12, 20);
    if (options.linger > 0) {
      const double least = std::min(1.0, options.linger);
      if (chance(random, 0.5)) job.take.before = uniform(random, least, options.linger);
      if (chance(random, 0.5)) job.take.after = uniform(random, least, options.linger);
      job.take.seconds += job.take.before + job.take.after;
    }
    job.take.parts = parts;
    job.take.seconds = std::round(job.take.seconds * kSynthRate) / kSynthRate;
    lacks[type] -= job.take.seconds;
    left -= job.take.seconds;
    jobs.push_back(job);
  }
  shuffle(jobs, random);
  const auto chairs = std::min(options.chairs, static_cast<int64_t>(jobs.size()));
  for (size_t i = 0; i < jobs.size(); ++i) jobs[i].chair = static_cast<int64_t>(i) % chairs;
  return jobs;
}

bool can_sit(const Room& room, const ChairSubject& subject) {
  const std::vector<Seat> seats = seats_of(room, *subject.figure);
  return std::any_of(seats.begin(), seats.end(), [](const Seat& seat) { return seat.furniture == 0; });
}

Room room_of_chair(const ChairsOptions& options, int64_t chair) {
  std::mt19937_64 random(item_seed(options.seed, kChairs + static_cast<uint64_t>(chair)));
  return make_chair_room(random, options.kinds);
}

/// The subject whose turn it is, or the next whose legs fit the chair.
int choose_subject(const std::vector<ChairSubject>& subjects, int64_t index, const Room& room) {
  const auto count = static_cast<int64_t>(subjects.size());
  for (int64_t k = 0; k < count; ++k) {
    const int64_t s = (index + index / count + k) % count;
    if (can_sit(room, subjects[static_cast<size_t>(s)])) return static_cast<int>(s);
  }
  throw Error("no subject's legs are of the length for a seat");
}

std::string clip_name(int64_t index) { return numbered("clips/", index, ".npz"); }

std::string scene_name(int64_t chair) { return numbered("scenes/chair_", chair, ".glb"); }

/// Makes one clip. A take that cannot be (no place for both hands, the start behind furniture) is changed: the start
/// first, then the chair for another of the same split.
DatasetClip make_clip(const Dataset& out, const std::vector<ChairSubject>& subjects, const ChairsOptions& options,
                      const ChairJob& job, int64_t index, int64_t chairs) {
  constexpr int kChairTries = 24, kStartTries = 5;
  std::mt19937_64 random(item_seed(options.seed, kClips + static_cast<uint64_t>(index)));
  int64_t chair = job.chair;
  for (int tried = 0; tried < kChairTries; ++tried) {
    const Room room = room_of_chair(options, chair);
    if (index == job.chair && tried == 0) write_scene(out, scene_name(chair), room.scene());
    const FreeSpace floor = free_space(room);
    const ChairSource source{choose_subject(subjects, index, room), job.take.interaction, chair};
    const ChairSubject& subject = subjects[static_cast<size_t>(source.subject)];
    ChairTake take = job.take;
    for (int attempt = 0; attempt < kStartTries; ++attempt) {
      const auto clip = sit_on_chair(room, floor, builtin_body(), subject, take, random);
      if (clip) {
        DatasetClip entry{clip_name(index), scene_name(chair), split_of_chair(chair), 0, source_text(source)};
        write_clip(out, entry, *clip);
        return entry;
      }
      take.direction += uniform(random, -0.5, 0.5);
      take.distance = std::clamp(take.distance + uniform(random, -0.8, 0.4), 1.0, 5.0);
    }
    do chair = (chair + 1) % chairs;
    while (split_of_chair(chair) != split_of_chair(job.chair));
  }
  throw Error(clip_name(index), "no life without a fault on any of " + std::to_string(kChairTries) + " chairs");
}

nlohmann::json provenance_of(const ChairsOptions& options, const std::vector<ChairSubject>& subjects) {
  nlohmann::json people = nlohmann::json::array();
  for (const ChairSubject& subject : subjects) {
    const torch::Tensor betas = subject.betas.contiguous();
    people.push_back({{"betas", std::vector<float>(betas.data_ptr<float>(), betas.data_ptr<float>() + betas.numel())},
                      {"speed", subject.gait.speed},
                      {"pace", subject.manner.pace}});
  }
  return {{"command", "inhabit synth chairs"},
          {"seed", options.seed},
          {"minutes", options.minutes},
          {"chairs", options.chairs},
          {"linger", options.linger},
          {"kinds", options.kinds.empty() ? chair_kinds() : options.kinds},
          {"parts", options.parts},
          {"subjects", people},
          {"interactions", interaction_names()},
          {"source", "subject_N/INTERACTION/chair_NNNNNN"},
          {"licence", "generated; free of any rights"}};
}

}  // namespace

std::string split_of_chair(int64_t index) {
  const int64_t place = index % 12;
  return place == 3 || place == 9 ? "test" : place == 6 ? "val" : "train";
}

std::string source_text(const ChairSource& source) {
  return "subject_" + std::to_string(source.subject) + "/" +
         interaction_names()[static_cast<size_t>(source.interaction)] + numbered("/chair_", source.chair, "");
}

ChairSource parse_chair_source(const std::string& text) {
  const size_t first = text.find('/'), second = text.find('/', first + 1);
  const auto number = [&](size_t from, size_t to, const std::string& word) {
    const std::string part = text.substr(from, to - from);
    const std::string digits = part.substr(0, word.size()) == word ? part.substr(word.size()) : "";
    if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
      throw Error(text, "is no source of a chairs data set (subject_N/INTERACTION/chair_N)");
    return std::stoll(digits);
  };
  if (first == std::string::npos || second == std::string::npos)
    throw Error(text, "is no source of a chairs data set (subject_N/INTERACTION/chair_N)");
  ChairSource source;
  source.subject = static_cast<int>(number(0, first, "subject_"));
  source.chair = number(second + 1, text.size(), "chair_");
  const auto& names = interaction_names();
  const auto found = std::find(names.begin(), names.end(), text.substr(first + 1, second - first - 1));
  if (found == names.end()) throw Error(text, "has an unknown interaction type");
  source.interaction = static_cast<Interaction>(found - names.begin());
  return source;
}

Dataset generate_chairs(const std::string& folder, const ChairsOptions& options) {
  if (!(options.minutes > 0 && options.minutes <= 6000)) throw Error("the minutes must be over 0 and at most 6000");
  if (options.subjects < 1 || options.subjects > 1000) throw Error("the number of subjects must be 1 to 1000");
  if (options.chairs < 1 || options.chairs > 100000) throw Error("the number of chairs must be 1 to 100000");
  if (!(options.linger >= 0 && options.linger <= 60)) throw Error("linger must be 0 to 60 seconds");
  for (const std::string& kind : options.kinds) place_among(chair_kinds(), kind, "is no kind of chair");
  std::vector<ChairSubject> subjects;
  subjects.reserve(static_cast<size_t>(options.subjects));
  std::mt19937_64 random(item_seed(options.seed, kSubjects));
  for (int i = 0; i < options.subjects; ++i) subjects.push_back(draw_subject(builtin_body(), random));
  const std::vector<ChairJob> jobs = schedule(options);
  Dataset out = create_dataset(folder, action_names(), options.shard);
  out.provenance = provenance_of(options, subjects);
  const auto chairs = std::min(options.chairs, static_cast<int64_t>(jobs.size()));
  std::vector<int64_t> mine;
  for (int64_t i = 0; i < static_cast<int64_t>(jobs.size()); ++i)
    if (options.shard.has(i)) mine.push_back(i);
  make_items(out, out.provenance, mine, options.progress, [&](int64_t i) {
    return DatasetItem{{make_clip(out, subjects, options, jobs[static_cast<size_t>(i)], i, chairs)}, {}};
  });
  finish_items(out);
  return out;
}

}  // namespace inhabit
