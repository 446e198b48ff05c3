#include <cmath>
#include <deque>
#include <functional>

#include "handles.h"
#include "options.h"

namespace {

struct Said {
  std::string person, error;
  double time = 0;
  std::unique_ptr<inhabit_result> result;
};

}  // namespace

struct inhabit_stream {
  std::function<void(const std::string&, double, const torch::Tensor&)> push;
  std::function<void(std::deque<Said>&)> take;
  std::deque<Said> waiting;
  Said last;  // whose name was given out
};

namespace inhabit::c {
namespace {

template <class Stream>
std::unique_ptr<inhabit_stream> behind(std::shared_ptr<Stream> stream) {
  auto out = std::make_unique<inhabit_stream>();
  out->push = [stream](const std::string& person, double time, const torch::Tensor& joints) {
    stream->push(person, time, joints);
  };
  out->take = [stream](std::deque<Said>& to) {
    for (auto& r : stream->take()) {
      Said& said = to.emplace_back();
      said.person = r.person;
      said.time = r.time;
      said.error = r.error;
      if (r.error.empty()) said.result = std::make_unique<inhabit_result>(result_of(std::move(r.result)));
    }
  };
  return out;
}

void take_poses(Options& text, PoseStreamOptions& poses) {
  text.take("rate", poses.rate);
  text.take("gap", poses.longest_gap);
  text.take("people", poses.people);
  text.take("names", poses.names);
  text.take("parents", poses.parents);
}

std::unique_ptr<inhabit_stream> opened(const std::shared_ptr<const forecast::ContactForecaster>& system,
                                       const Scene& scene, Options& text) {
  forecast::StreamOptions options;
  options.forecast.standard = true;
  bool refine = false;
  take_poses(text, options.poses);
  text.take("points", options.forecast.points);
  text.take("seed", options.forecast.seed);
  text.take("refine", refine);
  text.finish();
  options.forecast.joints_alone = !refine;
  return behind(std::make_shared<forecast::ForecastStream>(system, scene, options));
}

std::unique_ptr<inhabit_stream> opened(const std::shared_ptr<const anticipate::IntentionAnticipator>& system,
                                       const Scene&, Options& text) {
  anticipate::StreamOptions options;
  take_poses(text, options.poses);
  text.take("samples", options.anticipate.samples);
  text.take("seconds", options.anticipate.seconds);
  text.take("seed", options.anticipate.seed);
  text.finish();
  return behind(std::make_shared<anticipate::AnticipateStream>(system, options));
}

template <class Other>
std::unique_ptr<inhabit_stream> opened(const Other&, const Scene&, Options&) {
  throw Error("system", "has no stream: forecast and anticipate do");
}

}  // namespace
}  // namespace inhabit::c

using namespace inhabit;
using namespace inhabit::c;

inhabit_stream* inhabit_stream_open(const inhabit_system* system, const inhabit_scene* scene, const char* options) {
  return guarded<>(static_cast<inhabit_stream*>(nullptr), [&] {
    needed(system, "system");
    Options given(options);
    return std::visit([&](const auto& one) { return opened(one, scene == nullptr ? Scene() : scene->scene, given); },
                      system->system)
        .release();
  });
}

int inhabit_stream_push(inhabit_stream* stream, const char* person, double time, const float* joints, int64_t count) {
  return guarded<>(-1, [&] {
    needed(stream, "stream");
    needed(joints, "joints");
    if (count < 1 || count > 1000) throw Error("count", "is not 1 to 1000");
    stream->push(text_of(person, "person"), time,
                 torch::from_blob(const_cast<float*>(joints), {count, 3}, torch::kFloat32));
    return 0;
  });
}

int inhabit_stream_next(inhabit_stream* stream, const char** person, double* time, inhabit_result** result) {
  return guarded<>(-1, [&] {
    needed(stream, "stream");
    inhabit_result*& to = needed(result, "result");
    to = nullptr;
    if (person != nullptr) *person = "";  // also where making what is due fails
    if (time != nullptr) *time = NAN;
    if (stream->waiting.empty()) stream->take(stream->waiting);
    if (stream->waiting.empty()) return 0;
    stream->last = std::move(stream->waiting.front());
    stream->waiting.pop_front();
    if (person != nullptr) *person = stream->last.person.c_str();
    if (time != nullptr) *time = stream->last.time;
    if (!stream->last.error.empty()) {
      set_last_error(stream->last.error);
      return -1;
    }
    to = stream->last.result.release();
    return 1;
  });
}

void inhabit_stream_free(inhabit_stream* stream) { delete stream; }
