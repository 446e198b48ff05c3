#pragma once
#include <string>

#include "inhabit/body/body_model.h"
#include "inhabit/io/npz.h"

namespace inhabit {

/// The body of an SMPL (24 joints), SMPL-H (52) or SMPL-X (55) .npz model file: `v_template` (V, 3), `shapedirs`
/// (V, 3, B), `posedirs` (V, 3, 9 (J - 1)), `J_regressor` (J, V) dense, `weights` (V, J), `kintree_table` (2, J), `f`
/// (F, 3). Metres and +Y up, as these files are. Expression parameters of SMPL-X (the last 100 of 400, the last 10 of
/// 20) are left out. Limits and capsules of the first 22 joints are the built-in body's.
/// Throws Error(path, ...) for another file, and for pickles (.pkl, or a sparse J_regressor), saying what is needed.
BodyModel read_smpl_model(const std::string& path);
/// As read_smpl_model, from arrays that were read already.
/// @param subject names the source in errors
BodyModel smpl_model_from_npz(const Npz& npz, const std::string& subject);

/// True where the arrays are those of a body model.
bool holds_smpl_model(const Npz& npz);

}  // namespace inhabit
