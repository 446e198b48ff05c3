#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "inhabit/view/page.h"

/// Throws inhabit::Error where a file cannot be written to `path` (no folder, a folder itself, no permission): for
/// verbs that would otherwise learn of it after long work, or with another output written already.
void require_writable(const std::string& path);

/// For verbs whose result is motion and a page: sets `outputs` to `otherwise` where there is none, and throws
/// inhabit::Error for one that is no .npz, .bvh, .glb, .json or .html, or cannot be written. @param what "a forecast"
void require_motion_outputs(std::vector<std::string>& outputs, const std::string& otherwise, const std::string& what);

/// Whether every output is a page, so that no motion is written.
bool pages_alone(const std::vector<std::string>& outputs);

/// Writes every output, an .html by `page`, others by `write_motion`, and prints its name.
void write_outputs(const std::vector<std::string>& outputs, const std::function<inhabit::Page()>& page,
                   const std::function<void(const std::string& path)>& write_motion);

/// Several motions of one person: all of them in one .npz, with `more` arrays (S, ...), else a file each,
/// "out_000.bvh", "out_001.bvh", ... @param scene shown in a .glb, may be null
void write_motions(const std::string& path, const std::vector<inhabit::Clip>& motions,
                   const std::map<std::string, torch::Tensor>& more = {}, const inhabit::Scene* scene = nullptr);
