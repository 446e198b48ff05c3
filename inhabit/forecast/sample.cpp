#include "inhabit/forecast/sample.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/data/cache.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/forecast/window_frame.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/scene/sampling.h"

namespace inhabit {
namespace {

constexpr int64_t kPoolPoints = 20000;  // a scene's points in memory: some 7,000 within 2.5 m of a person in a room
constexpr size_t kScenesKept = 4096, kClipsKept = 4096;  // at most 960 MB and 380 MB (12 s clips)

struct Window {
  int32_t set, clip, start;
};

}  // namespace

torch::Tensor points_near(const torch::Tensor& pool, const torch::Tensor& center, double radius, int64_t count,
                          uint64_t seed) {
  const torch::Tensor distance = (pool - center).square().sum(1);
  const torch::Tensor near = (distance <= radius * radius).nonzero().squeeze(1);
  const int64_t n = near.numel();
  if (n == 0) throw Error(fmt::format("no scene point lies within {} m of the person", radius));
  std::mt19937_64 random(seed);
  std::vector<int64_t> order(near.data_ptr<int64_t>(), near.data_ptr<int64_t>() + n);
  const int64_t distinct = std::min(n, count);
  for (int64_t i = 0; i < distinct; ++i)
    std::swap(order[i], order[uniform_int(random, static_cast<int>(i), static_cast<int>(n - 1))]);
  torch::Tensor chosen = torch::empty({count}, torch::kInt64);
  int64_t* out = chosen.data_ptr<int64_t>();
  for (int64_t i = 0; i < count; ++i)
    out[i] = i < distinct ? order[i] : order[uniform_int(random, 0, static_cast<int>(n - 1))];
  return pool.index_select(0, chosen);
}

torch::Tensor Augmentation::operator()(const torch::Tensor& positions) const {
  return torch::matmul(positions, turn.t()) + shift;
}

Augmentation draw_augmentation(const ForecastConfig& config, std::mt19937_64& random) {
  if (!config.hips.empty()) return {yaw_matrix(uniform(random, -0.3, 0.3)), torch::zeros({3})};
  const double yaw = uniform(random, 0, M_PI), x = uniform(random, -0.5, 0.5), z = uniform(random, -0.5, 0.5);
  return {yaw_matrix(yaw), torch::tensor({x, 0., z}, torch::kFloat)};
}

struct ForecastData::Impl {
  ForecastConfig config;
  std::vector<Dataset> sets;
  std::vector<Window> windows;
  mutable RecentCache<torch::Tensor> clips{kClipsKept, [this](const std::string& key) { return read_joints(key); }};
  mutable RecentCache<torch::Tensor> pools{kScenesKept, [this](const std::string& key) { return read_pool(key); }};

  // Keys are "set/item", where an item is a clip's number or a scene's name.
  static std::string key(int32_t set, const std::string& item) { return std::to_string(set) + "/" + item; }
  static std::pair<size_t, std::string> parts(const std::string& key) {
    const size_t slash = key.find('/');
    return {std::stoul(key.substr(0, slash)), key.substr(slash + 1)};
  }
  torch::Tensor read_joints(const std::string& k) const {
    const auto [set, clip] = parts(k);
    return load_clip(sets[set], sets[set].clips[std::stoul(clip)]).joints.contiguous();
  }
  torch::Tensor read_pool(const std::string& k) const {
    const auto [set, scene] = parts(k);
    std::mt19937_64 random(1);
    return sample_points(load_scene(sets[set], scene), kPoolPoints, random);
  }
};

ForecastData::ForecastData(const std::vector<std::string>& folders, const std::string& split,
                           const ForecastConfig& config, int64_t stride)
    : impl_(std::make_unique<Impl>()) {
  impl_->config = config;
  for (const std::string& folder : folders) {
    impl_->sets.push_back(open_dataset(folder));
    const Dataset& set = impl_->sets.back();
    if (static_cast<int>(set.parents.size()) != config.joints)
      throw Error(folder,
                  "has " + std::to_string(set.parents.size()) + " joints, the model " + std::to_string(config.joints));
    if (set.rate != config.rate)
      throw Error(folder, fmt::format("has {} frames a second, the model {}", set.rate, config.rate));
    for (size_t c = 0; c < set.clips.size(); ++c) {
      if (set.clips[c].scene.empty() || (split != "all" && set.clips[c].split != split)) continue;
      require_files(set, set.clips[c]);
      for (int64_t start = 0; start + config.past + config.future <= set.clips[c].frames; start += stride)
        impl_->windows.push_back(
            {static_cast<int32_t>(impl_->sets.size() - 1), static_cast<int32_t>(c), static_cast<int32_t>(start)});
    }
  }
}

ForecastData::~ForecastData() = default;

int64_t ForecastData::size() const { return static_cast<int64_t>(impl_->windows.size()); }

ForecastSample ForecastData::sample(int64_t index, uint64_t seed, bool augment) const {
  const ForecastConfig& config = impl_->config;
  const Window& w = impl_->windows[static_cast<size_t>(index)];
  std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(index)));
  const Dataset& set = impl_->sets[w.set];
  const DatasetClip& entry = set.clips[w.clip];
  const torch::Tensor clip = impl_->clips.get(Impl::key(w.set, std::to_string(w.clip)));
  ForecastSample out;
  out.joints = clip.slice(0, w.start, w.start + config.past + config.future);
  const WindowFrame frame = window_frame(out.joints, config);
  const torch::Tensor pool = impl_->pools.get(Impl::key(w.set, entry.scene));
  try {
    out.points = frame.to_window(points_near(pool, frame.origin, config.radius, config.points, random()));
  } catch (const Error& e) {
    throw Error(set.folder + "/" + entry.file, e.what());
  }
  out.joints = frame.to_window(out.joints);
  if (augment) {
    const Augmentation moved = draw_augmentation(config, random);
    out.joints = moved(out.joints);
    out.points = moved(out.points);
  }
  return out;
}

}  // namespace inhabit
