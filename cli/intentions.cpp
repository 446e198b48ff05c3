#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "inhabit/anticipate/clustered_set.h"
#include "inhabit/anticipate/label_agreement.h"
#include "inhabit/io/atomic_file.h"
#include "inputs.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

using namespace inhabit;

struct IntentionsArguments {
  std::string data, out = "intentions.html", json, compare;
  std::vector<std::string> settings;
  int labels = 0;
  uint64_t seed = 1;
};

/// Says how far labels agree with those of an .npz file.
void say_agreement(const std::string& path, const anticipate::LabelAgreement& agreement) {
  std::printf(
      "normalised mutual information with %s: %.3f (%lld recordings, %lld frames); of the actions' names with it %.3f, "
      "with ours %.3f\n",
      path.c_str(), agreement.labels, static_cast<long long>(agreement.recordings),
      static_cast<long long>(agreement.frames), agreement.actions_and_other, agreement.actions_and_ours);
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
    const auto set = anticipate::clustered_set(o->data, config, o->seed, &notes, progress_of("recordings"));
    write_page(o->out, intention_page(set));
    if (!o->json.empty()) write_atomically(o->json, summary_json(set.summary, set.recordings).dump(1) + "\n");
    say(notes);
    if (!o->compare.empty())
      say_agreement(o->compare, anticipate::label_agreement(o->compare, set.recordings, set.summary.tracks, set.rate));
    std::printf("%s%s\n", summary_text(set.summary).c_str(), o->out.c_str());
  });
}
