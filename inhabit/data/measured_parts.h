#pragma once
#include <torch/types.h>

#include <map>
#include <string>
#include <vector>

#include "inhabit/data/shard.h"

namespace inhabit {

/// What an evaluation measures of its items (batches of windows, windows in one scene), for several processes or
/// machines that measure a part each. Parts are kept beside the table, as FILE.2-of-8.part; whoever finds all of them
/// puts them together. What is measured of an item does not depend on the number of parts.
class MeasuredParts {
 public:
  /// All in one: nothing is kept.
  MeasuredParts() = default;
  /// @param file the table's. @param job what the numbers depend on, as text: parts of another job are refused
  MeasuredParts(Shard shard, std::string file, std::string job)
      : shard_(shard), file_(std::move(file)), job_(std::move(job)) {}

  const Shard& shard() const { return shard_; }  ///< which part this is

  /// Keeps what this part measured and, where all parts are there, puts in what the others did. False where some are
  /// still to come. @param item_of_row the item that each row of what is measured is of. @param measured tensors with
  /// these rows. Throws Error naming a part that is of another job or damaged.
  bool complete(const std::vector<int64_t>& item_of_row, std::map<std::string, torch::Tensor>& measured) const;
  /// Removes all parts, once the table is written: another evaluation into the same file finds none of them.
  void remove() const;

 private:
  std::string part(int64_t number) const;

  Shard shard_;
  std::string file_, job_;
};

}  // namespace inhabit
