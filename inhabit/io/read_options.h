#pragma once
#include <string>
#include <vector>

#include "inhabit/io/up_axis.h"

namespace inhabit {

struct BodyModel;

/// How a motion file is to be understood where its format leaves it open. Left alone, everything is detected.
struct ClipReadOptions {
  UpAxis up = UpAxis::automatic;  ///< a z-up file is rotated by -90 degrees about x
  double rate = 0;                ///< frames a second; 0: what the file says
  double scale = 0;               ///< metres per unit of length of the file; 0: what the format or the file's size says
  std::string asf;                ///< skeleton of an .amc; empty: the .asf that find_asf finds
  bool level = false;             ///< the floor under the feet is made level (motion/level.h); Human3.6M's exponential
                                  ///< maps, which slope, are levelled anyway
  const BodyModel* body =
      nullptr;  ///< the body of an SMPL-family file that holds no skeleton; the built-in one if null
};

/// What was detected or assumed while reading, one clause each, for people.
using Notes = std::vector<std::string>;

}  // namespace inhabit
