#include "inhabit/inbetween/windows.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"

namespace inhabit::inbetween {

std::vector<FillWindow> fill_windows(const std::vector<int64_t>& keys, int64_t frames, int64_t overlap, int64_t least,
                                     int64_t redone, double own, const std::string& name) {
  const auto own_frames = [&](int64_t count) { return std::to_string(std::llround(static_cast<double>(count) * own)); };
  std::vector<FillWindow> out;
  int64_t first = 0, known = 0;
  size_t next = 1;  // the first key frame that is not filled up to
  while (next < keys.size()) {
    const auto beyond = std::upper_bound(keys.begin(), keys.end(), first + frames - 1);
    const auto reached = static_cast<size_t>(beyond - keys.begin());
    if (reached <= next)
      throw Error(name, own_frames(keys[next - 1]) + " and " + own_frames(keys[next]) + " are " +
                            own_frames(keys[next] - keys[next - 1]) + " frames apart; at most " +
                            own_frames(frames - least - redone) + " can be filled in a clip of more than " +
                            own_frames(frames) + " frames");
    out.push_back({first, keys[reached - 1], known});
    if (reached == keys.size()) break;
    known = keys[reached - 1] - redone;
    next = reached;
    first = std::max(known - overlap + 1, keys[next] - frames + 1);
    if (first > known - least + 1) first = known - least + 1;
    first = std::max<int64_t>(first, 0);
  }
  return out;
}

}  // namespace inhabit::inbetween
