// Protects streams: everybody who is due gets their result or the reason why not, and OpenBLAS has its threads again
// once the last of several who hold them back is done.
#include "inhabit/nn/each_person.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace inhabit::nn {
namespace {

struct Result {
  std::string person;
  double time = 0;
  double result = 0;
  std::string error, doubt;
};

TEST(EachPerson, HasTheirResultOrTheReasonWhyNot) {
  std::vector<PoseStream::Due> due(5);
  for (size_t i = 0; i < due.size(); ++i) {
    due[i].person = std::to_string(i);
    due[i].doubt = i == 2 ? "implausible" : "";
    due[i].time = 0.5 * static_cast<double>(i);
  }
  const std::vector<Result> out = each_person<Result>(due, [](const PoseStream::Due& one) {
    if (one.person == "3") throw Error("person", "has no legs");
    return 10 * one.time;
  });
  ASSERT_EQ(out.size(), due.size());
  for (size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(out[i].person, std::to_string(i));
    EXPECT_EQ(out[i].time, 0.5 * static_cast<double>(i));
    EXPECT_EQ(out[i].result, i == 3 ? 0 : 5.0 * static_cast<double>(i));
    EXPECT_EQ(out[i].doubt, due[i].doubt);
    EXPECT_EQ(out[i].error, i == 3 ? "person: has no legs" : "");
  }
  EXPECT_TRUE(each_person<Result>({}, [](const PoseStream::Due&) { return 1.0; }).empty());
}

TEST(OneBlasThread, LastsAsLongAsAnyAndLeavesTheNumberAsItWas) {
  if (openblas_get_num_threads == nullptr) GTEST_SKIP() << "LibTorch's BLAS is not OpenBLAS";
  const int before = openblas_get_num_threads();
  openblas_set_num_threads(2);
  auto first = std::make_unique<OneBlasThread>(), second = std::make_unique<OneBlasThread>();
  EXPECT_EQ(openblas_get_num_threads(), 1);
  first.reset();
  EXPECT_EQ(openblas_get_num_threads(), 1);
  second.reset();
  EXPECT_EQ(openblas_get_num_threads(), 2);
  openblas_set_num_threads(before);
}

}  // namespace
}  // namespace inhabit::nn
