#include "inhabit/anticipate/intention_summary.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "inhabit/anticipate/released_labels.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

struct Segment {
  size_t recording;
  int64_t first, last;
  double distance;  // from the label's centre

  int64_t frames() const { return last - first; }
};

/// How far a segment of poses (T, D) is from the centre of its label.
double centre_distance(const Tensor& poses, const IntentionClusters& clusters, int64_t label) {
  if (clusters.codes.defined())
    return (clusters.encoder->encode(label_views(poses)) - clusters.codes[label]).norm(2, 1).mean().item<double>();
  if (!clusters.labels.defined()) return (poses - clusters.poses[label]).norm(2, 1).mean().item<double>();
  return (describe_segment(poses) - clusters.labels[label]).norm().item<double>();
}

/// The longest of the quarter that is nearest to the centre; of equals the nearest.
Segment representative(std::vector<Segment> segments) {
  std::stable_sort(segments.begin(), segments.end(), [](auto& a, auto& b) { return a.distance < b.distance; });
  segments.resize((segments.size() + 3) / 4);
  return *std::max_element(segments.begin(), segments.end(), [](auto& a, auto& b) { return a.frames() < b.frames(); });
}

}  // namespace

IntentionSummary summarise_intentions(const std::vector<Sequence>& recordings, const IntentionClusters& clusters,
                                      double rate) {
  IntentionSummary out;
  out.labels.resize(static_cast<size_t>(clusters.count()));
  std::vector<std::vector<Segment>> segments(out.labels.size());
  std::vector<std::map<std::string, int64_t>> actions(out.labels.size());
  int64_t frames = 0;
  for (size_t i = 0; i < recordings.size(); ++i) {
    const Tensor poses = intention_poses(recordings[i].features), track = intention_labels(poses, clusters);
    const int64_t *at = track.data_ptr<int64_t>(), count = track.size(0);
    for (int64_t first = 0, last = 0; first < count; first = last) {
      while (last < count && at[last] == at[first]) ++last;
      const auto label = static_cast<size_t>(at[first]);
      segments[label].push_back({i, first, last, centre_distance(poses.slice(0, first, last), clusters, at[first])});
      actions[label][recordings[i].action] += last - first;
    }
    frames += count;
    out.tracks.push_back(track);
  }
  for (size_t c = 0; c < out.labels.size(); ++c) {
    if (segments[c].empty()) continue;
    LabelSummary& label = out.labels[c];
    int64_t own = 0;
    for (const Segment& segment : segments[c]) own += segment.frames();
    label.fraction = static_cast<double>(own) / static_cast<double>(frames);
    label.segments = static_cast<int64_t>(segments[c].size());
    label.seconds = static_cast<double>(own) / rate / static_cast<double>(label.segments);
    for (const auto& [action, count] : actions[c])
      label.actions.emplace_back(action, static_cast<double>(count) / static_cast<double>(own));
    std::stable_sort(label.actions.begin(), label.actions.end(), [](auto& a, auto& b) { return a.second > b.second; });
    const Segment shown = representative(segments[c]);
    label.recording = shown.recording;
    label.first = shown.first;
    label.last = shown.last;
  }
  return out;
}

std::string summary_text(const IntentionSummary& summary) {
  std::string out = "label  frames  segments  seconds  actions\n";
  for (size_t c = 0; c < summary.labels.size(); ++c) {
    const LabelSummary& label = summary.labels[c];
    char row[64];
    std::snprintf(row, sizeof row, "%5zu  %5.1f%%  %8ld  %7.2f ", c, 100 * label.fraction,
                  static_cast<long>(label.segments), label.seconds);
    out += row;
    for (size_t a = 0; a < std::min<size_t>(3, label.actions.size()); ++a) {
      char fraction[16];
      std::snprintf(fraction, sizeof fraction, " %.0f%%", 100 * label.actions[a].second);
      out += (a > 0 ? ", " : " ") + label.actions[a].first + fraction;
    }
    out += "\n";
  }
  return out;
}

nlohmann::json summary_json(const IntentionSummary& summary, const std::vector<Sequence>& recordings) {
  nlohmann::json out = nlohmann::json::array();
  for (size_t c = 0; c < summary.labels.size(); ++c) {
    const LabelSummary& label = summary.labels[c];
    nlohmann::json row = {{"label", c},
                          {"fraction", label.fraction},
                          {"segments", label.segments},
                          {"seconds", label.seconds},
                          {"actions", nlohmann::json::array()}};
    for (const auto& [action, fraction] : label.actions)
      row["actions"].push_back({{"name", action}, {"fraction", fraction}});
    if (label.segments > 0)
      row["representative"] = {
          {"recording", shown_name(recordings[label.recording])}, {"first", label.first}, {"last", label.last}};
    out.push_back(row);
  }
  return {{"labels", out}};
}

}  // namespace inhabit::anticipate
