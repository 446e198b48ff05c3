#pragma once

namespace inhabit {

/// Between the values b and c of four in even steps, at u in [0, 1] from b: the cubic Hermite curve with central
/// differences, exact for parabolas. Of vectors and numbers, or of tensors.
template <class Value, class Part>
Value catmull_rom(const Value& a, const Value& b, const Value& c, const Value& d, const Part& u) {
  return b + (u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)))) / 2;
}

}  // namespace inhabit
