// Protects the promise that a library that breaks on a file does not take the program with it.
#include "inhabit/io/in_child.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <thread>

#include "inhabit/interruption.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

TEST(InChild, GivesBackWhatTheWorkReturns) {
  const std::string large(5'000'000, 'x');
  EXPECT_EQ(in_child("file", [&] { return large + '\0' + "y"; }), large + '\0' + "y");
  EXPECT_EQ(in_child("file", [] { return std::string(); }), "");
}

TEST(InChild, ErrorsOfTheWorkAreItsOwn) {
  EXPECT_EQ(refusal_of([] { in_child("file", []() -> std::string { throw Error("a.fbx", "is empty"); }); }),
            "a.fbx: is empty");
  EXPECT_EQ(refusal_of([] { in_child("file", []() -> std::string { throw std::runtime_error("odd"); }); }),
            "file: odd");
  EXPECT_THAT(refusal_of([] { in_child("file", []() -> std::string { throw std::bad_alloc(); }); }),
              HasSubstr("more memory"));
}

TEST(InChild, ItsEndIsNoEndOfOurs) {
  const std::string broken = "file: is damaged, or of a kind, that breaks its reader";
  EXPECT_EQ(refusal_of([] { in_child("file", []() -> std::string { std::abort(); }); }), broken);
  EXPECT_EQ(refusal_of([] {
              in_child("file", []() -> std::string {
                std::raise(SIGSEGV);
                return "never";
              });
            }),
            broken);
  EXPECT_EQ(refusal_of([] { in_child("file", []() -> std::string { std::_Exit(3); }); }), broken);
}

TEST(InChild, MayBeInterrupted) {
  int looked = 0;
  const Interruptible interruptible([&] {
    if (++looked > 2) throw std::runtime_error("enough");
  });
  EXPECT_THROW(in_child("file",
                        [] {
                          std::this_thread::sleep_for(std::chrono::minutes(10));
                          return std::string();
                        }),
               std::runtime_error);
}

}  // namespace
}  // namespace inhabit
