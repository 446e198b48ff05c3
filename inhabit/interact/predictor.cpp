#include "inhabit/interact/predictor.h"

namespace inhabit::interact {

std::string name_of(Predictor predictor) {
  switch (predictor) {
    case Predictor::nsm:
      return "nsm";
    case Predictor::nsm_control:
      return "nsm_control";
    case Predictor::samp:
      return "samp";
    case Predictor::samp_control:
      return "samp_control";
    case Predictor::pose:
      break;
  }
  return "pose";
}

std::string title_of(Predictor predictor) {
  switch (predictor) {
    case Predictor::nsm:
      return "NSM";
    case Predictor::nsm_control:
      return "NSM + Control";
    case Predictor::samp:
      return "SAMP";
    case Predictor::samp_control:
      return "SAMP + Control";
    case Predictor::pose:
      break;
  }
  return "ours";
}

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
