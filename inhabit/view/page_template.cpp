#include "inhabit/view/page_template.h"

// The assembler takes the file in as it is: half a megabyte of HTML as a string literal compiles slowly.
__asm__(
    ".pushsection .rodata\n"
    ".global inhabit_page_template_begin\n"
    ".global inhabit_page_template_end\n"
    "inhabit_page_template_begin:\n"
    ".incbin \"" INHABIT_PAGE_TEMPLATE
    "\"\n"
    "inhabit_page_template_end:\n"
    ".byte 0\n"
    ".popsection\n");

extern "C" const char inhabit_page_template_begin[];
extern "C" const char inhabit_page_template_end[];

namespace inhabit {

std::string_view page_template() {
  return {inhabit_page_template_begin, static_cast<size_t>(inhabit_page_template_end - inhabit_page_template_begin)};
}

}  // namespace inhabit
