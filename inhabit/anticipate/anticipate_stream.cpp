#include "inhabit/anticipate/anticipate_stream.h"

#include "inhabit/error.h"
#include "inhabit/nn/each_person.h"

namespace inhabit::anticipate {

AnticipateStream::AnticipateStream(std::shared_ptr<const IntentionAnticipator> anticipator,
                                   const StreamOptions& options)
    : anticipator_(std::move(anticipator)),
      options_(options.anticipate),
      poses_(options.poses, (anticipator_->config().observed - 1) / anticipator_->config().rate,
             (anticipator_->config().kappa - 1) / anticipator_->config().rate) {
  options_.start = -1;
  options_.name = "person";
  if (options_.samples < 1 || options_.samples > 10'000) throw Error("samples", "must be 1 to 10000");
  if (!(options_.seconds > 0 && options_.seconds <= 3600)) throw Error("seconds", "must be over 0 and at most 3600");
}

std::vector<StreamResult> AnticipateStream::take() {
  const Config& config = anticipator_->config();
  return nn::each_person<StreamResult>(poses_.take(), [&](const PoseStream::Due& due) {
    return anticipator_->run(due.window->clip(config.rate, config.observed), {}, options_);
  });
}

}  // namespace inhabit::anticipate
