#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "inhabit/inbetween/sampler.h"

inline void add_sampler(CLI::App& verb, inhabit::Sampler& sampler) {
  verb.add_option("--sampler", sampler, "ddpm, ddim or dpm (DPM-Solver++ 2M, the default)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, inhabit::Sampler>{
          {"ddpm", inhabit::Sampler::ddpm}, {"ddim", inhabit::Sampler::ddim}, {"dpm", inhabit::Sampler::dpm_solver}}));
}
