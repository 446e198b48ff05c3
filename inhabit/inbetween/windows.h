#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace inhabit::inbetween {

/// A stretch of a clip that one run of the sampler fills.
struct FillWindow {
  int64_t first;  ///< frame of the clip that it begins with
  int64_t last;   ///< frame of the clip that it ends with, included; a key frame
  int64_t known;  ///< frames up to this one are known: the first key frame, or what the window before filled
};

/// Windows of at most `frames` frames that fill a clip between `keys` (in order, the first being frame 0). Each
/// continues from the last `overlap` frames of the one before, from fewer where the next key frame would be out of
/// reach, and from at least `least`. The last `redone` frames of a window are filled again by the next. Throws
/// Error(name, ...) naming two key frames that are too far apart.
/// @param own frames of the file that keys came from for one of these: what errors count in
/// @param name what errors call the key frames
std::vector<FillWindow> fill_windows(const std::vector<int64_t>& keys, int64_t frames, int64_t overlap, int64_t least,
                                     int64_t redone, double own = 1, const std::string& name = "keys");

}  // namespace inhabit::inbetween
