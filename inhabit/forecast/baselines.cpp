#include "inhabit/forecast/baselines.h"

namespace inhabit::forecast {

using torch::Tensor;

std::vector<Baseline> baselines_of(const Networks& networks) {
  const int64_t future = networks.config.future;
  std::vector<Baseline> out;
  if (auto ltd = networks.ltd; !ltd.is_empty())
    out.push_back({"ltd", "LTD", ltd.ptr(), [=](const Tensor& past, const Tensor&) mutable {
                     return ltd->forward(past.flatten(2)).unflatten(2, {past.size(2), 3});
                   }});
  if (auto hisrep = networks.hisrep; !hisrep.is_empty())
    out.push_back({"hisrep", "HisRep", hisrep.ptr(), [=](const Tensor& past, const Tensor&) mutable {
                     return hisrep->continued(past.flatten(2), future).unflatten(2, {past.size(2), 3});
                   }});
  if (auto dmgnn = networks.dmgnn; !dmgnn.is_empty())
    out.push_back({"dmgnn", "DMGNN", dmgnn.ptr(),
                   [=](const Tensor& past, const Tensor&) mutable { return dmgnn->forward(past); }});
  if (auto slt = networks.slt; !slt.is_empty())
    out.push_back({"slt", "SLT*", slt.ptr(), [=](const Tensor& past, const Tensor& points) mutable {
                     return slt->forward(past, points).joints();
                   }});
  return out;
}

}  // namespace inhabit::forecast
