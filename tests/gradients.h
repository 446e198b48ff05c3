#pragma once
#include <gtest/gtest.h>
#include <torch/torch.h>

#include "largest.h"

/// After a backward pass: a finite gradient, not zero throughout, has come to every parameter.
inline void expect_gradients_everywhere(const torch::nn::Module& module) {
  for (const auto& parameter : module.named_parameters()) {
    const torch::Tensor gradient = parameter.value().grad();
    ASSERT_TRUE(gradient.defined()) << parameter.key();
    EXPECT_GT(largest(gradient), 0) << parameter.key();
    EXPECT_TRUE(gradient.isfinite().all().item<bool>()) << parameter.key();
  }
}
