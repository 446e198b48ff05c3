#include "inhabit/anticipate/intention_page.h"

#include <algorithm>
#include <utility>

#include "inhabit/anticipate/features.h"

namespace inhabit::anticipate {
namespace {

constexpr double kLongestShown = 10;  // seconds of a label's motion

Clip shown_motion(const Sequence& recording, const LabelSummary& label, const Skeleton& skeleton, double rate) {
  const int64_t last = std::min(label.last, label.first + static_cast<int64_t>(kLongestShown * rate));
  Clip clip;
  clip.skeleton = skeleton;
  clip.rate = rate;
  clip.joints =
      feature_joints(recording.features.slice(0, label.first, last), torch::zeros({3}), torch::zeros({})).contiguous();
  return clip;
}

}  // namespace

Page intention_page(const IntentionSummary& summary, const std::vector<Sequence>& recordings, const Skeleton& skeleton,
                    double rate, const std::string& title) {
  Page page;
  page.title = title;
  page.note =
      "One motion for each label above, the labels of every recording below, outlined where the motion is from.";
  page.recordings.emplace();
  page.recordings->rate = rate;
  for (size_t i = 0; i < recordings.size(); ++i)
    page.recordings->rows.push_back({shown_name(recordings[i]), recordings[i].action, summary.tracks[i], {}});
  for (size_t c = 0; c < summary.labels.size(); ++c) {
    const LabelSummary& label = summary.labels[c];
    if (label.segments == 0) continue;
    PagePerson person;
    person.clip = shown_motion(recordings[label.recording], label, skeleton, rate);
    person.name = std::to_string(c) + " · " + label.actions.front().first;
    person.role = PagePerson::Role::intention;
    person.labels = torch::full({person.clip.frames()}, static_cast<int64_t>(c), torch::kInt64);
    page.people.push_back(std::move(person));
    page.recordings->rows[label.recording].marked.emplace_back(label.first, label.last);
  }
  return page;
}

}  // namespace inhabit::anticipate
