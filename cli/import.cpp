#include <cstdio>
#include <map>
#include <set>

#include "inhabit/data/import_dataset.h"
#include "inhabit/error.h"
#include "inhabit/io/smpl_model.h"
#include "inputs.h"
#include "interrupted.h"
#include "progress.h"
#include "verbs.h"

namespace {

void list(const inhabit::ImportSet& set) {
  std::set<std::string> people, scenes;
  std::map<std::string, int64_t> splits;
  for (const auto& recording : set.recordings) {
    if (!recording.person.empty()) people.insert(recording.person);
    if (!recording.scene.empty()) scenes.insert(recording.scene);
    ++splits[recording.split];
  }
  std::printf("%s: %zu recordings", set.folder.c_str(), set.recordings.size());
  if (!people.empty()) std::printf(" of %zu people", people.size());
  if (!scenes.empty()) std::printf(" in %zu scenes", scenes.size());
  std::printf("; train %lld, val %lld, test %lld (%s)\n", static_cast<long long>(splits["train"]),
              static_cast<long long>(splits["val"]), static_cast<long long>(splits["test"]), set.splits.c_str());
  for (const auto& recording : set.recordings)
    std::printf("%s %s%s%s\n", recording.split.c_str(), recording.name.c_str(), recording.scene.empty() ? "" : " in ",
                recording.scene.c_str());
  for (const std::string& missing : set.missing) std::printf("missing: %s\n", missing.c_str());
  for (const std::string& broken : set.broken) std::printf("broken: %s\n", broken.c_str());
}

}  // namespace

void add_import(CLI::App& app) {
  struct Given {
    std::string format, folder, out, body, shard;
    bool only_list = false;
    inhabit::ImportOptions options;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = app.add_subcommand("import", "Make a data set of one that its owners hand out");
  verb->add_option("format", given->format, "What it is")->required()->check(CLI::IsMember(inhabit::import_formats()));
  verb->add_option("folder", given->folder, "Folder of the data set as it came (docs/data.md)")->required();
  CLI::Option* out = verb->add_option("--out", given->out, "Folder of the data set that is made");
  verb->add_flag("--list", given->only_list, "Only say what is there and what is missing")->excludes(out);
  verb->add_option("--jobs", given->options.jobs, "Recordings at once (default: as many as there are cores)")
      ->check(whole_over_zero);
  verb->add_option("--body", given->body,
                   "Body model of the recordings (SMPL, SMPL-H or SMPL-X .npz), for their own bone lengths");
  add_shard(*verb, given->shard);
  verb->callback([given] {
    given->options.shard = shard_of(given->shard);
    if (!given->only_list && given->out.empty()) throw inhabit::Error("--out", "is needed, or --list");
    inhabit::BodyModel body;
    if (!given->body.empty()) body = inhabit::read_smpl_model(given->body);
    const auto set = inhabit::open_import_set(given->format, given->folder, given->body.empty() ? nullptr : &body);
    if (given->only_list) return list(set);
    given->options.progress = progress_of("recordings");
    const GoesOnLater later("recordings that are imported are kept, and the same command imports the rest");
    const auto made = inhabit::import_dataset(set, given->out, given->options);
    end_progress();
    std::printf("%s\n", summary(made.dataset).c_str());
    if (made.kept > 0) std::printf("%lld of them were there already\n", static_cast<long long>(made.kept));
    std::printf("splits: %s\n", set.splits.c_str());
    inhabit::Notes missing;
    for (const std::string& what : set.missing) missing.push_back("missing: " + what);
    say(missing, 8);
    end_of({made.made + made.kept, made.skipped});
  });
}
