#pragma once
#include <string_view>

namespace inhabit {

/// viewer/dist/live.html as it was when the library was built.
std::string_view live_template();

}  // namespace inhabit
