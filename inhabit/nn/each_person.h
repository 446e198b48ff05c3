#pragma once
#include <c10/util/Exception.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/motion/pose_stream.h"
#include "inhabit/nn/one_blas_thread.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::nn {

/// What is made of everybody who is due, a person on each core. @param run makes Result::result of a Due; the Error
/// (or LibTorch's) that it throws becomes that person's Result::error: no pose of a tracker ends anybody else's stream.
template <class Result, class Run>
std::vector<Result> each_person(const std::vector<PoseStream::Due>& due, const Run& run) {
  std::vector<Result> out(due.size());
  std::optional<OneBlasThread> one;
  if (due.size() > 1) one.emplace();
  parallel_chunks(static_cast<int64_t>(due.size()), [&](int64_t chunk) {
    const auto i = static_cast<size_t>(chunk);
    out[i].person = due[i].person;
    out[i].time = due[i].time;
    out[i].doubt = due[i].doubt;
    try {
      out[i].result = run(due[i]);
    } catch (const Error& error) {
      out[i].error = error.what();
    } catch (const c10::Error& error) {
      const std::string said = error.what_without_backtrace();
      out[i].error = said.substr(0, said.find('\n'));
    }
  });
  return out;
}

}  // namespace inhabit::nn
