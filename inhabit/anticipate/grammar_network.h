#pragma once
#include <torch/torch.h>

#include "inhabit/anticipate/config.h"

namespace inhabit::anticipate {

/// The adversarial generative grammar that ours is compared with (Piergiovanni et al. 2020). A code of the observation
/// is the first non-terminal. In every frame the non-terminal A gives each of R production rules A -> t B a
/// probability; the rule that is drawn says the terminal t, here the change to the next pose, and the next
/// non-terminal B. Rules are drawn by Gumbel-softmax, so that gradients reach all of them. Features (F) are
/// standardised, as in network.h.
struct GrammarNetworkImpl : torch::nn::Module {
  /// Sizes baselines.grammar_hidden (H) and grammar_rules (R).
  explicit GrammarNetworkImpl(const Config& config);

  /// The first non-terminal of an observation: (B, t, F) -> (B, H).
  torch::Tensor start(const torch::Tensor& past);
  /// (B, frames, F) from the first non-terminal (B, H), Gumbel noise (B, frames, R), which draws the rules, and the
  /// last observed pose (B, F).
  torch::Tensor produce(torch::Tensor nonterminal, const torch::Tensor& gumbel, const torch::Tensor& last);

  torch::nn::GRU encoder{nullptr};      ///< F to H
  torch::nn::Sequential choice;         ///< H to H to R, the rules' log-probabilities but for a constant
  torch::nn::Linear next{nullptr};      ///< R to a non-terminal (H)
  torch::nn::Linear terminal{nullptr};  ///< R to a change of the pose (F)
};
TORCH_MODULE(GrammarNetwork);

}  // namespace inhabit::anticipate
