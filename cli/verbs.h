#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "inhabit/io/up_axis.h"

// Each verb lives in a file of its own, adds its subcommand with its options and a callback that calls the library.
// A callback throws inhabit::Error for whatever a user can get wrong.

/// For check(): refuses what is no number over zero, NaN and infinity included (CLI11's own checks let NaN pass).
inline std::string positive_number(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && value < 1e12 ? "" : text + " is not a number over 0";
}

inline std::string not_negative(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value >= 0 && value < 1e12 ? ""
                                                                              : text + " is not a number from 0 on";
}

/// For check(): whole numbers from 0 on, and from 1 on.
inline std::string whole_number(const std::string& text) {
  uint64_t value = 0;
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  return digits && CLI::detail::lexical_cast(text, value) && value <= INT64_MAX ? "" : text + " is no whole number";
}
inline std::string whole_over_zero(const std::string& text) {
  const std::string refusal = whole_number(text);
  return refusal.empty() && text.find_first_not_of('0') == std::string::npos ? "0 is too few" : refusal;
}

/// Frames a second.
inline std::string frame_rate(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value >= 0.1 && value <= 1000 ? "" : text + " is not in [0.1, 1000]";
}

inline std::string not_empty(const std::string& text) { return text.empty() ? "is empty" : ""; }

/// "{a,b}": what completions find the names of an option in.
template <class Value>
std::string names_in_braces(const std::map<std::string, Value>& values) {
  std::string out;
  for (const auto& [name, value] : values) out += (out.empty() ? "{" : ",") + name;
  return out + "}";
}

/// For transform(): one of several names, which stands for a value.
template <class Value>
CLI::Validator one_of(const std::map<std::string, Value>& values) {
  return CLI::Validator(
      [values](std::string& text) {
        const auto found = values.find(text);
        if (found != values.end()) {
          text = CLI::detail::value_string(found->second);
          return std::string();
        }
        std::string names;
        for (const auto& [name, value] : values) names += (names.empty() ? "" : ", ") + name;
        return "is " + text + ", which is none of " + names;
      },
      names_in_braces(values));
}

inline void add_up_axis(CLI::App& verb, inhabit::UpAxis& up, const std::string& option = "--up",
                        const std::string& what = "the file") {
  verb.add_option(option, up, "Up axis of " + what + ", y or z (default: detected)")
      ->transform(one_of<inhabit::UpAxis>({{"y", inhabit::UpAxis::y}, {"z", inhabit::UpAxis::z}}))
      ->option_text("y|z");
}

/// What is said where a verb is missing (`unknown` is empty) or wrong, and where a word or option is left over.
std::string no_verb(const CLI::App& app, const std::string& unknown);
std::string no_option(const CLI::App& verb, const std::string& path, const std::string& unknown);

void add_version(CLI::App& app);
void add_help(CLI::App& app);
void add_completion(CLI::App& app);
void add_examples(CLI::App& app, const std::string& above = "");  ///< to the help of all verbs, once they are there
void add_quiet(CLI::App& app);                                    ///< --quiet to all verbs, once they are there
void add_forecast(CLI::App& app);
void add_inbetween(CLI::App& app);
void add_anticipate(CLI::App& app);
void add_interact(CLI::App& app);
void add_contacts(CLI::App& app);
void add_reconstruct(CLI::App& app);
void add_eval_reconstruct(CLI::App& eval);
void add_refine(CLI::App& app);
void add_train(CLI::App& app);
void add_eval(CLI::App& app);
void add_eval_forecast(CLI::App& verb);   ///< of add_eval
void add_eval_contacts(CLI::App& verb);   ///< of add_eval
void add_eval_inbetween(CLI::App& verb);  ///< of add_eval
void add_eval_detour(CLI::App& verb);     ///< of add_eval
void add_convert(CLI::App& app);
void add_import(CLI::App& app);
void add_intentions(CLI::App& app);
void add_info(CLI::App& app);
void add_view(CLI::App& app);
void add_synth(CLI::App& app);
void add_score(CLI::App& app);
void add_average(CLI::App& app);
void add_serve(CLI::App& app);
void add_stream(CLI::App& app);
