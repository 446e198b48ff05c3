#include "inhabit/forecast/fast_contact_network.h"

#include <map>
#include <utility>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/nn/fast_point_voxel.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::forecast {

using torch::Tensor;

namespace {

constexpr int64_t kPositionChannels = 3;
constexpr int64_t kRowChunk = 64;
constexpr int64_t kTransposeBlock = 16;  // channels turned together, a cache line of a row; divides the rows' padding

/// Rows [x y z, contact coefficients] of one cloud; points whose coefficients are all zero are listed as bare.
void scene_rows(const float* points, const float* contact, int64_t count, int64_t features, nn::Rows& rows) {
  rows.resize(count, kPositionChannels + features);
  rows.shallow = kPositionChannels;
  std::vector<char> touched(static_cast<size_t>(count), 0);
  nn::parallel_chunks((count + kRowChunk - 1) / kRowChunk, [&](int64_t chunk) {
    const int64_t first = chunk * kRowChunk, last = std::min(count, first + kRowChunk);
    for (int64_t f = 0; f < features; ++f) {
      const float* row = contact + f * count;
      for (int64_t n = first; n < last; ++n) touched[n] = static_cast<char>(touched[n] | (row[n] != 0.0F));
    }
    for (int64_t n = first; n < last; ++n) {
      float* into = rows.row(n);
      std::copy_n(points + 3 * n, 3, into);
      // What an earlier call left there: a voxel's mean is over all of its points, touched or not.
      if (touched[n] == 0) std::fill(into + kPositionChannels, into + rows.stride, 0.0F);
    }
    for (int64_t block = 0; block < features; block += kTransposeBlock) {
      const int64_t end = std::min(features, block + kTransposeBlock);
      for (int64_t n = first; n < last; ++n) {
        if (touched[n] == 0) continue;
        float* into = rows.row(n) + kPositionChannels;
        for (int64_t f = block; f < end; ++f) into[f] = contact[f * count + n];
      }
    }
  });
  for (int64_t n = 0; n < count; ++n) (touched[n] != 0 ? rows.full : rows.bare).push_back(static_cast<int32_t>(n));
}

}  // namespace

struct FastContactNetwork::Impl {
  struct Down {
    std::vector<nn::FastPointVoxelConv> convolutions;
    nn::FastSetAbstraction abstraction;
  };
  struct Up {
    nn::FastFeaturePropagation propagation;
    std::vector<nn::FastPointVoxelConv> convolutions;
  };

  explicit Impl(const ContactNetwork& network)
      : config(network->config),
        encode(nn::row_layer(network->x_enc->weight, network->x_enc->bias)),
        gru(nn::row_gru(*network->x_gru)) {
    const auto convert = [](const std::vector<nn::PointVoxelConv>& layers) {
      return std::vector<nn::FastPointVoxelConv>(layers.begin(), layers.end());
    };
    for (const auto& level : network->pointnet_sa->levels)
      down.push_back({convert(level.convolutions), nn::FastSetAbstraction(level.abstraction)});
    int64_t channels = network->pointnet_sa->level_channels.back() + config.hidden;
    for (size_t i = 0; i < network->pointnet_fp->levels.size(); ++i) {
      const auto& level = network->pointnet_fp->levels[i];
      up.push_back({nn::FastFeaturePropagation(level.propagation, channels), convert(level.convolutions)});
      const PropagationSpec& spec = config.propagation[i];
      channels = spec.convolution ? spec.convolution->channels : spec.mlp.back();
    }
    const auto head = network->out_mlp->named_parameters();
    head_in = nn::row_layer(head["0.weight"], head["0.bias"]);
    head_out = nn::row_layer(head["2.weight"], head["2.bias"]);
  }

  /// Layers of `convolutions` one after the other on the cloud of `level`, in place.
  void convolve(std::vector<nn::FastPointVoxelConv>& convolutions, size_t level, nn::Rows& x) {
    for (nn::FastPointVoxelConv& convolution : convolutions) {
      convolution(plan(level, convolution.grid()), x, spare);
      std::swap(x, spare);
    }
  }

  const nn::GridPlan& plan(size_t level, int64_t grid) {
    const auto key = std::make_pair(level, grid);
    auto found = plans.find(key);
    if (found == plans.end())
      found =
          plans.emplace(key, nn::GridPlan(clouds[level], grid, level == 0 ? inputs[0].full : std::vector<int32_t>()))
              .first;
    return found->second;
  }

  void run(const Tensor& scene, const Tensor& contact, const Tensor& past, Tensor out);

  Config config;
  nn::RowLayer encode, head_in, head_out;
  nn::RowGru gru;
  std::vector<Down> down;
  std::vector<Up> up;

  // Workspaces.
  std::map<std::pair<size_t, int64_t>, nn::GridPlan> plans;  // by level and grid
  std::vector<Tensor> clouds;                                // (1, M, 3) of every level
  std::vector<nn::Rows> inputs;                              // features entering every level
  nn::Rows current, spare;
  std::vector<float> hidden;
};

void FastContactNetwork::Impl::run(const Tensor& scene, const Tensor& contact, const Tensor& past, Tensor out) {
  const int64_t count = scene.size(0), features = contact.size(0);
  plans.clear();
  clouds.assign(1, scene.unsqueeze(0));
  inputs.resize(down.size() + 1);
  scene_rows(scene.data_ptr<float>(), contact.data_ptr<float>(), count, features, inputs[0]);
  for (size_t i = 0; i < down.size(); ++i) {
    if (down[i].convolutions.empty()) {
      clouds.push_back(down[i].abstraction(clouds[i], inputs[i], inputs[i + 1]));
      continue;
    }
    down[i].convolutions.front()(plan(i, down[i].convolutions.front().grid()), inputs[i], current);
    for (size_t k = 1; k < down[i].convolutions.size(); ++k) {
      down[i].convolutions[k](plan(i, down[i].convolutions[k].grid()), current, spare);
      std::swap(current, spare);
    }
    clouds.push_back(down[i].abstraction(clouds[i], current, inputs[i + 1]));
  }

  // The coarsest features and, behind them, the code of the past motion.
  const Tensor poses = local_pose(past, config.root).contiguous();
  std::vector<float> code(static_cast<size_t>(config.hidden));
  nn::last_gru_state(encode, gru, poses.data_ptr<float>(), config.past, code.data());
  const nn::Rows& coarsest = inputs.back();
  current.resize(coarsest.count, coarsest.channels + config.hidden);
  for (int64_t i = 0; i < coarsest.count; ++i) {
    std::copy_n(coarsest.row(i), coarsest.channels, current.row(i));
    std::copy(code.begin(), code.end(), current.row(i) + coarsest.channels);
  }
  for (size_t i = 0; i < up.size(); ++i) {
    const size_t level = down.size() - 1 - i;
    up[i].propagation(clouds[level + 1], current, clouds[level], inputs[level], level == 0 ? kPositionChannels : 0,
                      spare);
    std::swap(current, spare);
    convolve(up[i].convolutions, level, current);
  }

  hidden.resize(static_cast<size_t>(count * head_in.stride()));
  const int64_t chunks = (count + kRowChunk - 1) / kRowChunk;
  nn::parallel_chunks(chunks, [&](int64_t chunk) {
    const int64_t first = chunk * kRowChunk;
    nn::apply(head_in, current.row(first), current.stride, std::min(kRowChunk, count - first),
              hidden.data() + first * head_in.stride());
  });
  torch::from_blob(hidden.data(), {count * head_in.stride()}, torch::kFloat32).tanh_();
  const float* given = contact.data_ptr<float>();
  float* result = out.data_ptr<float>();
  nn::parallel_chunks(chunks, [&](int64_t chunk) {
    static thread_local std::vector<float> rows;
    const int64_t first = chunk * kRowChunk, got = std::min(kRowChunk, count - first);
    rows.resize(static_cast<size_t>(kRowChunk * head_out.stride()));
    nn::apply(head_out, hidden.data() + first * head_in.stride(), head_in.stride(), got, rows.data());
    float turned[kTransposeBlock][kRowChunk];
    for (int64_t block = 0; block < features; block += kTransposeBlock) {
      for (int64_t n = 0; n < got; ++n) {  // the last block reads into the padding
        for (int64_t f = 0; f < kTransposeBlock; ++f) turned[f][n] = rows[n * head_out.stride() + block + f];
      }
      for (int64_t f = block; f < std::min(features, block + kTransposeBlock); ++f) {
        const int64_t place = f * count + first;
        for (int64_t n = 0; n < got; ++n) result[place + n] = given[place + n] + turned[f - block][n];
      }
    }
  });
}

FastContactNetwork::FastContactNetwork(const ContactNetwork& network) : impl_(std::make_unique<Impl>(network)) {}
FastContactNetwork::~FastContactNetwork() = default;
FastContactNetwork::FastContactNetwork(FastContactNetwork&&) noexcept = default;
FastContactNetwork& FastContactNetwork::operator=(FastContactNetwork&&) noexcept = default;

Tensor FastContactNetwork::forward(const Tensor& scene, const Tensor& contact_dct, const Tensor& past) {
  torch::NoGradGuard no_gradients;
  const Config& config = impl_->config;
  const int64_t features = static_cast<int64_t>(config.contact_coefficients) * config.joints;
  if (scene.dim() != 3 || scene.size(1) < 1 || scene.size(2) != 3 ||
      contact_dct.sizes() != at::IntArrayRef({scene.size(0), features, scene.size(1)}) ||
      past.sizes() != at::IntArrayRef({scene.size(0), config.past, config.joints, 3}))
    throw Error("forecast network: scene, contact_dct or past has the wrong shape");
  const auto plain = [](const Tensor& x) { return x.detach().to(torch::kCPU, torch::kFloat32).contiguous(); };
  const Tensor points = plain(scene), contact = plain(contact_dct), poses = plain(past);
  Tensor out = torch::empty_like(contact);
  for (int64_t b = 0; b < points.size(0); ++b) impl_->run(points[b], contact[b], poses[b], out[b]);
  return out;
}

}  // namespace inhabit::forecast
