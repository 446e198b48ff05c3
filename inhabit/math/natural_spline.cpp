#include "inhabit/math/natural_spline.h"

#include <algorithm>
#include <utility>

namespace inhabit {

NaturalSpline::NaturalSpline(std::vector<double> times, Eigen::MatrixXd values)
    : times_(std::move(times)),
      values_(std::move(values)),
      curvature_(Eigen::MatrixXd::Zero(values_.rows(), values_.cols())) {
  const Eigen::Index knots = values_.rows();
  Eigen::VectorXd upper = Eigen::VectorXd::Zero(knots);
  const auto gap = [&](Eigen::Index k) { return times_[static_cast<size_t>(k) + 1] - times_[static_cast<size_t>(k)]; };
  // Elimination of the tridiagonal system.
  for (Eigen::Index k = 1; k + 1 < knots; ++k) {
    const double before = gap(k - 1), after = gap(k);
    const Eigen::RowVectorXd bend =
        6 * ((values_.row(k + 1) - values_.row(k)) / after - (values_.row(k) - values_.row(k - 1)) / before);
    const double pivot = 2 * (before + after) - before * upper[k - 1];
    upper[k] = after / pivot;
    curvature_.row(k) = (bend - before * curvature_.row(k - 1)) / pivot;
  }
  for (Eigen::Index k = knots - 2; k > 0; --k) curvature_.row(k) -= upper[k] * curvature_.row(k + 1);
}

Eigen::RowVectorXd NaturalSpline::at(double time) const {
  if (time <= times_.front()) return values_.row(0);
  if (time >= times_.back()) return values_.row(values_.rows() - 1);
  const auto k = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin() - 1;
  const double from = times_[static_cast<size_t>(k)], gap = times_[static_cast<size_t>(k) + 1] - from;
  const double u = (time - from) / gap, v = 1 - u;
  return v * values_.row(k) + u * values_.row(k + 1) +
         gap * gap / 6 * ((v * v * v - v) * curvature_.row(k) + (u * u * u - u) * curvature_.row(k + 1));
}

}  // namespace inhabit
