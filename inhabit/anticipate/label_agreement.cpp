#include "inhabit/anticipate/label_agreement.h"

#include <map>

#include "inhabit/error.h"
#include "inhabit/io/npz.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

/// Labels by their places among those that occur, 0 to N - 1: theirs may be any whole numbers.
Tensor ranks_of(const Tensor& labels) {
  return std::get<1>(at::_unique2(labels, /*sorted=*/true, /*return_inverse=*/true));
}

/// (T) int64 of an array of labels.
Tensor whole_labels(const Tensor& labels, const std::string& name, const std::string& path) {
  constexpr double kExact = 9e15;  // a double holds every whole number below
  const bool whole = labels.dim() == 1 && (!labels.is_floating_point() ||
                                           ((labels.abs() < kExact) & (labels == labels.round())).all().item<bool>());
  if (!whole) throw Error(path, name + " is no list of whole numbers");
  return labels.to(torch::kInt64);
}

}  // namespace

double normalised_mutual_information(const Tensor& a, const Tensor& b) {
  if (a.numel() == 0 || a.sizes() != b.sizes()) throw Error("labels", "are of different frames, or of none");
  const Tensor ranks_a = ranks_of(a), ranks_b = ranks_of(b);
  const int64_t width = ranks_b.max().item<int64_t>() + 1;
  const auto entropy = [&](const Tensor& ids) {
    const Tensor counts = std::get<2>(at::_unique2(ids, /*sorted=*/true, /*return_inverse=*/false,
                                                   /*return_counts=*/true)),
                 p = counts.to(torch::kFloat64) / ids.numel();
    return -(p * p.log()).sum().item<double>();
  };
  const double of_a = entropy(ranks_a), of_b = entropy(ranks_b), joint = entropy(ranks_a * width + ranks_b);
  if (of_a + of_b <= 0) return 1;
  return 2 * (of_a + of_b - joint) / (of_a + of_b);
}

LabelAgreement label_agreement(const std::string& path, const std::vector<Sequence>& recordings,
                               const std::vector<Tensor>& tracks, double rate) {
  constexpr double kTheirRate = 120;
  const Npz theirs = read_npz(path);
  std::vector<Tensor> ours, other, actions;
  std::map<std::string, int64_t> numbers;
  LabelAgreement out;
  for (size_t i = 0; i < recordings.size(); ++i) {
    const Sequence& recording = recordings[i];
    const auto found = theirs.tensors.find(std::string(recording.split == "test" ? "test/" : "train/") +
                                           recording.action + "/" + recording.name);
    if (found == theirs.tensors.end()) continue;
    const Tensor labels = whole_labels(found->second, found->first, path);
    const Tensor rows = (torch::arange(tracks[i].size(0)) * (kTheirRate / rate)).round().to(torch::kInt64);
    const Tensor both = rows.index({rows < labels.size(0)});
    other.push_back(labels.index_select(0, both));
    ours.push_back(tracks[i].slice(0, 0, both.size(0)));
    actions.push_back(
        torch::full({both.size(0)}, numbers.emplace(recording.action, numbers.size()).first->second, torch::kInt64));
    ++out.recordings;
  }
  if (out.recordings == 0) throw Error(path, "has labels of none of the recordings");
  const Tensor a = torch::cat(ours), b = torch::cat(other), c = torch::cat(actions);
  out.frames = a.size(0);
  out.labels = normalised_mutual_information(a, b);
  out.actions_and_other = normalised_mutual_information(c, b);
  out.actions_and_ours = normalised_mutual_information(c, a);
  return out;
}

}  // namespace inhabit::anticipate
