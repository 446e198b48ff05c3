#pragma once
#include <string_view>

namespace inhabit {

/// viewer/dist/page.html as it was when the library was built.
std::string_view page_template();

}  // namespace inhabit
