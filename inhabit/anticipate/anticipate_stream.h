#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/anticipate/intention_anticipator.h"
#include "inhabit/motion/pose_stream.h"

namespace inhabit::anticipate {

/// How poses come in, and what is made of them.
struct StreamOptions {
  PoseStreamOptions poses{.rate = 2};                                ///< joints, rates, gaps
  Options anticipate{.samples = 5, .seconds = 2, .standard = true};  ///< start and name are not looked at
};

/// A person's futures.
struct StreamResult {
  std::string person;  ///< as push() called them
  double time = 0;     ///< seconds: the time stamp of the last pose; frame k of a future is (k + 1) / rate later
  Result result;       ///< as IntentionAnticipator::run() gives it for what was seen until there
  std::string error;   ///< why there are none, one line; empty: there are
  std::string doubt;   ///< of the first result of a person, what is implausible of their poses; empty: nothing is
};

/// Futures of people whose joints come in one pose at a time, as forecast::ForecastStream takes them. The first come as
/// soon as the model's least number of frames (config().kappa) was seen; up to config().observed are looked at.
///
///   anticipate::AnticipateStream stream(anticipator);
///   stream.push("anna", time, joints);                                    // (22, 3) metres, +Y up
///   for (const anticipate::StreamResult& r : stream.take()) use(r.person, r.time, r.result.futures);
class AnticipateStream {
 public:
  /// Throws Error naming the option that is out of range.
  explicit AnticipateStream(std::shared_ptr<const IntentionAnticipator> anticipator, const StreamOptions& options = {});

  /// Throws Error as PoseStream::push() does; the stream goes on.
  void push(const std::string& person, double time, const torch::Tensor& joints) { poses_.push(person, time, joints); }
  /// Whether take() would give this person futures.
  bool due(const std::string& person) const { return poses_.due(person); }

  /// The futures that are due since the last call, by person, from each one's latest pose: one person after the other,
  /// the futures of each on LibTorch's number of threads.
  std::vector<StreamResult> take();

  /// The poses that are kept.
  const PoseStream& poses() const { return poses_; }

 private:
  std::shared_ptr<const IntentionAnticipator> anticipator_;
  Options options_;
  PoseStream poses_;
};

}  // namespace inhabit::anticipate
