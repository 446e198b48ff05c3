#pragma once
#include <torch/types.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "inhabit/anticipate/anticipate_stream.h"
#include "inhabit/forecast/forecast_stream.h"
#include "inhabit/io/pose_line.h"

namespace inhabit::serve {

/// What a system's stream says of one person.
struct LineResult {
  std::string person;    ///< as the lines call them
  double time = 0;       ///< seconds, of the last pose
  std::string error;     ///< why there is nothing else; empty: there is
  std::string doubt;     ///< of the first result of a person, what is implausible of their poses; empty: nothing is
  torch::Tensor joints;  ///< (T, 22, 3) or, of futures, (S, T, 22, 3) metres
  torch::Tensor labels;  ///< (S, T) int64, or undefined
};

/// A stream of one system, begun.
struct LineSystem {
  /// A pose of somebody.
  std::function<void(const std::string& person, double time, const torch::Tensor& joints)> push;
  std::function<bool(const std::string& person)> due;  ///< take() would give this person something
  std::function<std::vector<LineResult>()> take;       ///< what is due
};

/// How a system's stream is begun and what comes out of it.
struct LineStream {
  std::string name;                                           ///< "forecast", "anticipate"
  double rate = 0;                                            ///< frames a second of what comes out
  int64_t frames = 0;                                         ///< of what comes out
  std::function<LineSystem(const JointNames& joints)> begin;  ///< with the first line's joints
};

/// Forecasts of whoever comes in. Throws Error where the options do not fit.
/// @param scene world, metres; a copy is kept
LineStream forecast_lines(std::shared_ptr<const forecast::ContactForecaster> forecaster, const Scene& scene,
                          const forecast::StreamOptions& options);
/// Futures and their intentions of whoever comes in. Throws Error where the options do not fit.
LineStream anticipate_lines(std::shared_ptr<const anticipate::IntentionAnticipator> anticipator,
                            const anticipate::StreamOptions& options);

/// How lines are read and written.
struct LineOptions {
  bool live = false;  ///< what cannot be kept up with is left out; else every result that is due is made
  bool z_up = false;  ///< joints that come in and go out are of a world whose z points up
  int every = 1;      ///< every so many frames are written
};

/// Throws Error where none of the frames that come out would be written.
void validate(const LineOptions& options, const LineStream& stream);

/// Answers the lines of `input` (docs/robots.md), until it ends: a line of results for each person and time, one of
/// {"error": ...} for what cannot be read or forecast. Results of several people are made at once.
/// Throws what validate() throws. @param write called with each line, its end included; may throw to end the stream
void answer_lines(int input, const LineStream& stream, const LineOptions& options,
                  const std::function<void(const std::string&)>& write);

}  // namespace inhabit::serve
