#pragma once
#include <string_view>

/// Defines `std::string_view name()`, the bytes of the file at `path`, a string literal: the assembler takes it in as
/// it is, for as a literal half a megabyte compiles slowly. For .cpp files, in namespace inhabit; the build must be
/// told that the object depends on the file.
#define INHABIT_EMBEDDED_FILE(name, path)                                                                \
  __asm__(                                                                                               \
      ".pushsection .rodata\n"                                                                           \
      ".balign 16\n"                                                                                     \
      ".global inhabit_" #name                                                                           \
      "_begin\n"                                                                                         \
      ".global inhabit_" #name                                                                           \
      "_end\n"                                                                                           \
      "inhabit_" #name                                                                                   \
      "_begin:\n"                                                                                        \
      ".incbin \"" path                                                                                  \
      "\"\n"                                                                                             \
      "inhabit_" #name                                                                                   \
      "_end:\n"                                                                                          \
      ".byte 0\n"                                                                                        \
      ".popsection\n");                                                                                  \
  extern "C" const char inhabit_##name##_begin[];                                                        \
  extern "C" const char inhabit_##name##_end[];                                                          \
  std::string_view name() {                                                                              \
    return {inhabit_##name##_begin, static_cast<size_t>(inhabit_##name##_end - inhabit_##name##_begin)}; \
  }
