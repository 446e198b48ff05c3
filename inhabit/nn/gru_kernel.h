#pragma once
#include <cstdint>

namespace inhabit::nn {

/// next = (1 - z) n + z state of a gated recurrent unit, for `hidden` numbers of one row, from the halves of the gates
/// r, z, n, each (3 hidden). The exponentials are polynomials, good to some 2e-7. `next` may be `state`.
void gru_update(int64_t hidden, const float* input_gates, const float* state_gates, const float* state, float* next);

}  // namespace inhabit::nn
