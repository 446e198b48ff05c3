// Protects the readers of PyTorch's tensors: numbers as they were, nothing executed, no size believed.
#include "inhabit/io/torch_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/data/vposer.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/math/rotation.h"
#include "io/pickle_bytes.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

std::string torch_refusal(const std::string& bytes) {
  return refusal_of([&] { parse_torch(bytes, "x.pt"); });
}

TEST(TorchFile, ReadsTensorsByTheirNames) {
  const torch::Tensor a = torch::arange(6).view({2, 3}) / 7.0, b = torch::tensor({-1.5F});
  const Pickle file = parse_torch(torch_file({{"layer.weight", a}, {"layer.bias", b}}), "x.pt");
  EXPECT_TRUE(torch::equal(file.numbers_at(*file.root, "layer.weight"), a.to(torch::kFloat32)));
  EXPECT_TRUE(torch::equal(file.numbers_at(*file.root, "layer.bias"), b));
  // A column of a larger tensor, as a pickle of tensors has it.
  const torch::Tensor columns = a.to(torch::kFloat32).contiguous();
  const std::string inner = torch_saved(torch_storage_key(0, 6), {columns.flatten()});
  const std::string view = torch_view(
      "ctorch.storage\n_load_from_bytes\nB" + little_endian(inner.size(), 4) + inner + "\x85R", columns.select(1, 0));
  const Pickle pickle = parse_pickle("\x80\x02" + view + ".", "x.pkl");
  EXPECT_TRUE(torch::equal(pickle.numbers(*pickle.root, "column"), columns.select(1, 0)));
}

TEST(TorchFile, RefusesWhatIsDamagedOrHostile) {
  const std::string whole = torch_file({{"w", torch::ones({2, 3})}});
  EXPECT_EQ(torch_refusal(whole), "");
  for (size_t n = 0; n < whole.size(); ++n) EXPECT_NE(torch_refusal(whole.substr(0, n)), "") << n;
  EXPECT_THAT(torch_refusal("PK\x03\x04"), HasSubstr("PyTorch 1.6 or newer"));
  const torch::Tensor six = torch::ones({6});
  const auto viewing = [&](const std::string& size, const std::string& stride, int64_t count = 6) {
    return torch_saved("ctorch._utils\n_rebuild_tensor_v2\n(" + torch_storage_key(0, count) + "K\x01(" + size + "t(" +
                           stride + "t\x89N" + "tR",
                       {six});
  };
  EXPECT_EQ(torch_refusal(viewing("K\x05", "K\x01")), "");
  for (const auto& [size, stride] : {std::pair("K\x06", "K\x01"),
                                     {"K\x03", "K\x03"},
                                     {"J\xff\xff\xff\x7f", "K\x01"},
                                     {"K\x03K\x03", "K\x01K\x01"},
                                     {"K\x06K\x06", "K\x01K\x01"}})
    EXPECT_THAT(torch_refusal(viewing(size, stride)), HasSubstr("more numbers than it has"));
  EXPECT_THAT(torch_refusal(viewing("K\x05K\x01", "K\x01")), HasSubstr("cannot be understood"));
  EXPECT_THAT(torch_refusal(viewing("K\x05", "K\x01", 1 << 30)), HasSubstr("more numbers than it has"));
  EXPECT_THAT(torch_refusal(viewing("K\x05", "K\x01", 7)), HasSubstr("other numbers"));
  // A file in a file in a file: how deep would be up to whoever made it.
  const std::string inner = torch_saved(torch_storage_key(0, 6), {six});
  EXPECT_THAT(torch_refusal(torch_saved(
                  "ctorch.storage\n_load_from_bytes\nB" + little_endian(inner.size(), 4) + inner + "\x85R", {})),
              HasSubstr("in another"));
  EXPECT_THAT(refusal_of([&] { parse_pickle("\x80\x02" + torch_storage_key(0, 6) + ".", "x.pkl"); }),
              HasSubstr("kept elsewhere"));
  EXPECT_THAT(torch_refusal(torch_saved("ctorch\nload\n.", {})), HasSubstr("needs torch.load"));
}

/// Against the equations of its layers and of the six numbers of a rotation, written out one by one.
TEST(Vposer, DecodesAsItsLayersSay) {
  torch::manual_seed(5);
  const int64_t n = 7;
  const std::map<std::string, torch::Tensor> weights = {
      {"bodyprior_dec_fc1.weight", torch::randn({n, 32})},  {"bodyprior_dec_fc1.bias", torch::randn({n})},
      {"bodyprior_dec_fc2.weight", torch::randn({n, n})},   {"bodyprior_dec_fc2.bias", torch::randn({n})},
      {"bodyprior_dec_out.weight", torch::randn({126, n})}, {"bodyprior_dec_out.bias", torch::randn({126})},
      {"bodyprior_enc_fc1.weight", torch::randn({3, 3})}};
  const TempFolder folder;
  write_atomically(folder / "TR00.pt", torch_file(weights));
  const Vposer vposer = read_vposer(folder / "TR00.pt");
  const torch::Tensor codes = torch::randn({4, 32}), poses = vposer.decode(codes);
  ASSERT_EQ(poses.sizes(), (std::vector<int64_t>{4, 63}));
  const torch::Tensor matrices = axis_angle_to_matrix(poses.view({4, 21, 3}));
  for (int64_t t = 0; t < 4; ++t) {
    torch::Tensor x = codes[t];
    for (const char* layer : {"fc1", "fc2", "out"}) {
      const std::string name = std::string("bodyprior_dec_") + layer;
      x = weights.at(name + ".weight").mv(x) + weights.at(name + ".bias");
      if (std::string(layer) != "out") x = torch::where(x > 0, x, 0.2 * x);
    }
    for (int64_t j = 0; j < 21; ++j) {
      const torch::Tensor six = x.narrow(0, 6 * j, 6).view({3, 2});
      const torch::Tensor first = six.select(1, 0) / six.select(1, 0).norm();
      torch::Tensor second = six.select(1, 1) - first.dot(six.select(1, 1)) * first;
      second = second / second.norm();
      const torch::Tensor should = torch::stack({first, second, torch::linalg_cross(first, second)}, 1);
      EXPECT_LT((matrices[t][j] - should).abs().max().item<double>(), 1e-4) << t << " " << j;
    }
  }
  std::map<std::string, torch::Tensor> narrow = weights;
  narrow["bodyprior_dec_fc2.weight"] = torch::randn({n, n + 1});
  write_atomically(folder / "narrow.pt", torch_file(narrow));
  EXPECT_THAT(refusal_of([&] { read_vposer(folder / "narrow.pt"); }), HasSubstr("as VPoser 1.0 has it"));
}

}  // namespace
}  // namespace inhabit
