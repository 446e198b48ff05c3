#pragma once
#include "inhabit/interact/reseat.h"
#include "inhabit/interact/reseat_problem.h"

namespace inhabit::interact {

/// How well `out.clip` fits its new chair, `chair`; `before` is the clip it was made of, in `scene`.
ReseatFit measure_fit(const Clip& before, const Scene& scene, const Insides& chair, const ChairStays& stays,
                      const Reseated& out);

}  // namespace inhabit::interact
