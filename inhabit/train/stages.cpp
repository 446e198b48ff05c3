#include "inhabit/train/stages.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"

namespace inhabit {
namespace {
std::string checkpoint_of(const std::string& out) { return out + ".checkpoint.safetensors"; }
}  // namespace

size_t first_stage(const std::string& out, const std::vector<std::string>& stages, bool resume) {
  if (!resume) return 0;
  const auto state = read_safetensors_metadata(checkpoint_of(out));
  const auto run = state.find("run");
  const std::string name = run == state.end() ? "" : run->second.substr(0, run->second.find(' '));
  const auto found = std::find(stages.begin(), stages.end(), name);
  if (found == stages.end()) throw Error(checkpoint_of(out), "is not a checkpoint of the stages asked for");
  return static_cast<size_t>(found - stages.begin());
}

TrainOptions stage_options(const std::string& out, size_t stage, size_t first, bool resume) {
  TrainOptions options;
  options.resume = resume && stage == first;
  options.checkpoint = checkpoint_of(out);
  options.log = out + ".log.jsonl";
  options.append_log = stage > 0 || options.resume;
  return options;
}

}  // namespace inhabit
