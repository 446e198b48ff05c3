#include "inhabit/io/npz.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

// Written by NumPy 1.24: np.savez_compressed with one array of each kind.
const std::string kTypes = INHABIT_SOURCE_DIR "/tests/data/npz/types.npz";
const std::string kStored = INHABIT_SOURCE_DIR "/tests/data/npz/stored.npz";

void expect_equal(const torch::Tensor& is, const torch::Tensor& should) {
  EXPECT_EQ(is.scalar_type(), should.scalar_type());
  EXPECT_TRUE(torch::equal(is, should)) << is << should;
}

TEST(Npz, ReadsEveryTypeThatNumPyWrites) {
  const Npz npz = read_npz(kTypes);
  expect_equal(npz.at("f2", ""), torch::arange(6).to(torch::kHalf).view({2, 3}));
  expect_equal(npz.at("f4", ""), torch::arange(6).to(torch::kFloat).view({2, 3}) / 4);
  expect_equal(npz.at("f8", ""), torch::arange(6).to(torch::kDouble).view({3, 2}) / 8);
  expect_equal(npz.at("i1", ""), torch::tensor({-128, 127}, torch::kInt8));
  expect_equal(npz.at("i2", ""), torch::tensor({-32768, 5}, torch::kInt16));
  expect_equal(npz.at("i4", ""), torch::tensor({-7, 2147483647}, torch::kInt32));
  expect_equal(npz.at("i8", ""), torch::tensor({int64_t{1} << 62, int64_t{-1}}, torch::kInt64));
  expect_equal(npz.at("u1", ""), torch::tensor({0, 255}, torch::kUInt8));
  expect_equal(npz.at("u2", ""), torch::tensor({0, 65535}, torch::kInt32));
  expect_equal(npz.at("u4", ""), torch::tensor({int64_t{1}, int64_t{4294967295}}, torch::kInt64));
  expect_equal(npz.at("u8", ""), torch::tensor({int64_t{1}, int64_t{1} << 40}, torch::kInt64));
  expect_equal(npz.at("b1", ""), torch::tensor({1, 0, 1}, torch::kInt32).ne(0));
  expect_equal(npz.at("big", ""), torch::arange(4).to(torch::kFloat));
  expect_equal(npz.at("bigi", ""), torch::tensor({258}, torch::kInt16));
  expect_equal(npz.at("fortran", ""), torch::arange(24).to(torch::kFloat).view({2, 3, 4}));
  EXPECT_EQ(npz.at("scalar", "").dim(), 0);
  EXPECT_EQ(npz.at("scalar", "").item<double>(), 120.0);
  EXPECT_EQ(npz.at("empty", "").sizes(), (std::vector<int64_t>{0, 3}));
  EXPECT_EQ(npz.strings.at("unicode").values, std::vector<std::string>{"female"});
  EXPECT_TRUE(npz.strings.at("unicode").shape.empty());
  EXPECT_EQ(npz.strings.at("bytes").values, std::vector<std::string>{"male"});
  EXPECT_EQ(npz.strings.at("names").values, (std::vector<std::string>{"a", "l\xC3\xA4nger"}));
  EXPECT_EQ(npz.strings.at("bignames").values, (std::vector<std::string>{"x", "yz"}));
  for (const char* name : {"object", "complex", "structured", "date"}) EXPECT_EQ(npz.skipped.count(name), 1U) << name;
}

TEST(Npz, ReadsOnlyWhatIsAsked) {
  const Npz npz = read_npz(kTypes, {"f4", "unicode"});
  EXPECT_EQ(npz.tensors.size(), 1U);
  EXPECT_EQ(npz.strings.size(), 1U);
}

TEST(Npz, SaysWhatIsThereInstead) {
  const Npz npz = read_npz(kTypes);
  EXPECT_NE(refusal_of([&] { npz.at("object", "f"); }).find("pickled"), std::string::npos);
  EXPECT_NE(refusal_of([&] { npz.at("unicode", "f"); }).find("text"), std::string::npos);
  EXPECT_NE(refusal_of([&] { npz.at("poses", "f"); }).find("b1, big"), std::string::npos);
}

TEST(Npz, RoundTripsAndGivesTheSameBytes) {
  Npz npz;
  npz.tensors["strided"] = torch::randn({5, 4}).t();
  npz.tensors["scalar"] = torch::tensor(2.5, torch::kDouble);
  npz.tensors["mask"] = torch::tensor({1, 0}).ne(0);
  npz.tensors["none"] = torch::zeros({0, 7}, torch::kInt64);
  npz.tensors["half"] = torch::randn({3}).to(torch::kHalf);
  npz.strings["name"] = {{}, {"neutral"}};
  npz.strings["names"] = {{2}, {"Stuhl", "\xE6\xA4\x85\xF0\x9F\xAA\x91"}};
  npz.strings["nameless"] = {{0}, {}};
  const std::string bytes = npz_bytes(npz);
  EXPECT_EQ(bytes, npz_bytes(npz));
  const Npz back = parse_npz(bytes, "memory");
  EXPECT_TRUE(back.skipped.empty());
  ASSERT_EQ(back.tensors.size(), npz.tensors.size());
  for (const auto& [name, tensor] : npz.tensors) expect_equal(back.at(name, ""), tensor);
  ASSERT_EQ(back.strings.size(), npz.strings.size());
  for (const auto& [name, strings] : npz.strings) {
    EXPECT_EQ(back.strings.at(name).values, strings.values);
    EXPECT_EQ(back.strings.at(name).shape, strings.shape);
  }
}

TEST(Npz, WritesAndReadsFilesAlsoSingleArrays) {
  const TempFolder folder;
  Npz npz;
  npz.tensors["a"] = torch::randn({3, 2});
  write_npz(folder / "a.npz", npz);
  expect_equal(read_npz(folder / "a.npz").at("a", ""), npz.tensors["a"]);
  write_npy(folder / "a.npy", npz.tensors["a"]);
  expect_equal(read_npz(folder / "a.npy").at("arr_0", ""), npz.tensors["a"]);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 2);
}

TEST(Npz, EveryTruncationIsAnErrorNotACrash) {
  const std::string whole = read_whole_file(kTypes);
  for (size_t n = 0; n < whole.size(); n += 7) {
    const std::string part = whole.substr(0, n);
    EXPECT_NE(refusal_of([&] { parse_npz(part, "cut"); }).find("cut: "), std::string::npos) << n;
  }
}

TEST(Npz, DamagedDataFailsItsChecksum) {
  std::string bytes = read_whole_file(kStored);
  bytes[bytes.find("NUMPY") + 130] ^= 0x40;
  EXPECT_NE(refusal_of([&] { parse_npz(bytes, "bad"); }).find("damaged"), std::string::npos);
}

TEST(Npz, DeclaredSizesAreNotBelieved) {
  std::string npy("\x93NUMPY\x01\x00", 8);
  const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (400000000, 1), }";
  npy += static_cast<char>(header.size());
  npy += '\0';
  npy += header + "1234567812345678";
  EXPECT_NE(refusal_of([&] { parse_npz(npy, "big"); }).find("ends early"), std::string::npos);
  std::string huge = npy;
  huge.replace(huge.find("400000000, 1"), 12, "999999999999");
  EXPECT_NE(refusal_of([&] { parse_npz(huge, "big"); }).find("absurd"), std::string::npos);
  std::string negative = npy;
  negative.replace(negative.find("400000000"), 9, "-40000000");
  EXPECT_NE(refusal_of([&] { parse_npz(negative, "big"); }), "");
  std::string text = npy;
  text.replace(text.find("<f8"), 3, "|S0");
  EXPECT_NE(refusal_of([&] { parse_npz(text, "big"); }).find("absurd"), std::string::npos);
}

TEST(AtomicFile, LeavesNothingBehindWhenItFails) {
  const TempFolder folder;
  EXPECT_NE(refusal_of([&] { write_atomically(folder / "none/a.txt", "x"); }).find("no folder"), std::string::npos);
  EXPECT_NE(refusal_of([&] { write_atomically(folder.path.string(), "x"); }).find("folder"), std::string::npos);
  write_atomically(folder / "a.txt", "old");
  EXPECT_THROW(write_atomically(folder / "a.txt",
                                [](std::ostream& stream) {
                                  stream << "half";
                                  throw Error("a.txt", "went wrong");
                                }),
               Error);
  EXPECT_EQ(read_whole_file(folder / "a.txt"), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
  EXPECT_NE(refusal_of([] { write_atomically("/dev/full", std::string(1 << 20, 'x')); }), "");
}

TEST(AtomicFile, ReadingSaysWhatIsWrong) {
  const TempFolder folder;
  EXPECT_NE(refusal_of([&] { read_whole_file(folder / "none"); }).find("no such file"), std::string::npos);
  EXPECT_NE(refusal_of([&] { read_whole_file(folder.path.string()); }).find("folder"), std::string::npos);
  write_atomically(folder / "a.txt", "0123456789");
  EXPECT_NE(refusal_of([&] { read_whole_file(folder / "a.txt", 5); }).find("too large"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
