#include "inhabit/anticipate/grammar_network.h"

#include "inhabit/anticipate/network.h"
#include "inhabit/nn/last_state.h"

namespace inhabit::anticipate {

using torch::Tensor;

GrammarNetworkImpl::GrammarNetworkImpl(const Config& config) {
  const int64_t hidden = config.baselines.grammar_hidden, rules = config.baselines.grammar_rules;
  encoder = register_module("encoder", torch::nn::GRU(torch::nn::GRUOptions(kFeatureCount, hidden).batch_first(true)));
  choice = register_module("choice", torch::nn::Sequential(torch::nn::Linear(hidden, hidden), torch::nn::ReLU(),
                                                           torch::nn::Linear(hidden, rules)));
  next = register_module("next", torch::nn::Linear(rules, hidden));
  terminal = register_module("terminal", torch::nn::Linear(rules, kFeatureCount));
}

Tensor GrammarNetworkImpl::start(const Tensor& past) { return nn::last_state(encoder, past); }

Tensor GrammarNetworkImpl::produce(Tensor nonterminal, const Tensor& gumbel, const Tensor& last) {
  std::vector<Tensor> rules;
  for (int64_t t = 0; t < gumbel.size(1); ++t) {
    rules.push_back((choice->forward(nonterminal) + gumbel.select(1, t)).softmax(1));
    nonterminal = next->forward(rules.back());
  }
  return last.unsqueeze(1) + terminal->forward(torch::stack(rules, 1)).cumsum(1);
}

}  // namespace inhabit::anticipate
