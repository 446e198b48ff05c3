// Protects the reader of CDF files: the same numbers from every form of a file, and no size or place believed.
#include "inhabit/io/cdf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "inhabit/io/atomic_file.h"
#include "io/cdf_bytes.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

std::string cdf_refusal(const std::string& bytes) {
  return refusal_of([&] { parse_cdf(bytes, "x.cdf"); });
}

/// One record, as Human3.6M's: frames and 96 columns.
torch::Tensor pose_of(int64_t frames) {
  return torch::arange(frames * 96, torch::kFloat32).view({1, frames, 96}) / 7 - 30;
}

/// `bytes` with a number written over.
std::string with_number(std::string bytes, size_t at, int64_t value, size_t width = 4) {
  return bytes.replace(at, width, cdf_number(value, width));
}

/// Where a file of version 3 describes the variable.
size_t described(const std::string& bytes, const std::string& name) { return bytes.find(name + '\0') - 84; }

TEST(Cdf, EveryFormHoldsTheSameNumbers) {
  torch::manual_seed(3);
  const std::vector<CdfArray> arrays = {{"Pose", pose_of(5)},
                                        {"doubles", torch::randn({7, 3, 4}, torch::kFloat64)},
                                        {"deep", torch::randn({5, 2, 3, 4})},
                                        {"plain", torch::randn({6})},
                                        {"fixed", torch::randn({1, 2, 3}), false},
                                        {"single", torch::full({1}, 50.0), false},
                                        {"none", torch::zeros({0, 4})},
                                        {"int8", torch::tensor({-3, 100}, torch::kInt8)},
                                        {"int16", torch::tensor({-3000, 300}, torch::kInt16)},
                                        {"int32", torch::tensor({-300000, 30}, torch::kInt32)},
                                        {"int64", torch::tensor({int64_t{-1} << 40, int64_t{3}})},
                                        {"uint8", torch::tensor({3, 200}, torch::kUInt8)},
                                        {"uint16", torch::tensor({-1, 3}, torch::kInt16), true, false, 12},
                                        {"shared", torch::randn({3, 2, 5}), true, true},
                                        {"shared too", torch::randn({4, 2, 5}), true, true}};
  for (int bits = 0; bits < 32; ++bits)
    for (const auto& [block, deep] : {std::pair(0, false), {2, false}, {3, true}}) {
      const CdfForm form = {
          (bits & 1) == 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, (bits & 16) != 0, block, deep};
      SCOPED_TRACE(std::to_string(bits) + " in blocks of " + std::to_string(block));
      const Npz read = parse_cdf(cdf_bytes(arrays, form), "x.cdf");
      ASSERT_EQ(read.tensors.size(), arrays.size());
      EXPECT_TRUE(read.skipped.empty());
      for (const CdfArray& array : arrays) {
        const torch::Tensor& is = read.at(array.name, "x.cdf");
        torch::Tensor should = array.varies ? array.values : array.values[0];
        if (array.type == 12) should = torch::tensor({65535, 3}, torch::kInt32);
        EXPECT_EQ(is.scalar_type(), should.scalar_type()) << array.name;
        EXPECT_TRUE(torch::equal(is, should)) << array.name;
      }
    }
}

TEST(Cdf, RoomForRecordsThatWereNotWrittenIsLeftOut) {
  // The last block says to hold four records, of which three are the variable's.
  for (const bool pack : {false, true}) {
    const CdfForm form = {.pack_variables = pack};
    std::string bytes = cdf_bytes({{"v", torch::arange(12, torch::kFloat32).view({4, 3})}}, form);
    bytes = with_number(bytes, described(bytes, "v") + 24, 2);
    EXPECT_TRUE(torch::equal(parse_cdf(bytes, "x.cdf").at("v", ""), torch::arange(9, torch::kFloat32).view({3, 3})));
  }
}

TEST(Cdf, SaysWhatIsNoArrayOfNumbers) {
  std::string bytes = cdf_bytes({{"name", torch::zeros({2}, torch::kUInt8), true, false, 51},
                                 {"time", torch::zeros({2}, torch::kFloat64), true, false, 32},
                                 {"left out", torch::zeros({2})},
                                 {"packed", torch::zeros({2})},
                                 {"Pose", pose_of(2)}},
                                {.pack_variables = true});
  bytes = with_number(bytes, described(bytes, "left out") + 48, 1);
  bytes = with_number(bytes, described(bytes, "packed") - 28 + 12, 1);  // of its packing, which stands before it
  const Npz read = parse_cdf(bytes, "x.cdf");
  EXPECT_EQ(read.tensors.size(), 1U);
  EXPECT_EQ(read.skipped.at("name"), "text");
  EXPECT_EQ(read.skipped.at("time"), "of type 32");
  EXPECT_EQ(read.skipped.at("left out"), "an array of which records are left out");
  EXPECT_EQ(read.skipped.at("packed"), "packed by run lengths");
  EXPECT_THAT(refusal_of([&] { read.at("packed", "x.cdf"); }), HasSubstr("packed by run lengths"));
}

TEST(Cdf, RefusesWhatIsCutShort) {
  for (const CdfForm& form :
       {CdfForm{}, CdfForm{.pack_variables = true}, CdfForm{.pack_file = true}, CdfForm{.wide = false}}) {
    const std::string whole = cdf_bytes({{"Pose", pose_of(2)}}, form);
    EXPECT_EQ(cdf_refusal(whole), "");
    for (size_t n = 0; n < whole.size(); ++n) EXPECT_THAT(cdf_refusal(whole.substr(0, n)), HasSubstr("x.cdf")) << n;
  }
  EXPECT_THAT(cdf_refusal("CDF\x01 is NetCDF"), HasSubstr("is no CDF file of version 2.6, 2.7 or 3"));
  EXPECT_THAT(cdf_refusal(""), HasSubstr("is empty"));
  EXPECT_THAT(refusal_of([] { read_cdf("/none/x.cdf"); }), HasSubstr("/none/x.cdf: "));
}

TEST(Cdf, BelievesNoSize) {
  const std::string whole = cdf_bytes({{"Pose", pose_of(2)}}),
                    packed = cdf_bytes({{"Pose", pose_of(2)}}, {.pack_variables = true});
  const size_t at = described(whole, "Pose"), packed_at = described(packed, "Pose");
  constexpr int64_t kMost = std::numeric_limits<int32_t>::max();
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 24, 1)), HasSubstr("Pose: ends early: 2 records declared, 1 there"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 24, kMost)), HasSubstr("records declared"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 344, 3)), HasSubstr("Pose: ends early"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 344, 1 << 20)), HasSubstr("larger than the file"));
  EXPECT_THAT(cdf_refusal(with_number(with_number(whole, at + 344, kMost), at + 348, kMost)), HasSubstr("absurd size"));
  EXPECT_THAT(cdf_refusal(with_number(packed, packed_at + 344, 1 << 20)), HasSubstr("absurd size"));
  EXPECT_THAT(cdf_refusal(with_number(packed, packed_at + 344, 3)), HasSubstr("Pose: ends early"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 344, 0)), HasSubstr("a dimension of it is 0"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 340, 1 << 20)), HasSubstr("dimensions"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at, -1, 8)), HasSubstr("beyond its end"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at, int64_t{1} << 62, 8)), HasSubstr("beyond its end"));
  const std::string file = cdf_bytes({{"Pose", pose_of(2)}}, {.pack_file = true});
  for (const int64_t size : {int64_t{-1}, int64_t{1} << 40})
    EXPECT_THAT(cdf_refusal(with_number(file, 28, size, 8)), HasSubstr("absurd size"));
  EXPECT_THAT(cdf_refusal(with_number(file, 28, 100, 8)), HasSubstr("beyond its end"));
  // What is packed twice may be no larger than what is packed once.
  const std::vector<CdfArray> zeros = {{"z", torch::zeros({1, 1 << 22})}};
  EXPECT_EQ(cdf_refusal(cdf_bytes(zeros, {.pack_variables = true})), "");
  EXPECT_EQ(cdf_refusal(cdf_bytes(zeros, {.pack_file = true})), "");
  EXPECT_THAT(cdf_refusal(cdf_bytes(zeros, {.pack_variables = true, .pack_file = true})), HasSubstr("absurd size"));
}

TEST(Cdf, BelievesNoPlace) {
  const std::string whole = cdf_bytes({{"first", torch::zeros({4, 3})}, {"Pose", pose_of(2)}}, {.block = 2});
  const size_t at = described(whole, "Pose");
  for (const int64_t place : {int64_t{7}, int64_t{1} << 40})  // of the next variable, the index, the descriptor
    for (const size_t of : {at + 12, at + 28, size_t{20}})
      EXPECT_THAT(cdf_refusal(with_number(whole, of, place, 8)), HasSubstr("beyond its end")) << place << " " << of;
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 12, static_cast<int64_t>(at), 8)), HasSubstr("in a circle"));
  EXPECT_THAT(cdf_refusal(with_number(whole, at + 28, 320, 8)), HasSubstr("record of kind 2"));
  // An index that leads to itself, behind it or below it.
  const std::string deep = cdf_bytes({{"v", torch::zeros({4, 3})}}, {.block = 2, .deep = true});
  const size_t index = described(deep, "v") - 28 - 44;
  ASSERT_EQ(deep.substr(index + 8, 4), cdf_number(6));
  const auto self = static_cast<int64_t>(index);
  EXPECT_THAT(cdf_refusal(with_number(deep, index + 36, self, 8)), HasSubstr("in a circle"));
  EXPECT_THAT(cdf_refusal(with_number(with_number(deep, index + 12, self, 8), described(deep, "v") + 24, 4)),
              HasSubstr("in a circle"));
  EXPECT_THAT(cdf_refusal(with_number(deep, index + 20, 1 << 30)), HasSubstr("larger than the file"));
  // Two blocks of the same records, and one in the place of all others.
  const size_t blocks = index - 60;
  ASSERT_EQ(deep.substr(blocks + 8, 4), cdf_number(6));
  EXPECT_THAT(cdf_refusal(with_number(deep, blocks + 32, 1)), HasSubstr("in disorder"));
  EXPECT_THAT(cdf_refusal(with_number(deep, blocks + 28, -1)), HasSubstr("in disorder"));
}

TEST(Cdf, RefusesWhatItCannotRead) {
  const std::string whole = cdf_bytes({{"Pose", pose_of(2)}}),
                    packed = cdf_bytes({{"Pose", pose_of(2)}}, {.pack_file = true});
  EXPECT_THAT(cdf_refusal(with_number(whole, 36, 3)), HasSubstr("in encoding 3"));
  EXPECT_THAT(cdf_refusal(with_number(whole, 40, 1)), HasSubstr("in other files"));
  EXPECT_THAT(cdf_refusal(with_number(packed, packed.size() - 16, 3)), HasSubstr("adaptive Huffman"));
  std::string unnamed = whole;
  unnamed[described(whole, "Pose") + 84] = '\n';
  EXPECT_THAT(cdf_refusal(unnamed), HasSubstr("no name"));
  std::string torn = packed;
  torn[torn.size() - 28 - 3] = static_cast<char>(torn[torn.size() - 28 - 3] ^ 1);  // of the checksum
  EXPECT_THAT(cdf_refusal(torn), HasSubstr("cannot be unpacked"));
}

TEST(Cdf, ReadsAFile) {
  const TempFolder folder;
  write_atomically(folder / "Walking 1.cdf", cdf_bytes({{"Pose", pose_of(3)}}));
  EXPECT_TRUE(torch::equal(read_cdf(folder / "Walking 1.cdf").at("Pose", ""), pose_of(3)));
}

}  // namespace
}  // namespace inhabit
