#include "inhabit/interact/predictor.h"

#include <map>

namespace inhabit::interact {

namespace {

struct Names {
  const char *name, *title;
};

const Names& names_of(Predictor predictor) {
  static const std::map<Predictor, Names> names = {{Predictor::pose, {"pose", "ours"}},
                                                   {Predictor::nsm, {"nsm", "NSM"}},
                                                   {Predictor::nsm_control, {"nsm_control", "NSM + Control"}},
                                                   {Predictor::samp, {"samp", "SAMP"}},
                                                   {Predictor::samp_control, {"samp_control", "SAMP + Control"}}};
  return names.at(predictor);
}

}  // namespace

std::string name_of(Predictor predictor) { return names_of(predictor).name; }
std::string title_of(Predictor predictor) { return names_of(predictor).title; }

torch::Tensor rows_for(Predictor predictor, const InputLayout& layout, const torch::Tensor& input,
                       const torch::Tensor& contacts) {
  if (predictor == Predictor::pose) return input;
  std::vector<torch::Tensor> parts{input.slice(1, 0, layout.goals.end())};
  if (predictor == Predictor::nsm_control || predictor == Predictor::samp_control) parts.push_back(contacts);
  parts.push_back(input.slice(1, layout.ego.first, layout.hands.first));
  parts.push_back(input.slice(1, layout.gating.first));
  return torch::cat(parts, 1);
}

}  // namespace inhabit::interact
