#pragma once
#include <string>
#include <string_view>

#include "inhabit/view/cards_page.h"

namespace inhabit {

/// A training's log (MODEL.log.jsonl, train/loop.h) as curves over steps: validation, each loss and the learning rate,
/// a curve for each stage. A last line without its end, of a training that is at work, is left out.
/// Throws Error(path, ...) where a line is no JSON object with a step, or no line has a number to show.
PageChart read_training_log(const std::string& path);
/// As read_training_log, from the log's text.
/// @param path names it in errors
PageChart parse_training_log(std::string_view text, const std::string& path);

/// A table that `inhabit eval ... --json` wrote (metrics/score_table.h), rows of names and numbers, as curves over the
/// horizons where a row's numbers are named after times ("0.5s"), and as bars elsewhere. What "mean" and "interval95"
/// hold is a number and half its interval. Or what `inhabit score ... --json` wrote: bars of the numbers of all motions
/// and of each file, curves over seconds of what goes by time. Throws Error(path, ...) where it holds neither.
PageChart read_score_chart(const std::string& path);
/// As read_score_chart, from the table's text.
/// @param path names it in errors
PageChart parse_score_chart(std::string_view text, const std::string& path);

/// Whether a .json holds rows or scores as read_score_chart reads them (rather than, say, a motion).
/// Throws Error(path, ...) where it is no JSON.
bool is_score_table(const std::string& path);

}  // namespace inhabit
