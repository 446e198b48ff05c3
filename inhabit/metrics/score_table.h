#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace inhabit {

/// The mean over runs with different seeds, and half of its 95 % confidence interval by Student's t; 0 for one run. NaN
/// where there is no value.
struct Estimate {
  double mean = 0;      ///< in the unit of the runs
  double interval = 0;  ///< half of it
};
/// Mean and interval of one number a run; NaN for both where there are none.
Estimate estimate(const std::vector<double>& runs);

/// Scores of methods as they are printed and written as JSON: what every `inhabit eval` ends in.
struct ScoreTable {
  /// One number of every row.
  struct Column {
    std::string group;  ///< title above columns that belong together; empty: none
    std::string title;  ///< above the column, with its unit
    std::string key;    ///< in the JSON; "path_error/0.5s" is the key 0.5s of the object path_error
    int decimals = 1;   ///< in the text
  };
  /// One method, on one choice of data.
  struct Row {
    std::vector<std::string> labels;  ///< one for each of `labels`
    std::vector<Estimate> cells;      ///< one for each column
  };
  std::vector<std::string> labels;  ///< what tells rows apart: "method"; also their keys in the JSON
  std::vector<Column> columns;      ///< from left to right
  std::vector<Row> rows;            ///< from top to bottom
  std::vector<std::string> notes;   ///< lines under the text
};

/// The table as text: labels on the left, numbers on the right, "-" for NaN, groups apart by bars.
/// @param intervals whether "+- interval" follows each mean of a row that has one.
std::string text_of(const ScoreTable& table, bool intervals = false);

/// The rows as JSON objects: labels, then numbers, null for NaN. @param intervals each number is an object of "mean"
/// and "interval95".
nlohmann::ordered_json rows_json(const ScoreTable& table, bool intervals = false);

}  // namespace inhabit
