#include "inhabit/forecast/sample.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/data/cache.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/forecast/window_frame.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/mirror.h"
#include "inhabit/motion/resample.h"
#include "inhabit/scene/sampling.h"

namespace inhabit::forecast {
namespace {

constexpr int64_t kPoolPoints = 20000;  // a scene's points in memory: some 7,000 within 2.5 m of a person in a room
constexpr size_t kScenesKept = 4096, kClipsKept = 4096;  // at most 960 MB and 380 MB (12 s clips)

/// Joints (T, J, 3) of a window at another pace.
torch::Tensor paced_joints(const torch::Tensor& clip, const PacedWindow& window, int64_t frames) {
  std::vector<double> at;
  for (int64_t t = 0; t < frames; ++t)
    at.push_back(static_cast<double>(window.first) + static_cast<double>(t) * window.pace);
  return at_frames(clip, at);
}

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
  return torch::matmul(mirror ? mirrored_points(positions) : positions, rotation.t() * scale) + shift;
}

torch::Tensor Augmentation::joints(const torch::Tensor& positions) const {
  return (*this)(mirror ? positions.index_select(positions.dim() - 2, other_sides()) : positions);
}

torch::Tensor Augmentation::contacts(const torch::Tensor& contact_points) const {
  const torch::Tensor all =
      mirror ? contact_points.index_select(contact_points.dim() - 2, other_sides()) : contact_points;
  const torch::Tensor flag = all.narrow(-1, 3, 1);
  return torch::cat({(*this)(all.narrow(-1, 0, 3)) * flag, flag}, -1);
}

Augmentation draw_augmentation(const Config& config, std::mt19937_64& random) {
  if (!config.hips.empty()) return {yaw_matrix(uniform(random, -0.3, 0.3)), torch::zeros({3})};
  const double yaw = uniform(random, 0, M_PI), x = uniform(random, -0.5, 0.5), z = uniform(random, -0.5, 0.5);
  return {yaw_matrix(yaw), torch::tensor({x, 0., z}, torch::kFloat)};
}

struct Data::Impl {
  Config config;
  WindowSet windows;
  WindowKinds kinds{};
  mutable RecentCache<torch::Tensor> clips{
      kClipsKept, [this](const std::string& key) { return windows.load_clip(key).joints.contiguous(); }};
  mutable RecentCache<torch::Tensor> pools{kScenesKept, [this](const std::string& key) { return pool(key); }};

  torch::Tensor pool(const std::string& key) const {
    std::mt19937_64 random(1);
    return sample_points(windows.load_scene(key), kPoolPoints, random);
  }
};

Data::Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, int64_t stride)
    : impl_(new Impl{config, WindowSet(folders, split, config.frames(), stride, config.rate, [&](const Dataset& set) {
                       if (static_cast<int>(set.parents.size()) != config.joints)
                         throw Error(set.folder,
                                     fmt::format("has {} joints, the model {}", set.parents.size(), config.joints));
                     })}) {
  for (int64_t i = 0; i < size(); ++i)
    (windows().entry(i).source.empty() ? impl_->kinds.generated : impl_->kinds.recorded).push_back(i);
}

Data::~Data() = default;

const WindowSet& Data::windows() const { return impl_->windows; }

const WindowKinds& Data::kinds() const { return impl_->kinds; }

Sample Data::sample(int64_t index, uint64_t seed, bool augment, double pace) const {
  const Config& config = impl_->config;
  const WindowSet& windows = impl_->windows;
  std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(index)));
  const torch::Tensor clip = impl_->clips.get(windows.clip_key(index));
  const int64_t start = windows.place(index).start;
  Sample out;
  out.joints = pace == 1
                   ? clip.slice(0, start, start + config.frames())
                   : paced_joints(clip, paced_window(start, config.frames(), clip.size(0), pace), config.frames());
  const WindowFrame frame = window_frame(out.joints, config);
  const torch::Tensor pool = impl_->pools.get(windows.scene_key(index));
  try {
    out.points =
        frame.to_window(points_near(pool, frame.origin, config.inference.radius, config.inference.points, random()));
  } catch (const Error& e) {
    throw Error(windows.file(windows.clip_key(index)), e.what());
  }
  out.joints = frame.to_window(out.joints);
  if (augment) {
    const Augmentation moved = draw_augmentation(config, random);
    out.joints = moved.joints(out.joints);
    out.points = moved(out.points);
  }
  return out;
}

}  // namespace inhabit::forecast
