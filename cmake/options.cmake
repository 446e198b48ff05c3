# Warnings, sanitizers and coverage: build-time only, nothing here reaches a consumer.
add_library(inhabit_options INTERFACE)
target_compile_options(inhabit_options INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)  # GCC 12 finds these, falsely, in "text" + std::to_string(n)
  target_compile_options(inhabit_options INTERFACE -Wno-stringop-overflow -Wno-array-bounds -Wno-restrict)
endif()
if(INHABIT_UNITY)  # an unnamed namespace of an included .cpp looks like one of a header
  target_compile_options(inhabit_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(INHABIT_WERROR)
  target_compile_options(inhabit_options INTERFACE -Werror)
endif()
if(INHABIT_SANITIZE)
  # GCC says itself that sanitizers make it find these where there are none: LibTorch's optionals here.
  target_compile_options(inhabit_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_compile_options(inhabit_options INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(inhabit_options INTERFACE -fsanitize=address,undefined)
endif()
if(INHABIT_BUILD_FUZZERS)
  # clang 14 with libstdc++ 12 in C++20 wants IValue whole before LibTorch 1.13's other headers name it.
  target_compile_options(inhabit_options INTERFACE "SHELL:-include ATen/core/ivalue.h" -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -g1)
  target_link_options(inhabit_options INTERFACE -fsanitize=address,undefined)
endif()
if(INHABIT_COVERAGE)
  target_compile_options(inhabit_options INTERFACE --coverage -fprofile-update=atomic)
  target_link_options(inhabit_options INTERFACE --coverage)
endif()
# What calls the library and does little itself (the command, bindings, examples, tests) compiles in half the time at
# this level. GCC goes by the level of the precompiled header, whatever the source is given: they share that of
# inhabit_cli, or of the tests' main.
add_library(inhabit_caller_options INTERFACE)
target_link_libraries(inhabit_caller_options INTERFACE inhabit_options)
target_compile_options(inhabit_caller_options INTERFACE $<$<CONFIG:Release>:-Og>)
