#pragma once
#include <torch/types.h>

namespace inhabit {

/// Mean and deviation (F) that features (..., F) are standardised with.
struct FeatureScale {
  torch::Tensor mean;       ///< (F)
  torch::Tensor deviation;  ///< (F), over 0 where it is divided by

  /// Features to what networks see: mean 0, deviation 1.
  torch::Tensor to_network(const torch::Tensor& features) const { return (features - mean) / deviation; }
  /// The way back.
  torch::Tensor from_network(const torch::Tensor& x) const { return x * deviation + mean; }
  /// The same on another device.
  FeatureScale to(torch::Device device) const { return {mean.to(device), deviation.to(device)}; }
};

/// Mean and deviation of features that come some at a time.
class FeatureStatistics {
 public:
  /// @param features (..., F)
  void add(const torch::Tensor& features) {
    const torch::Tensor rows = features.reshape({-1, features.size(-1)}).to(torch::kFloat64);
    const torch::Tensor sum = rows.sum(0), squares = rows.square().sum(0);
    sum_ = count_ == 0 ? sum : sum_ + sum;
    squares_ = count_ == 0 ? squares : squares_ + squares;
    count_ += rows.size(0);
  }
  /// float32. The deviation is that of all that was added (divided by their number).
  FeatureScale scale() const {
    const torch::Tensor mean = sum_ / count_;
    const torch::Tensor deviation = (squares_ / count_ - mean.square()).clamp_min(0).sqrt();
    return {mean.to(torch::kFloat32), deviation.to(torch::kFloat32)};
  }

 private:
  torch::Tensor sum_, squares_;  // (F) double
  int64_t count_ = 0;
};

}  // namespace inhabit
