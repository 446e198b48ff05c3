#pragma once
#include <string>

#include "inhabit/reconstruct/reconstruct.h"
#include "inhabit/view/page.h"

namespace inhabit::reconstruct {

/// The reconstruction in its room, the estimate beside it. The page looks at the result's scene, which must outlive it.
/// @param motion what the motion is called in the title
Page reconstruction_page(const Result& result, const std::string& motion);

}  // namespace inhabit::reconstruct
