#pragma once

namespace inhabit {

/// Which axis of a file points up: left automatic, it is detected.
enum class UpAxis { automatic, y, z };

}  // namespace inhabit
