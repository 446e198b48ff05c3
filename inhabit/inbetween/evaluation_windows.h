#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/sample.h"

namespace inhabit::inbetween {

/// Windows of native data sets that an evaluation fills: at most `count`, spread evenly over those of `split` ("train",
/// "val", "test" or "all"), which follow on each other. Throws Error(first folder, ...) where there is none, and what
/// Data throws.
std::vector<Window> windows_of_data(const std::vector<std::string>& folders, const std::string& split,
                                    const Config& config, int64_t count);

/// The same of recordings on any skeletons, in one scene: on the standard skeleton at the model's rate, recording and
/// scene moved up or down so that the floor under the person is at y = 0.
/// @param recordings each behind its file's name; @param scene where it is empty, a flat floor under each recording is
/// assumed. Throws Error(first file, ...) where none is as long as a window, and what retarget throws.
std::vector<Window> windows_of_recordings(const std::vector<std::pair<std::string, Clip>>& recordings,
                                          const Scene& scene, const Config& config, int64_t count);

}  // namespace inhabit::inbetween
