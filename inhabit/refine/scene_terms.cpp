#include "inhabit/refine/scene_terms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "inhabit/body/capsules.h"
#include "inhabit/math/quantile.h"
#include "inhabit/math/smooth_step.h"
#include "inhabit/refine/approach.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.06;  // metres; thin limbs have a ball every radius, or a table's edge gets between
// In lengths of a hand's capsule: how far fingertips reach beyond it; and from its start, where the middle of the thumb
// is (along the hand, below it, ahead of it where the palm looks down) and the radius of its ball.
constexpr double kFingertip = 0.13, kThumbAlong = 0.45, kThumbBelow = 0.15, kThumbAhead = 0.5, kThumb = 0.15;
constexpr double kOpposite = -0.5;  // cosine between where a ball is pushed as it comes in and as it leaves: through
constexpr double kDown = -0.7;      // of a direction: there is the floor
constexpr double kAside = 0.35;     // metres to a side that a ball is moved by at most, so as not to go through
// Metres: as metrics/collision.h has it for the skin, with some to spare.
constexpr double kSupportedGive = 0.03, kGive = 0.005;
constexpr double kRests = 0.15, kPasses = 0.5;  // m/s: what is slower may rest on something, what is faster does not
// m/s of the pelvis over the floor: below the first, arms may rest on things; above the second they do not.
constexpr double kStays = 0.4, kWalks = 0.8;

/// Pelvis, thighs, spine, forearms and hands: what is sat, leaned and rested on.
bool supports(int joint) {
  constexpr std::array<int, 10> kJoints = {0, 1, 2, 3, 6, 9, 18, 19, 20, 21};
  return std::find(kJoints.begin(), kJoints.end(), joint) != kJoints.end();
}

bool is_hand(int joint) { return joint == 20 || joint == 21; }
bool is_arm(int joint) { return is_hand(joint) || joint == 18 || joint == 19; }

/// Where a ball is pushed in a frame: along `normal`, beyond the plane at `height`.
struct BallPush {
  const BallPlace* at;
  bool inside;
  Vector3d normal;
  double height;  // metres
  double give;    // metres that the ball may go in
};

/// Metres that a ball may be in the scene: what sits, leans or rests is pressed in, what passes by is not.
double give_of(const BodyBall& ball, const Poses& poses, int64_t frame, double rate) {
  const auto last = static_cast<int64_t>(poses.size()) - 1;
  const int64_t before = std::max<int64_t>(frame - 1, 0), after = std::min(frame + 1, last);
  if (ball.give <= kGive || before == after || !(rate > 0)) return ball.give;
  const BonesPose &from = poses[static_cast<size_t>(before)], &to = poses[static_cast<size_t>(after)];
  const double seconds = static_cast<double>(after - before) / rate;
  const double speed = (place_of(ball.point, to) - place_of(ball.point, from)).norm() / seconds;
  // An arm that swings back beside somebody who walks stands still in the room.
  const Vector3d root = to.positions[0] - from.positions[0];
  const double walks = is_arm(ball.point.front().joint) ? std::hypot(root.x(), root.z()) / seconds : 0;
  const double passes = std::max((speed - kRests) / (kPasses - kRests), (walks - kStays) / (kWalks - kStays));
  return ball.give + smooth_step(passes) * (kGive - ball.give);
}

/// A ball that comes in on one side of something thin and leaves on the other is pushed back first and on then, and
/// stays inside in between. Such a run of frames (all of one ball) is pushed to the side where it is out soonest.
void push_aside(const SceneQuery& solid, const std::vector<BallPush*>& run) {
  const Vector3d &in = run.front()->normal, &on = run.back()->normal;
  if (in.dot(on) > kOpposite) return;
  std::vector<Vector3d> from;
  for (const BallPush* push : run)
    if (push->inside) from.push_back(push->at->place);
  if (from.empty()) return;
  const Vector3d through = (in - on).normalized(), across = through.unitOrthogonal(),
                 level = std::abs(through.y()) < 0.9 ? Vector3d(Vector3d::UnitY().cross(through).normalized()) : across;
  double least = kAside;
  Vector3d best = Vector3d::Zero();
  std::vector<double> exits;
  for (const Vector3d& side :
       {level, Vector3d(-level), Vector3d(through.cross(level)), Vector3d(level.cross(through))}) {
    if (side.y() < kDown) continue;
    const torch::Tensor lengths =
        solid.cast(point_rows(from), point_rows(std::vector<Vector3d>(from.size(), side)), kAside).distances;
    const double farthest = lengths.max().item<double>();
    if (!(farthest < least)) continue;
    least = farthest;
    best = side;
    exits.assign(lengths.data_ptr<float>(), lengths.data_ptr<float>() + lengths.numel());
  }
  if (exits.empty()) return;
  // Those that are in by their radius alone go beyond the plane of who is inside next.
  size_t next = 0;
  for (BallPush* push : run) {
    push->normal = best;
    push->height = best.dot(from[next]) + exits[next];
    if (push->inside && next + 1 < from.size()) ++next;
  }
}

void around_instead_of_through(const SceneQuery& solid, const std::vector<BodyBall>& balls,
                               std::vector<BallPush>& pushes) {
  std::vector<std::vector<BallPush*>> runs(balls.size());
  for (BallPush& push : pushes) {
    std::vector<BallPush*>& run = runs[push.at->ball];
    const bool is_in = push.inside || push.at->distance < balls[push.at->ball].radius - push.give;
    if (!run.empty() && (!is_in || run.back()->at->frame + 1 != push.at->frame)) {
      push_aside(solid, run);
      run.clear();
    }
    if (is_in) run.push_back(&push);
  }
  for (const std::vector<BallPush*>& run : runs)
    if (!run.empty()) push_aside(solid, run);
}

}  // namespace

std::vector<BodyBall> body_balls(const BodyModel& body, const torch::Tensor& betas) {
  std::vector<BodyBall> out;
  for (const Capsule& c : shaped_capsules(body, betas)) {
    const Vector3d a(c.a[0], c.a[1], c.a[2]);
    Vector3d b(c.b[0], c.b[1], c.b[2]);
    if (is_hand(c.joint)) b += kFingertip * (b - a);
    const double spacing = std::min<double>(kSpacing, c.radius);
    const int count = 1 + static_cast<int>(std::ceil((b - a).norm() / spacing));
    for (int i = 0; i < count; ++i) {
      const double along = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
      out.push_back({{Attachment{c.joint, 1, a + along * (b - a)}},
                     static_cast<double>(c.radius),
                     supports(c.joint) ? kSupportedGive : kGive});
    }
    if (!is_hand(c.joint)) continue;
    const double length = (b - a).norm() / (1 + kFingertip);
    const Vector3d thumb = kThumbAlong * (b - a).normalized() + Vector3d(0, -kThumbBelow, kThumbAhead);
    out.push_back({{Attachment{c.joint, 1, a + length * thumb}}, kThumb * length, kSupportedGive});
  }
  return out;
}

Surroundings::Surroundings(const Scene& scene) {
  Scene solid, floor;
  for (const Mesh& mesh : scene.meshes)
    if (mesh.faces.size(0) > 0) (is_floor(mesh.name) ? floor : solid).meshes.push_back(mesh);
  if (!floor.meshes.empty()) floor_ = std::make_unique<SceneQuery>(floor);
  if (!solid.meshes.empty()) solid_ = std::make_unique<SceneQuery>(solid);
}

Surroundings::~Surroundings() = default;

const Surroundings& SharedSurroundings::around(const torch::Tensor& path) const {
  const std::vector<size_t> turned = rooms_.turned_for(path);
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = made_.find(turned);
  if (known != made_.end()) return known->second;
  return made_.try_emplace(turned, turned_inside_out(scene_, turned)).first->second;
}

std::vector<double> Surroundings::floor_under(const Track& places) const {
  constexpr double kAbove = 0.3, kJustAbove = 0.05, kBelow = 1;
  std::vector<double> out(places.size(), std::nan(""));
  if (floor_ == nullptr && solid_ == nullptr) return out;
  const auto below = [&](double above) {
    torch::Tensor from = point_rows(places);
    from.select(1, 1).add_(above);
    const torch::Tensor down = torch::tensor({0.F, -1.F, 0.F}).expand_as(from).contiguous();
    std::vector<double> heights(places.size(), std::nan(""));
    for (const SceneQuery* query : {floor_.get(), solid_.get()}) {
      if (query == nullptr) continue;
      const RayHits hits = query->cast(from, down, above + kBelow);
      const bool* hit = hits.hit.data_ptr<bool>();
      const float* points = hits.points.data_ptr<float>();
      for (size_t i = 0; i < heights.size(); ++i)
        if (hit[i]) heights[i] = std::fmax(heights[i], points[3 * i + 1]);
    }
    return heights;
  };
  out = below(kAbove);
  std::vector<double> found;
  std::copy_if(out.begin(), out.end(), std::back_inserter(found), [](double h) { return !std::isnan(h); });
  if (found.empty()) return out;
  const double usual = median(std::move(found));
  // Under a table's bar or the base of an office chair a foot is in the air: nothing that it is too low for.
  std::vector<double> nearer;
  for (size_t i = 0; i < out.size(); ++i) {
    if (!(out[i] > places[i].y() + kJustAbove && out[i] > usual + kJustAbove)) continue;
    if (nearer.empty()) nearer = below(kJustAbove);
    if (!std::isnan(nearer[i])) out[i] = nearer[i];
  }
  return out;
}

std::vector<SurfacePlace> Surroundings::surfaces_near(const Track& places) const {
  std::vector<SurfacePlace> out(places.size());
  for (const SceneQuery* query : {floor_.get(), solid_.get()}) {
    if (query == nullptr) continue;
    const std::vector<SurfacePlace> nearest = nearest_places(*query, places);
    for (size_t i = 0; i < places.size(); ++i)
      if (nearest[i].distance < out[i].distance) out[i] = nearest[i];
  }
  return out;
}

std::vector<PlaneTerm> Surroundings::planes(const std::vector<BodyBall>& balls, int first_ball, const Poses& poses,
                                            double rate, double reach, double weight) const {
  std::vector<PlaneTerm> out;
  if (solid_ == nullptr) return out;
  const Approach approach(*solid_, balls, poses, reach);
  std::vector<BallPush> pushes;
  for (size_t k = 0; k < approach.near.size(); ++k) {
    const BallPlace& at = approach.near[k];
    const BodyBall& ball = balls[at.ball];
    const bool is_inside = approach.inside[k] != 0;
    if (!is_inside && at.distance > ball.radius + reach) continue;
    Vector3d normal = (at.place - at.surface) * (is_inside ? -1 : 1);
    if (normal.norm() < 1e-4) normal = at.normal;  // on the surface: the face says where out is, as far as it knows
    if (normal.norm() < 1e-6) continue;
    normal.normalize();
    pushes.push_back({&at, is_inside, normal, normal.dot(at.surface), give_of(ball, poses, at.frame, rate)});
  }
  if (rate > 0) around_instead_of_through(*solid_, balls, pushes);
  for (const BallPush& push : pushes)
    out.push_back({push.at->frame, first_ball + static_cast<int>(push.at->ball), push.normal,
                   push.height + balls[push.at->ball].radius - push.give, weight, false});
  return out;
}

}  // namespace inhabit::refine
