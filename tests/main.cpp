// The main of every test program: gtest's, and --file=NAME.cpp, which runs the tests of one source. LibTorch takes half
// a second to start, so ctest has an entry for a file, not for a test.
#include <gmock/gmock.h>

#include <cstdio>
#include <string>

namespace {

/// The pattern of all tests in sources called `name`; empty where there is none.
std::string tests_of(const std::string& name) {
  std::string filter;
  const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const ::testing::TestSuite& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k) {
      const ::testing::TestInfo& test = *suite.GetTestInfo(k);
      const std::string file = test.file();
      if (file.substr(file.rfind('/') + 1) == name)
        filter += (filter.empty() ? "" : ":") + std::string(suite.name()) + "." + test.name();
    }
  }
  return filter;
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string filter = argument.rfind("--file=", 0) == 0 ? tests_of(argument.substr(7)) : "";
    if (filter.empty()) {
      std::fprintf(stderr, "%s: %s\n", argument.c_str(), "no such argument, or no test in a file of this name");
      return 2;
    }
    ::testing::GTEST_FLAG(filter) = filter;
  }
  return RUN_ALL_TESTS();
}
