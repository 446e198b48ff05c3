#pragma once
#include "inhabit/refine/problem.h"

namespace inhabit::refine {

/// When the search ends.
struct SolveOptions {
  int iterations = 20;      ///< at most
  double tolerance = 1e-4;  ///< stops where a step lessens the cost by less than this part of it
};

/// What the search has found.
struct Solution {
  Trajectory trajectory;  ///< of all frames
  double start_cost = 0;  ///< where the search begins; 0 where no step was tried
  double cost = 0;        ///< of `trajectory`
  int iterations = 0;     ///< steps taken
};

/// The trajectory of least cost near where `problem` begins: Gauss-Newton steps, damped as Levenberg and Marquardt do,
/// of all frames at once. Time and memory grow linearly with the frames. Fixed frames and known unknowns come out bit
/// by bit as they went in. The same problem gives the same solution whatever the number of threads. Throws Error where
/// sizes disagree or a number is not finite.
Solution solve(const Problem& problem, const SolveOptions& options = {});

}  // namespace inhabit::refine
