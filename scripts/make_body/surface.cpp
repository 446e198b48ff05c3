#include "surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "inhabit/body/proportions.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

constexpr double kFloor = -kBuiltinPelvisHeight;

/// An elliptic section across an axis: where along it, centre across it, and half-widths. `v` may differ in front of
/// the centre (v+) and behind it (v-).
struct Section {
  double s, u, v, ru, rv_front, rv_back;
};

/// A solid made of sections along one coordinate axis, interpolated without overshoot, closed by ellipsoidal caps.
class Loft {
 public:
  /// @param axis,u,v coordinate indices of the axis and of the section's two directions; @param low_cap,cap lengths of
  /// the caps at the first and last section.
  /// @param power 2 for ellipses, more for boxier sections.
  Loft(int axis, int u, int v, double low_cap, double cap, double power, std::vector<Section> sections)
      : axis_(axis), u_(u), v_(v), low_cap_(low_cap), cap_(cap), power_(power) {
    for (const Section& s : sections) {
      at_.push_back(s.s);
      values_.push_back({s.u, s.v, s.ru, s.rv_front, s.rv_back});
    }
    // Monotone cubic tangents (Fritsch and Carlson): no section is wider than its neighbours in the list.
    tangents_.resize(at_.size(), {});
    for (size_t i = 1; i + 1 < at_.size(); ++i)
      for (size_t c = 0; c < 5; ++c) {
        const double h0 = at_[i] - at_[i - 1], h1 = at_[i + 1] - at_[i];
        const double d0 = (values_[i][c] - values_[i - 1][c]) / h0, d1 = (values_[i + 1][c] - values_[i][c]) / h1;
        if (d0 * d1 > 0) {
          const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
          tangents_[i][c] = (w0 + w1) / (w0 / d0 + w1 / d1);
        }
      }
    double reach = 0;
    for (const auto& x : values_) reach = std::max({reach, x[2], x[3], x[4]});
    low_ = Vector3d::Constant(1e9);
    high_ = -low_;
    for (size_t i = 0; i < at_.size(); ++i) {
      Vector3d centre;
      centre[axis_] = at_[i];
      centre[u_] = values_[i][0];
      centre[v_] = values_[i][1];
      low_ = low_.cwiseMin(centre - Vector3d::Constant(std::max({reach, low_cap_, cap_})));
      high_ = high_.cwiseMax(centre + Vector3d::Constant(std::max({reach, low_cap_, cap_})));
    }
  }

  double distance(const Vector3d& p) const {
    const double to_box = (low_ - p).cwiseMax(p - high_).cwiseMax(0.0).norm();
    if (to_box > 0.12) return to_box;  // too far to shape any union
    const double s = std::clamp(p[axis_], at_.front(), at_.back());
    const size_t i = std::min<size_t>(std::upper_bound(at_.begin(), at_.end(), s) - at_.begin(), at_.size() - 1) - 1;
    const double h = at_[i + 1] - at_[i], t = (s - at_[i]) / h;
    const double b0 = (1 + 2 * t) * (1 - t) * (1 - t), b1 = t * t * (3 - 2 * t);
    const double c0 = h * t * (1 - t) * (1 - t), c1 = h * t * t * (t - 1);
    std::array<double, 5> x;
    for (size_t c = 0; c < 5; ++c)
      x[c] = b0 * values_[i][c] + b1 * values_[i + 1][c] + c0 * tangents_[i][c] + c1 * tangents_[i + 1][c];
    const double dv = p[v_] - x[1];
    const std::array<double, 3> r = {x[2], dv > 0 ? x[3] : x[4], p[axis_] < s ? low_cap_ : cap_};
    const std::array<double, 3> d = {std::abs(p[u_] - x[0]), std::abs(dv), std::abs(p[axis_] - s)};
    // First-order distance to the level set k = 1 of the p-norm of d / r: (k - 1) / |grad k|.
    double sum = 0;
    std::array<double, 3> slope;
    for (int a = 0; a < 3; ++a) {
      const double q = d[a] / r[a], power = std::pow(q, power_ - 1);
      sum += power * q;
      slope[a] = power / r[a];
    }
    if (sum < 1e-12) return -std::min(r[0], r[1]);
    const double k = std::pow(sum, 1 / power_), scale = std::pow(k, 1 - power_);
    const double gradient = scale * std::sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
    return (k - 1) / gradient;
  }

 private:
  int axis_, u_, v_;
  double low_cap_, cap_, power_;
  std::vector<double> at_;
  std::vector<std::array<double, 5>> values_, tangents_;
  Vector3d low_, high_;
};

double ellipsoid(const Vector3d& p, const Vector3d& centre, const Vector3d& radii) {
  const Vector3d d = (p - centre).cwiseQuotient(radii);
  const double k0 = d.norm(), k1 = d.cwiseQuotient(radii).norm();
  return k1 < 1e-9 ? -radii.minCoeff() : k0 * (k0 - 1) / k1;
}

/// A segment swept by a sphere whose radius goes from ra to rb.
double tapered(const Vector3d& p, const Vector3d& a, const Vector3d& b, double ra, double rb) {
  const Vector3d ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - t * ab).norm() - (ra + t * (rb - ra));
}

/// Union with a fillet of about k (polynomial smooth minimum).
double join(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}

double carve(double a, double b, double k) { return -join(-a, b, k); }

// Sections, metres in the pelvis frame, of the left half where there are two. Columns: place along the axis; centre
// across it (u, v); half-width along u; along v in front of and behind the centre.
const Loft& trunk() {
  static const Loft loft(1, 0, 2, 0.045, 0.045, 2.35,
                         {{-0.105, 0, -0.012, 0.130, 0.080, 0.092},
                          {-0.060, 0, -0.014, 0.160, 0.100, 0.106},
                          {-0.010, 0, -0.014, 0.160, 0.106, 0.104},
                          {0.045, 0, -0.010, 0.150, 0.110, 0.090},
                          {0.120, 0, -0.004, 0.133, 0.102, 0.088},
                          {0.185, 0, 0.000, 0.135, 0.102, 0.100},
                          {0.250, 0, 0.000, 0.147, 0.101, 0.113},
                          {0.310, 0, -0.004, 0.158, 0.099, 0.118},
                          {0.360, 0, -0.012, 0.163, 0.094, 0.112},
                          {0.405, 0, -0.024, 0.150, 0.076, 0.092},
                          {0.440, 0, -0.034, 0.105, 0.058, 0.066}});
  return loft;
}

const Loft& neck() {
  static const Loft loft(1, 0, 2, 0.030, 0.030, 2.0,
                         {{0.420, 0, -0.040, 0.070, 0.055, 0.060},
                          {0.470, 0, -0.034, 0.058, 0.054, 0.056},
                          {0.520, 0, -0.024, 0.054, 0.055, 0.056},
                          {0.590, 0, -0.012, 0.054, 0.055, 0.060}});
  return loft;
}

const Loft& head() {
  static const Loft loft(1, 0, 2, 0.020, 0.072, 2.2,
                         {{0.553, 0, 0.058, 0.032, 0.034, 0.045},
                          {0.575, 0, 0.045, 0.049, 0.051, 0.062},
                          {0.600, 0, 0.030, 0.060, 0.068, 0.088},
                          {0.635, 0, 0.014, 0.068, 0.088, 0.100},
                          {0.665, 0, 0.006, 0.074, 0.096, 0.105},
                          {0.692, 0, 0.002, 0.075, 0.096, 0.106}});
  return loft;
}

const Loft& arm_loft() {
  // Along x: u is height, v depth.
  static const Loft loft(0, 1, 2, 0.020, 0.020, 2.0,
                         {{0.110, 0.425, -0.036, 0.052, 0.060, 0.060},
                          {0.150, 0.436, -0.036, 0.055, 0.062, 0.062},
                          {0.195, 0.438, -0.037, 0.053, 0.060, 0.060},
                          {0.245, 0.437, -0.038, 0.048, 0.053, 0.053},
                          {0.310, 0.437, -0.039, 0.045, 0.048, 0.047},
                          {0.380, 0.437, -0.042, 0.042, 0.045, 0.045},
                          {0.435, 0.437, -0.045, 0.037, 0.041, 0.040},
                          {0.467, 0.436, -0.046, 0.035, 0.040, 0.039},
                          {0.515, 0.437, -0.045, 0.036, 0.043, 0.041},
                          {0.565, 0.438, -0.045, 0.034, 0.041, 0.039},
                          {0.640, 0.440, -0.044, 0.027, 0.033, 0.032},
                          {0.705, 0.441, -0.044, 0.021, 0.028, 0.027}});
  return loft;
}

const Loft& hand() {
  static const Loft loft(0, 1, 2, 0.016, 0.016, 2.3,
                         {{0.700, 0.441, -0.044, 0.020, 0.027, 0.027},
                          {0.735, 0.441, -0.043, 0.019, 0.034, 0.034},
                          {0.775, 0.440, -0.042, 0.018, 0.041, 0.041},
                          {0.810, 0.437, -0.042, 0.0165, 0.042, 0.042},
                          {0.845, 0.431, -0.043, 0.0140, 0.040, 0.038},
                          {0.875, 0.423, -0.045, 0.0120, 0.035, 0.033},
                          {0.890, 0.418, -0.046, 0.0110, 0.029, 0.027}});
  return loft;
}

const Loft& leg_loft() {
  static const Loft loft(1, 0, 2, 0.030, 0.030, 2.0,
                         {{-0.900, 0.100, -0.034, 0.032, 0.036, 0.036},
                          {-0.875, 0.100, -0.034, 0.034, 0.037, 0.037},
                          {-0.830, 0.100, -0.032, 0.032, 0.034, 0.036},
                          {-0.750, 0.100, -0.022, 0.039, 0.037, 0.045},
                          {-0.670, 0.100, -0.010, 0.048, 0.041, 0.060},
                          {-0.600, 0.099, -0.004, 0.054, 0.045, 0.067},
                          {-0.540, 0.098, 0.000, 0.052, 0.047, 0.060},
                          {-0.490, 0.097, 0.004, 0.050, 0.053, 0.052},
                          {-0.455, 0.096, 0.006, 0.052, 0.057, 0.050},
                          {-0.400, 0.096, 0.005, 0.058, 0.062, 0.057},
                          {-0.320, 0.095, 0.004, 0.067, 0.074, 0.068},
                          {-0.230, 0.093, 0.002, 0.077, 0.084, 0.080},
                          {-0.150, 0.090, 0.000, 0.082, 0.090, 0.090},
                          {-0.080, 0.086, -0.004, 0.076, 0.086, 0.092},
                          {-0.030, 0.080, -0.008, 0.066, 0.078, 0.084}});
  return loft;
}

const Loft& foot() {
  // Along z: u is height, v sideways (front = outwards). The sections reach below the floor; a plane cuts the sole
  // flat.
  static const Loft loft(2, 1, 0, 0.022, 0.022, 2.4,
                         {{-0.066, kFloor + 0.026, 0.101, 0.032, 0.027, 0.027},
                          {-0.035, kFloor + 0.032, 0.101, 0.040, 0.033, 0.033},
                          {0.010, kFloor + 0.030, 0.103, 0.042, 0.034, 0.033},
                          {0.050, kFloor + 0.024, 0.108, 0.036, 0.039, 0.036},
                          {0.095, kFloor + 0.016, 0.114, 0.026, 0.045, 0.043},
                          {0.130, kFloor + 0.013, 0.115, 0.023, 0.042, 0.043},
                          {0.152, kFloor + 0.011, 0.112, 0.020, 0.034, 0.037}});
  return loft;
}

}  // namespace

double builtin_surface_distance(const Vector3d& point) {
  const Vector3d p(std::abs(point.x()), point.y(), point.z());
  const Vector3d q(-p.x(), p.y(), p.z());  // the other side's parts, where both sides meet

  double d = trunk().distance(p);
  d = join(d, ellipsoid(p, {0.070, 0.326, 0.056}, {0.070, 0.056, 0.036}), 0.05);   // chest
  d = join(d, ellipsoid(p, {0.080, 0.345, -0.098}, {0.060, 0.075, 0.030}), 0.05);  // shoulder blade
  d = join(d, neck().distance(p), 0.05);
  d = join(d, tapered(p, {0.040, 0.478, -0.044}, {0.150, 0.446, -0.040}, 0.036, 0.036), 0.05);  // trapezius
  d = join(d, arm_loft().distance(p), 0.045);

  double legs = join(leg_loft().distance(p), leg_loft().distance(q), 0.03);
  legs = join(legs, ellipsoid(p, {0.072, -0.078, -0.074}, {0.076, 0.076, 0.062}), 0.04);  // buttock
  d = join(d, legs, 0.05);

  const double sole = kFloor - p.y();
  double foot_distance =
      join(foot().distance(p), ellipsoid(p, {0.100, kFloor + 0.030, -0.052}, {0.031, 0.042, 0.038}), 0.03);
  foot_distance = std::max(foot_distance, sole);
  d = join(d, foot_distance, 0.04);
  d = -join(-d, -sole, 0.012);  // rounded edge of the sole

  double skull = head().distance(p);
  skull = join(skull, tapered(p, {0, 0.648, 0.100}, {0, 0.612, 0.110}, 0.009, 0.013), 0.02);  // nose
  skull = carve(skull, ellipsoid(p, {0.033, 0.648, 0.106}, {0.020, 0.012, 0.016}), 0.02);     // eyes
  skull = join(skull, ellipsoid(p, {0, 0.582, 0.092}, {0.022, 0.010, 0.012}), 0.015);         // mouth
  skull = join(skull, ellipsoid(p, {0.074, 0.632, -0.004}, {0.011, 0.031, 0.019}), 0.012);    // ear
  d = join(d, skull, 0.025);

  double palm = hand().distance(p);
  palm = join(palm, tapered(p, {0.742, 0.434, -0.020}, {0.778, 0.427, 0.016}, 0.017, 0.0135), 0.02);
  palm = join(palm, tapered(p, {0.778, 0.427, 0.016}, {0.815, 0.423, 0.028}, 0.0135, 0.0105), 0.01);
  return join(d, palm, 0.02);
}

}  // namespace inhabit
