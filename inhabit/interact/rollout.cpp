#include "inhabit/interact/rollout.h"

#include <algorithm>

#include "inhabit/interact/advance.h"
#include "inhabit/interact/settle.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kTogether = 4;  // people that a thread takes at a time

/// What a person is told from outside: the plan of the hands, and the goal that comes into sight.
void take_control(const State& recorded, State& state) {
  state.contact = recorded.contact;
  state.wanted = recorded.wanted;
  state.ahead = recorded.ahead;
  for (size_t i = kNow + 1; i < kSamples; ++i) {
    state.samples[i].hand = recorded.samples[i].hand;
    state.samples[i].hand_phase = recorded.samples[i].hand_phase;
  }
  state.now().hand_phase = recorded.now().hand_phase;
  Sample& last = state.samples.back();
  last.goal = recorded.samples.back().goal;
  last.goal_facing = recorded.samples.back().goal_facing;
  last.goal_action = recorded.samples.back().goal_action;
}

}  // namespace

PoseRows rollout(const Data& data, const std::vector<int64_t>& indices, int64_t frames, const PoseFunction& predict,
                 const std::vector<SenseNoise>& noise) {
  const Config& config = data.config();
  const InputLayout in = input_layout(config);
  const OutputLayout out = output_layout(config);
  const auto& inference = config.inference;
  const GoalWeights weights = {inference.goal_idle, inference.goal_walk, inference.goal_sit};
  const auto people = static_cast<int64_t>(indices.size());
  PoseRows rows{torch::empty({frames, people, in.size}), torch::empty({frames, people, out.size}),
                torch::zeros({frames, people, 8})};
  std::vector<State> states;
  std::vector<Data::FramePlace> places;
  for (const int64_t i : indices) {
    places.push_back(data.pose_place(i));
    states.push_back(state_at(data.recording(places.back().clip), places.back().frame));
  }
  // People are independent of each other between two predictions.
  const auto each_of_some = [people](const auto& work) {
    nn::parallel_chunks((people + kTogether - 1) / kTogether, [&](int64_t chunk) {
      SettledPose pose;
      for (int64_t p = chunk * kTogether; p < std::min(people, (chunk + 1) * kTogether); ++p) work(p, pose);
    });
  };
  for (int64_t t = 0; t < frames; ++t) {
    each_of_some([&](int64_t p, SettledPose&) {
      const auto& [clip, frame] = places[static_cast<size_t>(p)];
      const State& now = states[static_cast<size_t>(p)];
      float* input = rows.input.data_ptr<float>() + (t * people + p) * in.size;
      build_input(in, now, data.senses(clip), input);
      if (!noise.empty()) noise[static_cast<size_t>(p)].apply(input);
      build_target(out, now, state_at(data.recording(clip), frame + t + 1),
                   rows.target.data_ptr<float>() + (t * people + p) * out.size);
      build_contacts(now, rows.contacts.data_ptr<float>() + (t * people + p) * 8);
    });
    if (t + 1 == frames) break;
    const torch::Tensor predicted = predict(rows.input[t], rows.contacts[t]).contiguous();
    each_of_some([&](int64_t p, SettledPose& pose) {
      const auto& [clip, frame] = places[static_cast<size_t>(p)];
      State& state = states[static_cast<size_t>(p)];
      apply_output(out, predicted.data_ptr<float>() + p * out.size, weights, config.rate, state);
      settle(data.recording(clip).bones, state, pose);
      take_control(state_at(data.recording(clip), frame + t + 1), state);
    });
  }
  return {rows.input.flatten(0, 1), rows.target.flatten(0, 1), rows.contacts.flatten(0, 1)};
}

}  // namespace inhabit::interact
