#include "inhabit/body/palm.h"

namespace inhabit {
namespace {

constexpr float kPalmReach = 0.085F, kPalmDepth = 0.025F;  // metres from the wrist, along the hand and below it

}  // namespace

Eigen::Vector3f palm_offset(int side) {
  // At rest hands point sideways, palms down.
  return {side == 0 ? kPalmReach : -kPalmReach, -kPalmDepth, 0};
}

}  // namespace inhabit
