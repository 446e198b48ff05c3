#include "inhabit/synth/generate.h"

#include "inhabit/body/body_model.h"
#include "inhabit/data/dataset_items.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/layout.h"
#include "inhabit/synth/life_plan.h"
#include "inhabit/synth/passages.h"
#include "inhabit/synth/person.h"
#include "inhabit/synth/room.h"

namespace inhabit {

std::string numbered(const std::string& prefix, int64_t number, const std::string& extension) {
  const std::string digits = std::to_string(number);
  return prefix + std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + extension;
}

std::string split_of_room(int64_t index, int64_t rooms) {
  if (rooms < 3) return "train";
  const int64_t last = rooms < 10 ? rooms - 1 - index : 9 - index % 10;
  return last == 0 ? "test" : last == 1 ? "val" : "train";
}

namespace {

constexpr uint64_t kChordStream = 0x63686f7264;  // of seeds, so that lives are the same without these pieces

/// The room with pieces added for one life: beside its walks and on its chords. The room as it was where none fits.
Room with_pieces_in_the_way(const Room& room, const Clip& life, const GenerateOptions& options, uint64_t seed) {
  Room out = room;
  const BodySweep sweep(life, builtin_body());
  Layout layout(out, {});
  layout.require([](const Furniture&) { return true; });  // nobody needs to reach seats any more
  std::mt19937_64 random(seed);
  add_passages(layout, life, sweep, options.passages, random);
  add_on_chords(layout, life, builtin_body(), sweep, options.chords, random);
  return out;
}

}  // namespace

Dataset generate_rooms(const std::string& folder, const GenerateOptions& options) {
  if (options.clips < 1) throw Error("the number of clips must be at least 1");
  if (options.clips_per_room < 1) throw Error("the number of clips per room must be at least 1");
  if (!(options.seconds >= 1 && options.seconds <= 600)) throw Error("the length of a clip must be 1 to 600 seconds");
  check_chords(options.chords);
  check_passages(options.passages);
  Dataset out = create_dataset(folder, action_names(), options.shard);
  out.provenance = {{"command", "inhabit synth rooms"}, {"seed", options.seed},
                    {"seconds", options.seconds},       {"clips_per_room", options.clips_per_room},
                    {"on_chord", options.chords.tried}, {"licence", "generated; free of any rights"}};
  if (options.passages > 0) out.provenance["passages"] = options.passages;
  const int64_t rooms = (options.clips + options.clips_per_room - 1) / options.clips_per_room;
  std::vector<int64_t> mine;
  for (int64_t i = 0; i < options.clips; ++i)
    if (options.shard.has(i / options.clips_per_room)) mine.push_back(i);
  const BodyModel& body = builtin_body();
  nlohmann::json job = out.provenance;
  job["clips"] = options.clips;
  job["chords"] = {options.chords.shortest, options.chords.longest};
  make_items(out, job, mine, options.progress, [&](int64_t i) {
    const int64_t number = i / options.clips_per_room;
    std::mt19937_64 room_random(item_seed(options.seed, 2 * static_cast<uint64_t>(number)));
    std::mt19937_64 random(item_seed(options.seed, 2 * static_cast<uint64_t>(i) + 1));
    const Room room = make_room(room_random);
    DatasetClip entry{numbered("clips/", i, ".npz"), numbered("scenes/room_", number, ".glb"),
                      split_of_room(number, rooms), 0, ""};
    if (i % options.clips_per_room == 0) write_scene(out, entry.scene, room.scene());
    const Clip life = live(room, body, random, {options.seconds});
    if (options.chords.tried > 0 || options.passages > 0) {
      const Room own =
          with_pieces_in_the_way(room, life, options, item_seed(options.seed ^ kChordStream, static_cast<uint64_t>(i)));
      if (own.furniture.size() > room.furniture.size()) {
        entry.scene = numbered("scenes/own_", i, ".glb");
        write_scene(out, entry.scene, own.scene());
      }
    }
    write_clip(out, entry, life);
    return DatasetItem{{entry}, {}};
  });
  finish_items(out);
  return out;
}

}  // namespace inhabit
