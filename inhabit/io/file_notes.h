#pragma once
#include <string>
#include <utility>

#include "inhabit/io/read_options.h"

namespace inhabit {

/// Adds what was noted of a file to `notes`, the file's name before each as errors have it: "walk.bvh: ...".
inline void add_notes(Notes& notes, Notes of_file, const std::string& file) {
  for (std::string& note : of_file) notes.push_back(std::move(note.insert(0, file + ": ")));
}

}  // namespace inhabit
