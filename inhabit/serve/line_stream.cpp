#include "inhabit/serve/line_stream.h"

#include <charconv>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "inhabit/error.h"
#include "inhabit/serve/line_queue.h"

namespace inhabit::serve {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLongestWait{50};  // live: results are not put off longer for lines that wait

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void append_number(std::string& text, double value) {
  char buffer[40];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr);
}

Tensor upright(const Tensor& p) { return torch::stack({p.select(-1, 0), p.select(-1, 2), -p.select(-1, 1)}, -1); }
Tensor z_up(const Tensor& p) { return torch::stack({p.select(-1, 0), -p.select(-1, 2), p.select(-1, 1)}, -1); }

/// One stream of lines at work.
class Answering {
 public:
  Answering(const LineStream& stream, const LineOptions& options, const std::function<void(const std::string&)>& write)
      : stream_(stream), options_(options), write_(write) {
    std::string names, parents;
    for (const std::string& name : standard_joint_names()) names += (names.empty() ? "" : ",") + quoted(name);
    for (const int parent : standard_parents()) parents += (parents.empty() ? "" : ",") + std::to_string(parent);
    std::string ready = "{\"ready\":" + quoted(stream.name) + ",\"rate\":";
    append_number(ready, stream.rate / options.every);
    write(ready + ",\"names\":[" + names + "],\"parents\":[" + parents + "]}\n");
  }

  void take(const Line& line) {
    ++number_;
    if (line.text.find_first_not_of(" \t\r") == std::string::npos && !line.too_long) return;
    try {
      if (line.too_long) throw Error("line", "is longer than a mebibyte");
      const StreamLine parsed = parse_stream_line(line.text);
      if (const auto* names = std::get_if<JointNames>(&parsed)) {
        if (system_) throw Error("line", "names joints, which must come before the first pose");
        system_ = stream_.begin(*names);
        return;
      }
      const auto& pose = std::get<PoseLine>(parsed);
      if (!system_) system_ = stream_.begin({});
      if (!options_.live && system_->due(pose.person)) answer();
      system_->push(pose.person, pose.time, options_.z_up ? upright(pose.joints) : pose.joints);
      if (system_->due(pose.person) && !due_since_) due_since_ = Clock::now();
    } catch (const Error& error) {
      write_("{\"error\":" + quoted(error.what()) + ",\"line\":" + std::to_string(number_) + "}\n");
    }
  }

  bool pressing() const { return due_since_ && Clock::now() - *due_since_ > kLongestWait; }

  void answer() {
    due_since_.reset();
    if (!system_) return;
    for (const LineResult& result : system_->take()) write_(line_of(result));
  }

 private:
  std::string line_of(const LineResult& result) const {
    std::string text = "{\"time\":";
    append_number(text, result.time);
    text += ",\"person\":" + quoted(result.person);
    if (!result.doubt.empty()) text += ",\"warning\":" + quoted(result.doubt);
    if (!result.error.empty()) return text + ",\"error\":" + quoted(result.error) + "}\n";
    text += ",\"rate\":";
    append_number(text, stream_.rate / options_.every);
    const Tensor frames = result.joints.slice(-3, options_.every - 1, result.joints.size(-3), options_.every);
    text += frames.dim() == 4 ? ",\"futures\":" : ",\"joints\":";
    append_places(text, options_.z_up ? z_up(frames) : frames);
    if (result.labels.defined()) {
      text += ",\"labels\":";
      append_places(text, result.labels.slice(1, options_.every - 1, result.labels.size(1), options_.every));
    }
    return text + "}\n";
  }

  const LineStream& stream_;
  const LineOptions& options_;
  const std::function<void(const std::string&)>& write_;
  std::optional<LineSystem> system_;
  std::optional<Clock::time_point> due_since_;
  int64_t number_ = 0;
};

/// A stream behind the functions that lines need.
template <class Stream, class Told>
LineSystem line_system(std::shared_ptr<Stream> stream, const Told& told) {
  LineSystem out;
  out.push = [stream](const std::string& person, double time, const Tensor& joints) {
    stream->push(person, time, joints);
  };
  out.due = [stream](const std::string& person) { return stream->due(person); };
  out.take = [stream, told] {
    std::vector<LineResult> results;
    for (const auto& r : stream->take()) {
      LineResult& to = results.emplace_back();
      to.person = r.person;
      to.time = r.time;
      to.error = r.error;
      to.doubt = r.doubt;
      if (r.error.empty()) told(r.result, to);
    }
    return results;
  };
  return out;
}

template <class Options>
Options with_names(Options options, const JointNames& joints) {
  options.poses.names = joints.names;
  options.poses.parents = joints.parents;
  return options;
}

}  // namespace

LineStream forecast_lines(std::shared_ptr<const forecast::ContactForecaster> forecaster, const Scene& scene,
                          const forecast::StreamOptions& options) {
  // What is wrong with the options is said here, before lines are read.
  [[maybe_unused]] const forecast::ForecastStream trial(forecaster, scene, options);
  return {"forecast", forecaster->config().rate, forecaster->config().future, [=](const JointNames& joints) {
            return line_system(
                std::make_shared<forecast::ForecastStream>(forecaster, scene, with_names(options, joints)),
                [](const forecast::Result& r, LineResult& to) { to.joints = r.prediction.joints; });
          }};
}

LineStream anticipate_lines(std::shared_ptr<const anticipate::IntentionAnticipator> anticipator,
                            const anticipate::StreamOptions& options) {
  [[maybe_unused]] const anticipate::AnticipateStream trial(anticipator, options);
  const double rate = anticipator->config().rate;
  const int64_t frames = std::max<int64_t>(1, std::llround(options.anticipate.seconds * rate));
  return {"anticipate", rate, frames, [=](const JointNames& joints) {
            return line_system(std::make_shared<anticipate::AnticipateStream>(anticipator, with_names(options, joints)),
                               [](const anticipate::Result& r, LineResult& to) {
                                 std::vector<Tensor> futures;
                                 for (const Clip& future : r.futures) futures.push_back(future.joints);
                                 to.joints = torch::stack(futures);
                                 to.labels = r.labels;
                               });
          }};
}

void validate(const LineOptions& options, const LineStream& stream) {
  if (options.every < 1) throw Error("--every", "is under 1");
  if (options.every > stream.frames)
    throw Error("--every", std::to_string(options.every) + " is more than the " + std::to_string(stream.frames) +
                               " frames that there are");
}

void answer_lines(int input, const LineStream& stream, const LineOptions& options,
                  const std::function<void(const std::string&)>& write) {
  validate(options, stream);
  Answering answering(stream, options, write);
  LineQueue lines(input);
  Line line;
  for (;;) {
    if (!lines.waiting() || (options.live && answering.pressing())) answering.answer();
    if (!lines.next(line)) break;
    answering.take(line);
  }
  answering.answer();
}

}  // namespace inhabit::serve
