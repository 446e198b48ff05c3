#include "inhabit/anticipate/anticipation_page.h"

#include "inhabit/view/futures_page.h"

namespace inhabit::anticipate {

Page anticipation_page(const Result& result, const std::string& title) {
  std::vector<torch::Tensor> labels;
  for (int64_t s = 0; result.labels.defined() && s < result.labels.size(0); ++s) labels.push_back(result.labels[s]);
  Page page = futures_page(result.past, result.futures, labels);
  page.title = title;
  if (!result.scene.empty()) page.scene = &result.scene;
  return page;
}

}  // namespace inhabit::anticipate
