#pragma once
#include <torch/types.h>

#include <random>

namespace inhabit::inbetween {

/// Key frames that a training window is conditioned on, drawn at random.
struct DrawnKeys {
  torch::Tensor groups;  ///< (T, 25) what each frame constrains (keyframes.h)
  torch::Tensor ends;    ///< (T) 1 at the first and the last key frame, and at frames that are known
};

/// Whole keys at the first frame and the last, and between them a number that is drawn evenly from the paper's {2, ...,
/// T} or, every second time, evenly in its logarithm: keys far apart, which users mostly have, are rare in the first.
/// Some windows end in frames of no key, as a clip shorter than a window does; some begin with known frames, as the
/// later windows of long clips do. @param partial some keys constrain positions of joints alone. @param far probability
/// of keys at equal distances of 30 to 120 frames instead
DrawnKeys draw_keys(int64_t frames, bool partial, double far, std::mt19937_64& random);

}  // namespace inhabit::inbetween
