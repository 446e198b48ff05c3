#pragma once
#include "inhabit/inbetween/sampler.h"
#include "verbs.h"

inline void add_sampler(CLI::App& verb, inhabit::inbetween::Sampler& sampler) {
  verb.add_option("--sampler", sampler, "ddpm, ddim or dpm (DPM-Solver++ 2M, the default)")
      ->transform(one_of(inhabit::inbetween::samplers_by_name()))
      ->option_text("NAME");
}
