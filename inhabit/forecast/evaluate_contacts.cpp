#include "inhabit/forecast/evaluate_contacts.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/metrics/bootstrap.h"

namespace inhabit::forecast {
namespace {

using torch::Tensor;

constexpr double kBelowFloor = 0.01;  // fraction of a window's scene points that lie below its floor: things under it
constexpr double kOnFloor = 0.05;     // metres
constexpr int64_t kContactResamples = 1000;

/// A window, and contact points (1, T, J, 4) made of it.
struct Touching {
  Tensor points, dense;  // (1, N, 3)
  Tensor joints;         // (1, P+T, J, 3)
};
struct Source {
  std::string name;
  std::function<Tensor(const Touching&)> contacts;
};

std::vector<Source> sources_of(const Networks& model) {
  const Config& c = model.config;
  const auto past = [c](const Touching& w) { return w.joints.slice(1, 0, c.past).contiguous(); };
  std::vector<Source> out = {
      {fmt::format("true, N = {}", c.inference.points),
       [c](const Touching& w) { return true_contact_points(w.points, w.joints.slice(1, c.past), c); }},
      {fmt::format("true, N = {}, L = {}", c.inference.points, c.contact_coefficients),
       [c](const Touching& w) { return contact_points(w.points, contact_targets(w.points, w.joints, c), c); }},
      {"last map kept",
       [c, past](const Touching& w) { return contact_points(w.points, contact_features(w.points, past(w), c), c); }}};
  if (!model.contact.is_empty())
    out.push_back(
        {"predicted", [c, past, fast = std::make_shared<FastContactNetwork>(model.contact)](const Touching& w) {
           return contact_points(w.points, fast->forward(w.points, contact_features(w.points, past(w), c), past(w)), c);
         }});
  return out;
}

/// Contacts (1, T, J) of feet with the floor.
Tensor on_floor(const Tensor& contacts, double floor) {
  static const Tensor feet = foot_joints();
  return feet & ((contacts.select(3, 1) - floor).abs() < kOnFloor);
}

/// Counts (4: right, wrong, missed, metres apart; 2: on the floor, others; seconds; J) of the contacts (1, T, J, 4)
/// that a source says, against the real ones.
Tensor counts_of(const Tensor& got, const Tensor& real, double floor, int64_t second) {
  const Tensor says = got.select(3, 3) > 0.5, is = real.select(3, 3) > 0.5;
  const Tensor apart = (got.narrow(3, 0, 3) - real.narrow(3, 0, 3)).norm(2, {3});
  std::vector<Tensor> kinds;
  for (const bool of_floor : {true, false}) {
    const Tensor real_kind = on_floor(real, floor) == of_floor, got_kind = on_floor(got, floor) == of_floor;
    const std::vector<Tensor> each = {
        (says & is & real_kind).to(torch::kDouble), (says & ~is & got_kind).to(torch::kDouble),
        (is & ~says & real_kind).to(torch::kDouble), (apart * (says & is & real_kind)).to(torch::kDouble)};
    std::vector<Tensor> seconds;
    for (const Tensor& part : torch::stack(each).select(1, 0).split(second, 1)) seconds.push_back(part.sum(1));
    kinds.push_back(torch::stack(seconds, 1));  // (4, seconds, J)
  }
  return torch::stack(kinds, 1);
}

/// Cells of a row from counts (windows, 4, seconds). @param draws windows of each resample (bootstrap_counts)
std::vector<Estimate> cells_of(const Tensor& counts, const Tensor& draws) {
  const auto ratio = [&](const Tensor& above, const Tensor& below) {
    const auto all = below.sum().item<double>();
    return Estimate{all > 0 ? above.sum().item<double>() / all : std::numeric_limits<double>::quiet_NaN(),
                    half_interval(resampled_ratios(above, below, draws))};
  };
  std::vector<Estimate> out;
  for (int64_t s = 0; s < counts.size(2); ++s) {
    const auto count = [&](int64_t kind) { return counts.select(1, kind).select(1, s); };
    const Tensor right = count(0), wrong = count(1), missed = count(2);
    out.push_back(ratio(right, right + wrong));
    out.push_back(ratio(right, right + missed));
    out.push_back(ratio(count(3) * 1000, right));
  }
  return out;
}

/// Rows of some windows from their counts (windows, sources, 4, 2, seconds, J). @param data names their data set;
/// empty: there is one. @param of_joints whether the last source has a row for each joint, too.
void add_rows(const std::vector<Source>& sources, const Tensor& counts, const std::vector<std::string>& data,
              bool of_joints, ScoreTable& out) {
  const Tensor draws = bootstrap_counts(counts.size(0), kContactResamples, 1);
  const auto add = [&](const std::string& source, const std::string& of, const Tensor& of_row) {
    std::vector<std::string> labels = data;
    labels.insert(labels.end(), {source, of});
    out.rows.push_back({labels, cells_of(of_row, draws)});
  };
  for (size_t k = 0; k < sources.size(); ++k) {
    const Tensor joints = counts.select(1, static_cast<int64_t>(k)).sum(4);  // (windows, 4, 2, seconds)
    add(sources[k].name, "feet on the floor", joints.select(2, 0));
    add(sources[k].name, "all others", joints.select(2, 1));
  }
  if (!of_joints) return;
  const Tensor predicted = counts.select(1, counts.size(1) - 1).sum(2);  // (windows, 4, seconds, J)
  for (int j = 0; j < kStandardJoints; ++j)
    add(sources.back().name, standard_joint_names()[static_cast<size_t>(j)], predicted.select(3, j));
}

}  // namespace

Config dense_config(const Config& config) {
  Config dense = config;
  dense.inference.points = kDensePoints;
  return dense;
}

ScoreTable evaluate_contacts(const Networks& model, const Data& data, const Data& dense, const Progress& progress,
                             const MeasuredParts& parts) {
  torch::NoGradGuard no_grad;
  const Config& config = model.config;
  if (config.joints != kStandardJoints) throw Error("eval contacts", "needs a model of the standard 22 joints");
  if (data.size() == 0 || data.size() != dense.size()) throw Error("eval contacts", "has no window");
  const std::vector<Source> sources = sources_of(model);
  const auto second = std::min<int64_t>(config.future, std::llround(config.rate));
  const int64_t seconds = (config.future + second - 1) / second;
  std::map<std::string, Tensor> measured = {
      {"counts", torch::zeros({data.size(), static_cast<int64_t>(sources.size()), 4, 2, seconds, config.joints},
                              torch::kDouble)}};
  std::vector<int64_t> windows(static_cast<size_t>(data.size()));
  std::iota(windows.begin(), windows.end(), 0);
  int64_t done = 0;
  const int64_t mine = std::count_if(windows.begin(), windows.end(), [&](int64_t i) { return parts.shard().has(i); });
  for (const int64_t i : windows) {
    if (!parts.shard().has(i)) continue;
    const Sample s = data.sample(i, 0, false), d = dense.sample(i, 0, false);
    const Touching w{s.points.unsqueeze(0), d.points.unsqueeze(0), s.joints.unsqueeze(0)};
    // By the scene's points alone, not by feet (scene/floor.h), whose contacts are what is judged.
    const double floor = d.points.select(1, 1).contiguous().quantile(kBelowFloor).item<double>();
    const Tensor real = true_contact_points(w.dense, w.joints.slice(1, config.past), config);
    for (size_t k = 0; k < sources.size(); ++k)
      measured["counts"][i][static_cast<int64_t>(k)].copy_(counts_of(sources[k].contacts(w), real, floor, second));
    if (progress) progress(++done, mine);
  }

  ScoreTable out;
  if (!parts.complete(windows, measured)) return out;
  const Tensor counts = measured["counts"];  // (windows, sources, 4, 2, seconds, J)
  const auto sets = data.windows().by_set();
  const bool several = sets.size() > 1;
  out.labels = {"contacts", "of"};
  if (several) out.labels.insert(out.labels.begin(), "data");
  for (int64_t first = 0; first < config.future; first += second) {
    const std::string group = fmt::format("second {}", first / second + 1),
                      key = fmt::format("second{}", first / second + 1);
    out.columns.push_back({group, "precision", key + "/precision", 3});
    out.columns.push_back({group, "recall", key + "/recall", 3});
    out.columns.push_back({group, "apart (mm)", key + "/apart", 0});
  }
  using Labels = std::vector<std::string>;
  add_rows(sources, counts, several ? Labels{"all"} : Labels{}, !model.contact.is_empty(), out);
  if (several)
    for (const auto& [set, of_set] : sets)
      add_rows(sources, counts.index_select(0, torch::tensor(of_set)), {set}, false, out);
  out.notes = {fmt::format("{} windows; real: contacts among {} scene points", data.size(), kDensePoints)};
  return out;
}

}  // namespace inhabit::forecast
