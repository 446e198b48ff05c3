#include "inhabit/interact/settle.h"

#include "inhabit/body/two_bone.h"

namespace inhabit::interact {

void settle(const Bones& bones, State& state, SettledPose& pose) {
  pose.local.resize(kJoints);
  std::array<Eigen::Quaterniond, kJoints> global;
  for (size_t j = 0; j < kJoints; ++j) {
    global[j] = Eigen::Quaterniond(state.rotation[j].cast<double>()).normalized();
    pose.local[j] =
        j == 0 ? global[0] : (global[static_cast<size_t>(bones.parents[j])].conjugate() * global[j]).normalized();
  }
  pose.trans = state.position[0].cast<double>() - bones.offsets[0];
  pose_bones(bones, pose.local, pose.trans, pose.posed);
  for (const Side side : {Side::left, Side::right})
    for (const Limb& limb : {leg(side), arm(side)}) {
      const auto end = static_cast<size_t>(limb.end);
      move_limb_end(bones, limb, state.position[end].cast<double>() - pose.posed.positions[end], pose.posed,
                    pose.local);
    }
  pose_bones(bones, pose.local, pose.trans, pose.posed);
  for (size_t j = 0; j < kJoints; ++j) {
    state.position[j] = pose.posed.positions[j].cast<float>();
    state.rotation[j] = pose.posed.rotations[j].toRotationMatrix().cast<float>();
  }
  for (int side = 0; side < 2; ++side) state.now().hand[static_cast<size_t>(side)] = palm_of(state, side);
}

}  // namespace inhabit::interact
