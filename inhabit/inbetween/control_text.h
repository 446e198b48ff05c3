#pragma once
#include <string>

#include "inhabit/inbetween/controls.h"

namespace inhabit::inbetween {

// What an animator gives beside the key poses, as text.

/// "JOINT,FROM,TO,X,Y,Z", as in "left_hand,1.2,2,0.4,1.1,-0.3". Throws Error("--contact TEXT", ...) for anything else.
/// @param file whose names of joints may be used, see joint_contact
JointContact parse_contact(const std::string& text, const Skeleton& file = {});

/// "JOINT@SECONDS=X,Y,Z", as in "left_hand@1.5=0.3,0.9,-0.2": a contact of a moment. Throws Error("--target TEXT", ...)
/// for anything else.
JointContact parse_target(const std::string& text, const Skeleton& file = {});

/// "SECONDS,X,Z". Throws Error("--root-path TEXT", ...) for anything else.
PathPoint parse_path_point(const std::string& text);

}  // namespace inhabit::inbetween
