#include "inhabit/math/rotation.h"

#include "inhabit/error.h"

namespace inhabit {
namespace {

using torch::Tensor;

void require_last(const Tensor& t, int64_t size, const char* what) {
  if (!t.defined() || t.dim() < 1 || t.size(-1) != size)
    throw Error(what, "expected a last dimension of " + std::to_string(size));
}

void require_matrix(const Tensor& t) {
  if (!t.defined() || t.dim() < 2 || t.size(-1) != 3 || t.size(-2) != 3)
    throw Error("rotation matrix", "expected (..., 3, 3)");
}

/// v / |v|, zero for a zero vector, with a finite gradient everywhere.
Tensor unit(const Tensor& v) { return v / (v * v).sum(-1, true).clamp_min(1e-24).sqrt(); }

}  // namespace

Tensor axis_angle_to_matrix(const Tensor& axis_angle) {
  require_last(axis_angle, 3, "axis-angle");
  // Rodrigues: R = I + a K + b K^2 with a = sin(t)/t, b = (1 - cos(t))/t^2. Both are smooth in t^2, so near zero a
  // series in t^2 stands in; the discarded branch is fed a harmless value because its gradient is multiplied by zero.
  const Tensor t2 = (axis_angle * axis_angle).sum(-1);
  const Tensor small = t2 < 1e-4;
  const Tensor t = torch::where(small, torch::ones_like(t2), t2).sqrt();
  const Tensor half = (t * 0.5).sin() / t;
  const Tensor a = torch::where(small, 1 - t2 / 6 + t2 * t2 / 120, t.sin() / t);
  const Tensor b = torch::where(small, 0.5 - t2 / 24 + t2 * t2 / 720, 2 * half * half);
  const auto v = axis_angle.unbind(-1);
  const Tensor &x = v[0], &y = v[1], &z = v[2];
  const Tensor bx = b * x, by = b * y, bz = b * z, ax = a * x, ay = a * y, az = a * z;
  return torch::stack({1 - by * y - bz * z, bx * y - az, bx * z + ay,  //
                       bx * y + az, 1 - bx * x - bz * z, by * z - ax,  //
                       bx * z - ay, by * z + ax, 1 - bx * x - by * y},
                      -1)
      .unflatten(-1, {3, 3});
}

Tensor matrix_to_axis_angle(const Tensor& matrix) {
  const Tensor q = matrix_to_quaternion(matrix);  // w >= 0, so the angle is in [0, pi]
  const Tensor w = q.select(-1, 0);
  const Tensor v = q.narrow(-1, 1, 3);
  const Tensor s2 = (v * v).sum(-1);
  const Tensor small = s2 < 1e-6;
  const Tensor s = torch::where(small, torch::ones_like(s2), s2).sqrt();
  const Tensor safe_w = torch::where(small, w, torch::ones_like(w));
  // angle / sin(angle / 2); near zero 2 atan(s / w) / s as a series in (s / w)^2.
  const Tensor ratio2 = s2 / (safe_w * safe_w);
  const Tensor scale = torch::where(small, 2 / safe_w * (1 - ratio2 / 3), 2 * torch::atan2(s, w) / s);
  return v * scale.unsqueeze(-1);
}

Tensor quaternion_to_matrix(const Tensor& quaternion) {
  require_last(quaternion, 4, "quaternion");
  const auto q = unit(quaternion).unbind(-1);
  const Tensor &w = q[0], &x = q[1], &y = q[2], &z = q[3];
  return torch::stack({1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
                       2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),  //
                       2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
                      -1)
      .unflatten(-1, {3, 3});
}

Tensor matrix_to_quaternion(const Tensor& matrix) {
  require_matrix(matrix);
  const auto m = matrix.flatten(-2).unbind(-1);
  const Tensor &xx = m[0], &xy = m[1], &xz = m[2], &yx = m[3], &yy = m[4], &yz = m[5], &zx = m[6], &zy = m[7],
               &zz = m[8];
  // Each row is 4 q_i q, for i = w, x, y, z. The row of the largest q_i has length >= 2: dividing it by its length is
  // well conditioned and needs no square root of something that may be zero.
  const Tensor rows = torch::stack({torch::stack({1 + xx + yy + zz, zy - yz, xz - zx, yx - xy}, -1),
                                    torch::stack({zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx}, -1),
                                    torch::stack({xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy}, -1),
                                    torch::stack({yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz}, -1)},
                                   -2);
  const Tensor best = rows.detach().diagonal(0, -2, -1).argmax(-1);
  std::vector<int64_t> shape = best.sizes().vec();
  shape.insert(shape.end(), {1, 4});
  const Tensor row = rows.gather(-2, best.unsqueeze(-1).unsqueeze(-1).expand(shape)).squeeze(-2);
  const Tensor q = unit(row);
  const Tensor negative = q.detach().narrow(-1, 0, 1) < 0;
  return torch::where(negative, -q, q);
}

Tensor rotation6d_to_matrix(const Tensor& rotation6d) {
  require_last(rotation6d, 6, "6D rotation");
  const Tensor x = unit(rotation6d.narrow(-1, 0, 3));
  const Tensor second = rotation6d.narrow(-1, 3, 3);
  const Tensor y = unit(second - (x * second).sum(-1, true) * x);
  return torch::stack({x, y, torch::cross(x, y, -1)}, -1);
}

Tensor matrix_to_rotation6d(const Tensor& matrix) {
  require_matrix(matrix);
  return torch::cat({matrix.select(-1, 0), matrix.select(-1, 1)}, -1);
}

Tensor yaw_matrix(const Tensor& yaw) {
  const Tensor c = yaw.cos(), s = yaw.sin(), zero = torch::zeros_like(c), one = torch::ones_like(c);
  return torch::stack({c, zero, s, zero, one, zero, -s, zero, c}, -1).unflatten(-1, {3, 3});
}

Tensor yaw_matrix(double yaw) { return yaw_matrix(torch::tensor(yaw, torch::kDouble)).to(torch::kFloat); }

Tensor yaw_of_left(const Tensor& left) {
  require_last(left, 3, "direction");
  const Tensor x = left.select(-1, 0), z = left.select(-1, 2);
  return torch::where(torch::hypot(x, z) > 1e-9, torch::atan2(-z, x), torch::zeros_like(x));  // left x up is forwards
}

Tensor slerp(const Tensor& from, const Tensor& to, const Tensor& u) {
  require_last(from, 4, "quaternion");
  require_last(to, 4, "quaternion");
  const Tensor a = unit(from);
  Tensor b = unit(to);
  const Tensor long_arc = (a * b).sum(-1, true).detach() < 0;
  b = torch::where(long_arc, -b, b);
  // The angle by atan2 of chord lengths keeps its precision at both ends, unlike acos of the dot product.
  const Tensor difference = (b - a), sum = (b + a);
  const Tensor d2 = (difference * difference).sum(-1, true), s2 = (sum * sum).sum(-1, true);
  const Tensor small = d2 < 1e-8;
  const Tensor chord = torch::where(small, torch::ones_like(d2), d2).sqrt();
  const Tensor angle = 2 * torch::atan2(chord, s2.sqrt());
  const Tensor v = u.unsqueeze(-1);
  const Tensor sine = angle.sin();
  const Tensor wa = torch::where(small, 1 - v, ((1 - v) * angle).sin() / sine);
  const Tensor wb = torch::where(small, v + torch::zeros_like(angle), (v * angle).sin() / sine);
  return unit(wa * a + wb * b);
}

}  // namespace inhabit
