#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/intention_summary.h"
#include "inhabit/anticipate/released_labels.h"
#include "inhabit/data/motion_set.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npz.h"
#include "inhabit/view/page.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

using namespace inhabit;

constexpr double kLongestShown = 10;  // seconds of a label's motion

struct IntentionsArguments {
  std::string data, out = "intentions.html", json, compare;
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

/// How far labels agree with those of an .npz: an array for each recording, "train/walking/walking_1", 120 labels a
/// second. The frames of all recordings that both have count as one labelling.
void compare_labels(const std::string& path, const std::vector<ActionMotion>& motions,
                    const std::vector<torch::Tensor>& tracks, double rate) {
  constexpr double kTheirRate = 120;
  const Npz theirs = read_npz(path);
  std::vector<torch::Tensor> ours, other, actions;
  std::map<std::string, int64_t> numbers;
  int64_t recordings = 0;
  for (size_t i = 0; i < motions.size(); ++i) {
    const ActionMotion& motion = motions[i];
    const std::string key =
        std::string(motion.split == "test" ? "test/" : "train/") + motion.action + "/" + motion.name;
    const auto found = theirs.tensors.find(key);
    if (found == theirs.tensors.end()) continue;
    const torch::Tensor rows = (torch::arange(tracks[i].size(0)) * (kTheirRate / rate)).round().to(torch::kInt64);
    const torch::Tensor both = rows.index({rows < found->second.size(0)});
    other.push_back(found->second.to(torch::kInt64).index_select(0, both));
    ours.push_back(tracks[i].slice(0, 0, both.size(0)));
    actions.push_back(
        torch::full({both.size(0)}, numbers.emplace(motion.action, numbers.size()).first->second, torch::kInt64));
    ++recordings;
  }
  if (recordings == 0) throw Error(path, "has labels of none of the recordings");
  const torch::Tensor a = torch::cat(ours), b = torch::cat(other), c = torch::cat(actions);
  std::printf(
      "normalised mutual information with %s: %.3f (%lld recordings, %lld frames); of the actions' names with it %.3f, "
      "with ours %.3f\n",
      path.c_str(), anticipate::normalised_mutual_information(a, b), static_cast<long long>(recordings),
      static_cast<long long>(a.size(0)), anticipate::normalised_mutual_information(c, b),
      anticipate::normalised_mutual_information(c, a));
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
  verb->add_option("--compare", o->compare,
                   "Labels of the same recordings by others, .npz, 120 a second: prints how far they agree");
  verb->add_option("--json", o->json, "Also write the table as JSON");
  verb->callback([o] {
    anticipate::Config config;
    set_fields(config, o->settings);
    if (o->labels > 0) config.labels = o->labels;
    validate(config, "configuration");
    require_writable(o->out);
    if (!o->json.empty()) require_writable(o->json);
    Notes notes;
    const auto motions = read_motion_set(o->data, config.rate, &notes, progress_of("recordings"));
    const Skeleton skeleton = anticipate::training_skeleton(motions, o->data);
    auto recordings = anticipate::sequences_of(motions, "train", skeleton, config.rate);
    const anticipate::IntentionClusters clusters = anticipate::cluster_recordings(recordings, config, o->seed);
    for (const char* split : {"val", "test"})
      for (anticipate::Sequence& recording : anticipate::sequences_of(motions, split, skeleton, config.rate)) {
        recording.name += std::string(" (") + split + ")";
        recordings.push_back(std::move(recording));
      }
    const anticipate::IntentionSummary summary = anticipate::summarise_intentions(recordings, clusters, config.rate);
    Page page = summary_page(summary, recordings, skeleton, config.rate);
    page.title = "Intentions of " + std::filesystem::path(o->data + "/").parent_path().filename().string();
    write_page(o->out, page);
    if (!o->json.empty()) write_atomically(o->json, anticipate::summary_json(summary, recordings).dump(1) + "\n");
    say(notes);
    if (!o->compare.empty()) {
      std::vector<ActionMotion> whole;
      std::vector<torch::Tensor> tracks;
      for (const char* split : {"train", "val", "test"})
        for (const ActionMotion& motion : motions)
          if (motion.split == split && motion.clip.frames() > 1) {
            whole.push_back(motion);
            tracks.push_back(summary.tracks[tracks.size()]);
          }
      compare_labels(o->compare, whole, tracks, config.rate);
    }
    std::printf("%s%s\n", anticipate::summary_text(summary).c_str(), o->out.c_str());
  });
}
