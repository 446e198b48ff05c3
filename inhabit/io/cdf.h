#pragma once
#include <string>
#include <string_view>

#include "inhabit/io/npz.h"

namespace inhabit {

/// Reads the variables of a NASA CDF file, in which Human3.6M's owners hand out positions (.cdf; not NetCDF, which uses
/// the same extension): versions 2.6, 2.7 and 3, in one file, packed by gzip as a whole, by variable, or not at all,
/// IEEE numbers of either byte order, rows or columns first.
///
/// An array is (records, dimensions...) in C order, whatever order the file has; a variable that is the same in all
/// records is (dimensions...). Times are the numbers that the file has of them. `skipped` names what is no array of
/// numbers: text, times of two numbers, variables with records left out or packed in another way.
///
/// Throws Error(path, ...) for a file that is missing, no CDF file, truncated, damaged, in several files or encodings
/// of other than IEEE numbers. No declared size is believed before it is checked against the file's.
Npz read_cdf(const std::string& path);

/// The same from memory; `subject` names the source in errors.
Npz parse_cdf(std::string_view bytes, const std::string& subject);

}  // namespace inhabit
