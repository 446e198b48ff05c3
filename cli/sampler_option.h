#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "inhabit/inbetween/sampler.h"

inline void add_sampler(CLI::App& verb, inhabit::inbetween::Sampler& sampler) {
  verb.add_option("--sampler", sampler, "ddpm, ddim or dpm (DPM-Solver++ 2M, the default)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, inhabit::inbetween::Sampler>{{"ddpm", inhabit::inbetween::Sampler::ddpm},
                                                             {"ddim", inhabit::inbetween::Sampler::ddim},
                                                             {"dpm", inhabit::inbetween::Sampler::dpm_solver}}))
      ->option_text("NAME");
}
