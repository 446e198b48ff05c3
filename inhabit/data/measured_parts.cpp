#include "inhabit/data/measured_parts.h"

#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"

namespace inhabit {

std::string MeasuredParts::part(int64_t number) const {
  return file_ + "." + Shard{number, shard_.of}.name() + ".part";
}

bool MeasuredParts::complete(const std::vector<int64_t>& item_of_row,
                             std::map<std::string, torch::Tensor>& measured) const {
  if (shard_.is_all()) return true;
  write_safetensors(part(shard_.number), {measured, {{"job", job_}}});
  for (int64_t number = 1; number <= shard_.of; ++number)
    if (!std::filesystem::exists(part(number))) return false;
  for (int64_t number = 1; number <= shard_.of; ++number) {
    if (number == shard_.number) continue;
    const SafeTensors other = read_safetensors(part(number));
    const auto job = other.metadata.find("job");
    if (job == other.metadata.end() || job->second != job_)
      throw Error(part(number), "is of another evaluation: other data, model or settings");
    std::vector<int64_t> own;
    for (size_t row = 0; row < item_of_row.size(); ++row)
      if (Shard{number, shard_.of}.has(item_of_row[row])) own.push_back(static_cast<int64_t>(row));
    const torch::Tensor rows = torch::tensor(own, torch::kInt64);
    for (auto& [name, values] : measured) {
      const auto found = other.tensors.find(name);
      if (found == other.tensors.end() || found->second.sizes() != values.sizes() ||
          found->second.scalar_type() != values.scalar_type())
        throw Error(part(number), "lacks '" + name + "', or has another number of rows of it");
      values.index_copy_(0, rows, found->second.index_select(0, rows));
    }
  }
  return true;
}

void MeasuredParts::remove() const {
  std::error_code gone;  // another process may have found all parts, too
  for (int64_t number = 1; !shard_.is_all() && number <= shard_.of; ++number)
    std::filesystem::remove(part(number), gone);
}

}  // namespace inhabit
