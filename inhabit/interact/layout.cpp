#include "inhabit/interact/layout.h"

#include "inhabit/error.h"

namespace inhabit::interact {
namespace {

/// Spans one after the other.
struct SpanMaker {
  int64_t next = 0;
  Span operator()(int64_t size) {
    const Span span{next, size};
    next += size;
    return span;
  }
};

}  // namespace

InputLayout input_layout(const Config& c) {
  SpanMaker span;
  InputLayout out;
  const int64_t keys = c.keys(), actions = c.actions;
  out.joints = span(int64_t{12} * c.joints);
  out.trajectory = span(keys * (4 + actions));
  out.goals = span(keys * (6 + actions));
  out.ego = span(c.ego_points());
  out.chair = span(c.chair_size());
  out.hands = span(2 * keys * 3);
  out.hand_phases = span(2 * keys);
  out.ahead = span(c.seated_habits ? kAheadSize : 0);
  out.gating = span(keys * actions * (2 + 6));
  out.size = span.next;
  return out;
}

OutputLayout output_layout(const Config& c) {
  SpanMaker span;
  OutputLayout out;
  const int64_t keys = c.keys(), actions = c.actions, points = c.future_points();
  out.joints = span(int64_t{12} * c.joints);
  out.future_joints = span(int64_t{3} * c.joints);
  out.trajectory = span(points * (4 + actions));
  out.goal_root = span(points * 4);
  out.goals = span(keys * (6 + actions));
  out.contacts = span(kContacts);
  out.phases = span(points);
  out.size = span.next;
  return out;
}

void require_window(const Config& c, const std::string& subject) {
  if (c.past_keys != kPastKeys || c.future_keys != kFutureKeys || c.key_step != kKeyStep || c.joints != kJoints ||
      c.actions != kActions)
    throw Error(subject,
                "has another window, skeleton or set of actions than 13 keys 5 frames apart, 22 joints and 3 "
                "actions, which is what features are built of");
}

}  // namespace inhabit::interact
