#include "inhabit/anticipate/anticipate_stream.h"

#include "inhabit/error.h"

namespace inhabit::anticipate {

AnticipateStream::AnticipateStream(std::shared_ptr<const IntentionAnticipator> anticipator,
                                   const StreamOptions& options)
    : anticipator_(std::move(anticipator)),
      options_(options.anticipate),
      poses_(options.poses, (anticipator_->config().observed - 1) / anticipator_->config().rate,
             (anticipator_->config().kappa - 1) / anticipator_->config().rate) {
  options_.start = -1;
  options_.name = "person";
  if (options_.samples < 1) throw Error("samples", "must be at least 1");
  if (!(options_.seconds > 0 && options_.seconds <= 3600)) throw Error("seconds", "must be over 0 and at most 3600");
}

std::vector<StreamResult> AnticipateStream::take() {
  std::vector<StreamResult> out;
  const Config& config = anticipator_->config();
  for (const PoseStream::Due& due : poses_.take()) {
    StreamResult& r = out.emplace_back();
    r.person = due.person;
    r.time = due.time;
    try {
      r.result = anticipator_->run(due.window->clip(config.rate, config.observed), {}, options_);
    } catch (const Error& error) {
      r.error = error.what();
    }
  }
  return out;
}

}  // namespace inhabit::anticipate
