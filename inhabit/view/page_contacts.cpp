#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/view/page_parts.h"

namespace inhabit {

using nlohmann::json;

namespace {

constexpr int64_t kMaxContactPairs = 24'000;
constexpr double kContactRate = 15;  // maps a second; the page interpolates

}  // namespace

/// Of the T x J x N values only those (joint, point) pairs are kept whose largest value over time is worth a look, at
/// kContactRate maps a second, 8 bits each, as differences from the map before (which is what compresses).
json describe_contacts(PageBlob& blob, const PageContacts& contacts, const std::string& path) {
  const torch::Tensor maps = plain(contacts.maps);
  if (maps.dim() != 3 || contacts.points.dim() != 2 || contacts.points.size(1) != 3 ||
      maps.size(2) != contacts.points.size(0) || maps.size(0) == 0)
    throw Error(path, "contact maps (T, J, N) and points (N, 3) do not agree");
  const int64_t frames = maps.size(0), joints = maps.size(1);
  const auto& names = contacts.names.empty() ? standard_joint_names() : contacts.names;
  if (static_cast<int64_t>(names.size()) != joints) throw Error(path, "contact maps have other joints than names");
  if (!(contacts.rate > 0) || !std::isfinite(contacts.rate) || !std::isfinite(contacts.start_seconds))
    throw Error(path, "contact maps need a rate above zero and a finite start time");
  require_finite(maps, path, "a contact map");
  require_finite(contacts.points, path, "a contact map's points");

  const int64_t step = std::max<int64_t>(1, std::llround(contacts.rate / kContactRate));
  const torch::Tensor key_maps = maps.slice(0, 0, frames, step);
  const int64_t keys = key_maps.size(0);
  const torch::Tensor largest = std::get<0>(key_maps.max(0)).contiguous();  // (J, N)
  double threshold = 0.04;
  if ((largest > threshold).sum().item<int64_t>() > kMaxContactPairs)
    threshold = std::get<0>(largest.reshape({-1}).topk(kMaxContactPairs)).min().item<double>();
  std::vector<uint32_t> first{0};
  std::vector<uint8_t> values;
  std::vector<torch::Tensor> chosen;
  for (int64_t j = 0; j < joints; ++j) {
    const torch::Tensor index = torch::nonzero(largest[j] > threshold).squeeze(1);
    const torch::Tensor q = (key_maps.select(1, j).index_select(1, index).clamp(0, 1) * 255).round();
    const torch::Tensor before = torch::cat({torch::zeros({1, index.size(0)}), q.slice(0, 0, keys - 1)});
    const torch::Tensor change = (q - before).transpose(0, 1).to(torch::kInt32).contiguous();  // (points, keys)
    const int* at = change.data_ptr<int>();
    for (int64_t i = 0; i < change.numel(); ++i) values.push_back(static_cast<uint8_t>(at[i]));
    chosen.push_back(index);
    first.push_back(first.back() + static_cast<uint32_t>(index.size(0)));
  }
  return {{"names", names},
          {"start", contacts.start_seconds},
          {"rate", contacts.rate / static_cast<double>(step)},
          {"keys", keys},
          {"points", blob.add_positions(contacts.points)},
          {"first", blob.add(first, "u32")},
          {"index", blob.add_indices(torch::cat(chosen), contacts.points.size(0))},
          {"changes", blob.add(values, "u8")}};
}

}  // namespace inhabit
