#pragma once
#include <Eigen/Core>
#include <vector>

namespace inhabit {

/// Natural cubic splines through values (K, D) at rising times (K).
class NaturalSpline {
 public:
  /// @param times rising, K > 0 @param values a row for each
  NaturalSpline(std::vector<double> times, Eigen::MatrixXd values);

  /// (D) at a time; before the first and after the last what is there.
  Eigen::RowVectorXd at(double time) const;

 private:
  std::vector<double> times_;
  Eigen::MatrixXd values_, curvature_;  ///< second derivatives at the knots
};

}  // namespace inhabit
