#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "inhabit/io/files.h"
#include "inhabit/view/page.h"

/// Throws inhabit::Error where a file cannot be written to `path` (no folder, a folder itself, no permission): for
/// verbs that would otherwise learn of it after long work, or with another output written already.
void require_writable(const std::string& path);

/// Adds -o,--out, which takes one file each time it is given: what follows would otherwise be written over where an
/// input is meant.
void add_outputs(CLI::App& verb, std::vector<std::string>& outputs, const std::string& what);

/// For verbs whose result is motion and a page: sets `outputs` to `otherwise` where there is none, and throws
/// inhabit::Error for one that is no .npz, .bvh, .glb, .json or .html, or cannot be written. @param what "a forecast"
void require_motion_outputs(std::vector<std::string>& outputs, const std::string& otherwise, const std::string& what);

/// Whether every output is a page, so that no motion is written.
bool pages_alone(const std::vector<std::string>& outputs);

/// Adds --from, --to, --rate, --out-up and --loop: how a verb's user wants its motion written. @param loop false: the
/// verb has a --loop of its own
void add_writing(CLI::App& verb, inhabit::WriteOptions& writing, bool loop = true);

/// Throws inhabit::Error for what can be refused before the motion is there: where that is asked for and pages alone
/// are written, which show the motion as it is, a format whose up axis is fixed, and times that leave nothing.
void require_motion_written(const inhabit::WriteOptions& writing, const std::vector<std::string>& outputs);

/// Writes every output, an .html by `page`, others by `write_motion`, which says how many motions it wrote, and prints
/// the names of the files. Motion comes first: times beyond its end are refused with nothing written.
void write_outputs(const std::vector<std::string>& outputs, const std::function<inhabit::Page()>& page,
                   const std::function<size_t(const std::string& path)>& write_motion);
