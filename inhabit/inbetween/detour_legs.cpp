#include "inhabit/inbetween/detour_legs.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/heading.h"

namespace inhabit::inbetween {

using Eigen::Vector2f;
using Eigen::Vector3f;
using torch::Tensor;

namespace {

constexpr int kBisections = 24;

Vector2f floor_place(const Poses& poses, int64_t t) { return {poses.root(t).x(), poses.root(t).z()}; }
Vector2f ahead_of(float direction) { return {std::sin(direction), std::cos(direction)}; }
Vector2f left_of_path(float direction) { return {std::cos(direction), -std::sin(direction)}; }

/// A place of a leg, at a fraction of frames.
struct LegPlace {
  Vector2f place;
  float direction, yaw;
};

/// Beyond its ends a leg goes straight on.
LegPlace leg_place(const DetourLegs& legs, const Poses& baseline, int64_t t, float at) {
  const auto frame = static_cast<size_t>(t);
  const int from = legs.from[frame], to = legs.to[frame];
  const float inner = std::clamp(at, static_cast<float>(from), static_cast<float>(to));
  const int i = std::min(static_cast<int>(inner), to - 1);
  // The key at a leg's end is the first frame of the next, which leads elsewhere.
  const float turning = std::min(inner, static_cast<float>(to - 1));
  const int k = std::clamp(static_cast<int>(turning), from, std::max(from, to - 2));
  const auto between = [&](const std::vector<float>& values) {
    const auto at_k = static_cast<size_t>(k), next = static_cast<size_t>(std::min(k + 1, to - 1));
    return values[at_k] + (turning - static_cast<float>(k)) * (values[next] - values[at_k]);
  };
  LegPlace out;
  out.direction = between(legs.direction);
  out.yaw = between(legs.yaw);
  out.place = floor_place(baseline, i) +
              (inner - static_cast<float>(i)) * (floor_place(baseline, i + 1) - floor_place(baseline, i)) +
              (at - inner) * legs.pace[frame] * ahead_of(out.direction);
  return out;
}

bool on_detour(const DetourLegs& legs, int64_t t) { return !legs.none() && legs.pace[static_cast<size_t>(t)] > 0; }

}  // namespace

DetourLegs detour_legs(const Poses& poses, const std::vector<double>& yaws, const std::vector<int64_t>& keys,
                       const Tensor& detours) {
  const auto frames = static_cast<size_t>(poses.frames());
  DetourLegs out{std::vector<int>(frames), std::vector<int>(frames), std::vector<float>(frames),
                 std::vector<float>(frames), std::vector<float>(frames)};
  bool any = false;
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const int64_t from = keys[k], to = keys[k + 1];
    if (to - from < 2 || detours.slice(0, from + 1, to).abs().max().item<double>() == 0) continue;
    float length = 0;
    for (int64_t t = from; t < to; ++t) length += (floor_place(poses, t + 1) - floor_place(poses, t)).norm();
    if (length == 0) continue;
    any = true;
    double before = 0;
    for (int64_t t = from; t < to; ++t) {
      const auto frame = static_cast<size_t>(t);
      const Vector2f along =
          floor_place(poses, std::min(to, t + kAlongPath)) - floor_place(poses, std::max(from, t - kAlongPath));
      const double leads = along.isZero() ? before : inhabit::heading_of(along.cast<double>().eval());
      before = t == from ? leads : before + wrapped(leads - before);
      out.direction[frame] = static_cast<float>(before);
      out.yaw[frame] = static_cast<float>(
          t == from ? yaws[frame]
                    : out.yaw[frame - 1] + wrapped(yaws[frame] - static_cast<double>(out.yaw[frame - 1])));
      if (t == from) continue;
      out.from[frame] = static_cast<int>(from);
      out.to[frame] = static_cast<int>(to);
      out.pace[frame] = length / static_cast<float>(to - from);
    }
  }
  return any ? out : DetourLegs{};
}

DisplacedRoot displaced(const DetourLegs& legs, const Poses& baseline, int64_t t, float heading, const Vector3f& move) {
  const Eigen::AngleAxisf to_world(heading, Vector3f::UnitY());
  if (!on_detour(legs, t)) return {baseline.root(t) + to_world * move, 0};
  const auto frame = static_cast<size_t>(t);
  const Vector3f world = to_world * move;
  const Vector2f flat(world.x(), world.z());
  const float ahead = flat.dot(ahead_of(legs.direction[frame])), aside = flat.dot(left_of_path(legs.direction[frame]));
  const LegPlace at = leg_place(legs, baseline, t, static_cast<float>(t) + ahead / legs.pace[frame]);
  const Vector2f place = at.place + aside * left_of_path(at.direction);
  return {{place.x(), baseline.root(t).y() + move.y(), place.y()}, at.yaw - legs.yaw[frame]};
}

Vector3f displacement_to(const DetourLegs& legs, const Poses& baseline, int64_t t, float heading, const Vector3f& place,
                         float& ahead) {
  const Eigen::AngleAxisf back(-heading, Vector3f::UnitY());
  if (!on_detour(legs, t)) {
    ahead = 0;
    return back * (place - baseline.root(t));
  }
  const auto frame = static_cast<size_t>(t);
  const Vector2f there(place.x(), place.z());
  const float now = static_cast<float>(t), pace = legs.pace[frame], hint = now + ahead / pace;
  const auto from = static_cast<float>(legs.from[frame]), to = static_cast<float>(legs.to[frame]);
  // How far `place` is beyond the line across the detour at a frame.
  const auto beyond = [&](float at) {
    const LegPlace p = leg_place(legs, baseline, t, at);
    return (there - p.place).dot(ahead_of(p.direction));
  };
  std::optional<float> best;
  const auto offer = [&](float at) {
    if (!best || std::abs(at - hint) < std::abs(*best - hint)) best = at;
  };
  float before = beyond(from);
  if (before <= 0) offer(from + before / pace);
  for (float at = from; at < to; ++at) {
    const float after = beyond(at + 1);
    if ((before > 0) != (after > 0)) {
      float low = at, high = at + 1;
      for (int i = 0; i < kBisections; ++i) {
        const float middle = (low + high) / 2;
        ((beyond(middle) > 0) == (before > 0) ? low : high) = middle;
      }
      offer((low + high) / 2);
    }
    before = after;
  }
  if (before > 0) offer(to + before / pace);
  const float at = best.value_or(now);
  const LegPlace p = leg_place(legs, baseline, t, at);
  ahead = (at - now) * pace;
  const float aside = (there - p.place).dot(left_of_path(p.direction));
  const Vector2f flat = ahead * ahead_of(legs.direction[frame]) + aside * left_of_path(legs.direction[frame]);
  return back * Vector3f(flat.x(), place.y() - baseline.root(t).y(), flat.y());
}

DetourFrames DetourFrames::to_device(torch::Device device) const {
  if (!pace.defined()) return {};
  return {from.to(device), to.to(device), pace.to(device), direction.to(device), yaw.to(device), heading.to(device)};
}

DetourFrames detour_frames(const std::vector<const DetourLegs*>& legs,
                           const std::vector<const std::vector<float>*>& headings) {
  if (std::all_of(legs.begin(), legs.end(), [](const DetourLegs* of) { return of->none(); })) return {};
  DetourFrames out;
  const auto stacked = [&](const auto& values_of) {
    std::vector<Tensor> rows;
    for (size_t b = 0; b < legs.size(); ++b) {
      const auto frames = static_cast<int64_t>(headings[b]->size());
      rows.push_back(legs[b]->none() ? torch::zeros({frames}) : torch::tensor(values_of(*legs[b])).to(torch::kFloat32));
    }
    return torch::stack(rows);
  };
  out.from = stacked([](const DetourLegs& of) { return of.from; });
  out.to = stacked([](const DetourLegs& of) { return of.to; });
  out.pace = stacked([](const DetourLegs& of) { return of.pace; });
  out.direction = stacked([](const DetourLegs& of) { return of.direction; });
  out.yaw = stacked([](const DetourLegs& of) { return of.yaw; });
  std::vector<Tensor> rows;
  rows.reserve(headings.size());
  for (const std::vector<float>* heading : headings) rows.push_back(torch::tensor(*heading));
  out.heading = torch::stack(rows);
  return out;
}

DisplacedRoots displaced(const DetourFrames& f, const Tensor& root, const Tensor& move) {
  if (!f.pace.defined()) return {move, {}};
  const int64_t frames = root.size(1);
  const Tensor on = f.pace > 0, pace = torch::where(on, f.pace, torch::ones_like(f.pace)),
               now = torch::arange(frames, root.options()).expand_as(f.pace);
  const Tensor x = move.select(2, 0), z = move.select(2, 2);
  const Tensor s = torch::sin(f.direction - f.heading), c = torch::cos(f.direction - f.heading);
  const Tensor ahead = x * s + z * c, aside = x * c - z * s;
  const Tensor at = now + ahead / pace, inner = torch::maximum(torch::minimum(at, f.to), f.from),
               turning = torch::maximum(torch::minimum(inner, f.to - 1), f.from);
  const auto between = [&](const Tensor& values, const Tensor& when) {  // (B, T), (B, T)
    const Tensor low = when.detach().floor().clamp(0, frames - 2), i = low.to(torch::kLong);
    const Tensor first = values.gather(1, i);
    return first + (when - low) * (values.gather(1, i + 1) - first);
  };
  const Tensor direction = between(f.direction, turning), rest = (at - inner) * pace;
  const Tensor there_x = between(root.select(2, 0).contiguous(), inner) + rest * torch::sin(direction) +
                         aside * torch::cos(direction) - root.select(2, 0),
               there_z = between(root.select(2, 2).contiguous(), inner) + rest * torch::cos(direction) -
                         aside * torch::sin(direction) - root.select(2, 2);
  const Tensor sine = torch::sin(f.heading), cosine = torch::cos(f.heading);
  return {torch::stack({torch::where(on, there_x * cosine - there_z * sine, x), move.select(2, 1),
                        torch::where(on, there_x * sine + there_z * cosine, z)},
                       2),
          torch::where(on, between(f.yaw, turning) - f.yaw, torch::zeros_like(f.yaw))};
}

}  // namespace inhabit::inbetween
