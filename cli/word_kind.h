#pragma once
#include <CLI/CLI.hpp>

#include "inhabit/metrics/motion_words.h"
#include "verbs.h"

/// Adds --words: how NDMS makes words of motion.
inline void add_word_kind(CLI::App& verb, inhabit::WordKind& words) {
  verb.add_option("--words", words,
                  "NDMS over poses that know neither place nor heading, as the authors evaluate (poses), the same with "
                  "spine, neck and head, as DLow's 17 joints have them (dlow), or as the authors' package has it: the "
                  "motion in the world, each word moved by its first frame")
      ->transform(one_of(inhabit::word_kinds_by_name()))
      ->option_text("poses|dlow|package");
}
