#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/intention_summary.h"
#include "inhabit/data/motion_set.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/view/page.h"
#include "inputs.h"
#include "outputs.h"
#include "verbs.h"

namespace {

using namespace inhabit;

constexpr double kLongestShown = 10;  // seconds of a label's motion

struct IntentionsArguments {
  std::string data, out = "intentions.html", json;
  std::vector<std::string> settings;
  int labels = 0;
  uint64_t seed = 1;
};

Clip motion_of(const anticipate::Sequence& recording, const anticipate::LabelSummary& label, const Skeleton& skeleton,
               double rate) {
  const int64_t last = std::min(label.last, label.first + static_cast<int64_t>(kLongestShown * rate));
  Clip clip;
  clip.skeleton = skeleton;
  clip.rate = rate;
  clip.joints =
      anticipate::feature_joints(recording.features.slice(0, label.first, last), torch::zeros({3}), torch::zeros({}))
          .contiguous();
  return clip;
}

Page summary_page(const anticipate::IntentionSummary& summary, const std::vector<anticipate::Sequence>& recordings,
                  const Skeleton& skeleton, double rate) {
  Page page;
  page.note =
      "One motion for each label above, the labels of every recording below, outlined where the motion is from.";
  page.recordings.emplace();
  page.recordings->rate = rate;
  for (size_t i = 0; i < recordings.size(); ++i)
    page.recordings->rows.push_back({recordings[i].name, recordings[i].action, summary.tracks[i], {}});
  for (size_t c = 0; c < summary.labels.size(); ++c) {
    const anticipate::LabelSummary& label = summary.labels[c];
    if (label.segments == 0) continue;
    PagePerson person;
    person.clip = motion_of(recordings[label.recording], label, skeleton, rate);
    person.name = std::to_string(c) + " · " + label.actions.front().first;
    person.role = PagePerson::Role::intention;
    person.labels = torch::full({person.clip.frames()}, static_cast<int64_t>(c), torch::kInt64);
    page.people.push_back(std::move(person));
    page.recordings->rows[label.recording].marked.push_back({label.first, label.last});
  }
  return page;
}

}  // namespace

void add_intentions(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("intentions", "Cluster the intention labels of recordings and show them");
  auto o = std::make_shared<IntentionsArguments>();
  verb->add_option("data", o->data, "cmu:FOLDER, h36m:FOLDER or a native data set folder")->required();
  verb->add_option("-o,--out", o->out, "The page")->capture_default_str();
  verb->add_option("--labels", o->labels, "Labels (default: as configured, 8)")->check(whole_over_zero);
  verb->add_option("--set", o->settings, "Settings of the configuration, KEY=VALUE, such as naive_clusters=true");
  verb->add_option("--seed", o->seed, "Seed of the clusters")->check(whole_number)->capture_default_str();
  verb->add_option("--json", o->json, "Also write the table as JSON");
  verb->callback([o] {
    anticipate::Config config;
    set_fields(config, o->settings);
    if (o->labels > 0) config.labels = o->labels;
    validate(config, "configuration");
    require_writable(o->out);
    if (!o->json.empty()) require_writable(o->json);
    Notes notes;
    const auto motions = read_motion_set(o->data, config.rate, &notes);
    const Skeleton skeleton = anticipate::training_skeleton(motions, o->data);
    auto recordings = anticipate::sequences_of(motions, "train", skeleton);
    const anticipate::IntentionClusters clusters = anticipate::cluster_recordings(recordings, config, o->seed);
    for (const char* split : {"val", "test"})
      for (anticipate::Sequence& recording : anticipate::sequences_of(motions, split, skeleton)) {
        recording.name += std::string(" (") + split + ")";
        recordings.push_back(std::move(recording));
      }
    const anticipate::IntentionSummary summary = anticipate::summarise_intentions(recordings, clusters, config.rate);
    Page page = summary_page(summary, recordings, skeleton, config.rate);
    page.title = "Intentions of " + std::filesystem::path(o->data + "/").parent_path().filename().string();
    write_page(o->out, page);
    if (!o->json.empty()) write_atomically(o->json, anticipate::summary_json(summary, recordings).dump(1) + "\n");
    say(notes);
    std::printf("%s%s\n", anticipate::summary_text(summary).c_str(), o->out.c_str());
  });
}
