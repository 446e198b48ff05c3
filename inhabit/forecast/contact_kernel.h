#pragma once
#include <cstdint>

namespace inhabit::forecast {

/// DCT coefficients of the contact of one joint with scene points, fused: no contact map is stored.
/// out[l * stride + n] = sum over f of basis[l * frames + f] exp(-|joint_f - point_n|^2 / (2 sigma^2)).
/// Points farther from the joint in every frame than a contact of 2^-24 (5.77 sigma) get 0, without work.
/// @param points x, y, z arrays of `count` metres; @param joint (frames, 3); @param basis (coefficients, frames).
void contact_coefficients_of_joint(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                                   const float* basis, int64_t coefficients, float sigma, float* out, int64_t stride);

/// For every frame the point with the largest contact value of one joint, the first of equals, from coefficients
/// (coefficients, count) with rows `stride` apart: value[t] = max over n of sum_l basis[t * coefficients + l] c[l][n].
/// @param least only values over it are wanted: in frames without one, value and point are of any point, or minus
/// infinity and 0. Most points cannot have one, and are left out.
void largest_contact_of_joint(const float* c, int64_t stride, int64_t count, const float* basis, int64_t coefficients,
                              int64_t frames, float least, float* value, int64_t* index);

/// For every frame the point closest to the joint, the first of equals. @param joint (frames, 3).
void closest_point_of_joint(const float* const points[3], int64_t count, const float* joint, int64_t frames,
                            float* squared_distance, int64_t* index);

}  // namespace inhabit::forecast
