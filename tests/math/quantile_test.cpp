#include "inhabit/math/quantile.h"

#include <gtest/gtest.h>

using namespace inhabit;

TEST(Quantile, OfAnEvenNumberTheMedianIsTheUpperOfTheMiddleTwoAndHalfTheLower) {
  const std::vector<double> odd{5, 1, 3}, even{7, 1, 5, 3};
  EXPECT_EQ(median(odd), 3);
  EXPECT_EQ(quantile(odd, 0.5), 3);
  EXPECT_EQ(median(even), 5);
  EXPECT_EQ(quantile(even, 0.5), 3);
  EXPECT_EQ(even, (std::vector<double>{7, 1, 5, 3}));  // the caller's stay in order
}

TEST(Quantile, IsAValueRoundedDown) {
  std::vector<float> values;
  for (int i = 0; i <= 20; ++i) values.push_back(static_cast<float>(i * 8 % 21));  // 0 to 20, mixed
  EXPECT_EQ(quantile(values, 0), 0);
  EXPECT_EQ(quantile(values, 1), 20);
  EXPECT_EQ(quantile(values, 0.24), 4);  // 4.8
  EXPECT_EQ(nth_smallest(values, 17), 17);
  EXPECT_EQ(median(std::vector<int>{4}), 4);
}
