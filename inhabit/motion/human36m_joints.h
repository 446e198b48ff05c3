#pragma once
#include <string>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// Whether joints (T, 17, 3) or (T, 32, 3) lie as Human3.6M numbers them: hips on both sides of the first joint, near
/// it as seen from the head.
bool in_human36m_order(const torch::Tensor& joints);

/// A clip, without rotations, of Human3.6M's 32 joints, of which 17 move, or of these 17 as networks that lift poses
/// from images give them. @param joints (T, 32, 3) or (T, 17, 3) metres. Throws Error(subject, ...) for another shape
/// and where a number is not finite.
Clip human36m_clip(const torch::Tensor& joints, double rate, const std::string& subject);

}  // namespace inhabit
