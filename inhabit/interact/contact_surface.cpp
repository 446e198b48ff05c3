#include "inhabit/interact/contact_surface.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/error.h"
#include "inhabit/scene/surface_place.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

constexpr double kLean = 0.3;            // metres that leaning adds to an arm's reach
constexpr double kToPalm = 0.09;         // metres from the wrist to the middle of the palm
constexpr double kPelvisOverSeat = 0.1;  // metres

}  // namespace

Vector3d contact_on_surface(const Chair& chair, const SceneQuery& surface, const Skeleton& person, int hand,
                            const Vector3d& point, bool force) {
  const std::string name = hand == 0 ? "left contact" : "right contact";
  if (!point.allFinite()) throw Error(name, "is not finite");
  const SurfacePlace touched = nearest_places(surface, {point}).front();
  if (touched.distance > kOffSurface)
    throw Error(name, fmt::format("is {:.2f} m from {}: in the air", touched.distance, chair.name));
  const torch::Tensor offsets = person.offsets.to(torch::kFloat64).contiguous();
  const auto offset = [&](int64_t j) { return Eigen::Map<const Vector3d>(offsets.data_ptr<double>() + 3 * j); };
  Vector3d shoulder(0, kPelvisOverSeat, 0);
  for (const int64_t joint : {3, 6, 9, 13, 16}) shoulder.y() += offset(joint).y();
  for (const int64_t joint : {13, 16}) shoulder.x() += (hand == 0 ? 1 : -1) * offset(joint).x();
  const double arm = offset(18).norm() + offset(20).norm() + kToPalm;
  const Vector3d from = chair.seat() + chair.frame.linear() * shoulder;
  const double far = (touched.place - from).norm() - arm - kLean;
  if (far > 0 && !force) throw Error(name, fmt::format("is out of the arm's reach of the seat by {:.2f} m", far));
  return touched.place;
}

}  // namespace inhabit::interact
