#include "inhabit/io/safetensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "refusal_of.h"
#include "temp_folder.h"

using namespace inhabit;

namespace {

class SafeTensorsFile : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  /// A file with this header text, its length in front, and `bytes` zero bytes of data behind.
  std::string write_raw(const std::string& header, size_t bytes, uint64_t claimed_length = UINT64_MAX) const {
    const std::string file = path("raw.safetensors");
    std::ofstream out(file, std::ios::binary);
    const uint64_t length = claimed_length == UINT64_MAX ? header.size() : claimed_length;
    for (int i = 0; i < 8; ++i) out.put(static_cast<char>(length >> (8 * i)));
    out << header << std::string(bytes, '\0');
    return file;
  }

  static std::string message(const std::string& file) {
    return refusal_of([&] { return read_safetensors(file); });
  }

  TempFolder folder_;
};

}  // namespace

TEST_F(SafeTensorsFile, RoundTripsEveryElementTypeAndMetadata) {
  torch::manual_seed(0);
  SafeTensors content;
  content.metadata = {{"config", "{\"a\": \"ä\"}"}, {"empty", ""}};
  for (const auto type : {torch::kFloat64, torch::kFloat32, torch::kFloat16, torch::kBFloat16, torch::kInt64,
                          torch::kInt32, torch::kInt16, torch::kInt8, torch::kUInt8, torch::kBool})
    content.tensors[torch::toString(type)] = (torch::rand({2, 3, 5}) * 100).to(type);
  content.tensors["scalar"] = torch::tensor(3.5F);
  content.tensors["none"] = torch::zeros({0, 4});
  content.tensors["strided"] = torch::rand({4, 6}).t();
  write_safetensors(path("a.safetensors"), content);
  const SafeTensors back = read_safetensors(path("a.safetensors"));
  EXPECT_EQ(back.metadata, content.metadata);
  EXPECT_EQ(read_safetensors_metadata(path("a.safetensors")), content.metadata);
  ASSERT_EQ(back.tensors.size(), content.tensors.size());
  for (const auto& [name, tensor] : content.tensors) {
    EXPECT_EQ(back.tensors.at(name).scalar_type(), tensor.scalar_type()) << name;
    EXPECT_TRUE(torch::equal(back.tensors.at(name), tensor)) << name;
  }
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.path)) ++files;
  EXPECT_EQ(files, 1U) << "a temporary was left behind";
}

TEST_F(SafeTensorsFile, HalfPrecisionStoresFloatsInHalfTheSpace) {
  const torch::Tensor values = torch::linspace(-2, 2, 1001);
  write_safetensors(path("h.safetensors"), {{{"w", values}, {"i", torch::arange(3)}}, {}}, true);
  const SafeTensors back = read_safetensors(path("h.safetensors"));
  EXPECT_EQ(back.tensors.at("w").scalar_type(), torch::kFloat16);
  EXPECT_EQ(back.tensors.at("i").scalar_type(), torch::kInt64);
  EXPECT_LT((back.tensors.at("w").to(torch::kFloat32) - values).abs().max().item<float>(), 1e-3);
}

TEST_F(SafeTensorsFile, RefusesMalformedFilesWithOneClearLine) {
  using ::testing::HasSubstr;
  EXPECT_THAT(message(path("missing")), HasSubstr("no such file"));
  EXPECT_THAT(message(folder_.path.string()), HasSubstr("not a file"));
  EXPECT_THAT(message(write_raw("", 0, 1ULL << 40)), HasSubstr("header length"));
  EXPECT_THAT(message(write_raw("{]", 0)), HasSubstr("not JSON"));
  EXPECT_THAT(message(write_raw("[1]", 0)), HasSubstr("not JSON"));
  EXPECT_THAT(message(write_raw(R"({"__metadata__":{"a":1}})", 0)), HasSubstr("metadata"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[2]}})", 8)), HasSubstr("lacks"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F3","shape":[2],"data_offsets":[0,8]}})", 8)), HasSubstr("element"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[-2],"data_offsets":[0,8]}})", 8)), HasSubstr("shape"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[3],"data_offsets":[0,8]}})", 8)),
              HasSubstr("disagree"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[8,0]}})", 8)),
              HasSubstr("disagree"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})", 7)), HasSubstr("outside"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[4294967296,4294967296,4],"data_offsets":[0,0]}})", 0)),
              HasSubstr("absurd"));
  EXPECT_THAT(message(write_raw(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},
                                    "b":{"dtype":"F32","shape":[2],"data_offsets":[4,12]}})",
                                12)),
              HasSubstr("overlap"));
  EXPECT_EQ(message(write_raw(R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})", 8)), "");
}

TEST_F(SafeTensorsFile, EveryTruncationIsRefused) {
  write_safetensors(path("t.safetensors"), {{{"a", torch::rand({3, 4})}, {"b", torch::rand({5})}}, {{"k", "v"}}});
  std::ifstream in(path("t.safetensors"), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(path("cut.safetensors"), std::ios::binary) << whole.substr(0, length);
    EXPECT_THROW(read_safetensors(path("cut.safetensors")), Error) << length;
  }
}

TEST_F(SafeTensorsFile, AnUnwritablePlaceIsAnError) {
  EXPECT_THROW(write_safetensors(path("no/such/folder/x.safetensors"), {}), Error);
}
