#pragma once
#include <cstdint>

namespace inhabit::nn {

/// y[i] = mish(x[i]) = x tanh(log(1 + exp(x))), i < count, good to some 4e-7.
void mish_forward(const float* x, int64_t count, float* y);

/// out[i] = mish'(x[i]) gradient[i].
void mish_backward(const float* x, const float* gradient, int64_t count, float* out);

}  // namespace inhabit::nn
