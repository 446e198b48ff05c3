#include <cstdio>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "progress.h"
#include "score.h"

using namespace inhabit;

std::vector<ScoredClip> score_clips(Score& given, const std::string& file, const ClipReadOptions& reading, double rate,
                                    int64_t least) {
  std::vector<ScoredClip> out;
  Notes own;
  for (const Clip& clip : read_clips(file, reading, &own)) out.push_back(scored_clip(clip, rate, least, file));
  add_notes(given.notes, std::move(own), file);
  return out;
}

std::vector<ScoredClip> score_clips(Score& given, const std::vector<std::string>& named, const ClipReadOptions& reading,
                                    double rate, int64_t least) {
  std::vector<ScoredClip> out;
  const FileCount count = each_file(
      motion_files(named),
      [&](const std::string& file) {
        for (ScoredClip& clip : score_clips(given, file, reading, rate, least)) out.push_back(std::move(clip));
      },
      progress_of("files"));
  given.files.done += count.done;
  given.files.skipped.insert(given.files.skipped.end(), count.skipped.begin(), count.skipped.end());
  return out;
}

void report_scores(const Score& given, nlohmann::ordered_json facts) {
  if (!given.files.skipped.empty()) facts["skipped"] = given.files.skipped;
  if (!given.json.empty()) write_atomically(given.json, facts.dump(1) + "\n");
  say(given.notes, 8);
  for (const auto& [key, value] : facts.items())
    if (!value.is_array()) std::printf("%s: %s\n", key.c_str(), value.dump().c_str());
}
