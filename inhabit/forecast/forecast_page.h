#pragma once
#include <string>

#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/view/page.h"

namespace inhabit::forecast {

/// The observed second, the prediction and, where known, the truth, with the contact maps on the scene. The page looks
/// at `result`, which must outlive it.
Page forecast_page(const Result& result, const std::string& title);

}  // namespace inhabit::forecast
