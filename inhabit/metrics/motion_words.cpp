#include "inhabit/metrics/motion_words.h"

#include <ATen/Parallel.h>

#include <Eigen/Core>

#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/math/rotation.h"

namespace inhabit {

using torch::Tensor;

namespace {

constexpr int64_t kAxes = 31;     // with the length of the rest 32 numbers a word
constexpr int64_t kBlock = 64;    // queries at once: their bounds to 100,000 words take 25 MB
constexpr float kMargin = 1e-3F;  // of the bounds' rounding, relative to the squared lengths that they come from

using Row = Eigen::Map<const Eigen::VectorXf>;

/// Joints of words of poses: word_joints(), and of DLow's spine2, neck and head behind them.
const std::vector<int64_t>& rows_of(WordKind kind) {
  static const std::vector<int64_t> dlow = [] {
    std::vector<int64_t> rows = word_joints();
    rows.insert(rows.end(), {6, 12, 15});
    return rows;
  }();
  return kind == WordKind::dlow ? dlow : word_joints();
}

Tensor flat(const Tensor& words) { return words.to(torch::kFloat32).flatten(1).contiguous(); }

}  // namespace

const std::vector<int64_t>& word_joints() {
  static const std::vector<int64_t> joints = {1, 2, 4, 5, 7, 8, 16, 17, 18, 19, 20, 21};
  return joints;
}

Tensor motion_words(const Tensor& positions, int64_t kappa, int64_t stride) {
  std::vector<Tensor> out;
  for (int64_t first = 0; first < stride; ++first) {
    const Tensor some = positions.slice(0, std::min(first, positions.size(0)), c10::nullopt, stride);
    if (some.size(0) >= kappa) out.push_back(some.unfold(0, kappa, 1).permute({0, 3, 1, 2}));
  }
  if (out.empty()) return torch::empty({0, kappa, positions.size(1), 3}, positions.options());
  return torch::cat(out).contiguous();
}

Tensor placed_words(const Tensor& words, int64_t left_hip, int64_t right_hip) {
  const Tensor left = words.select(1, 0).select(1, left_hip),
               right = words.select(1, 0).select(1, right_hip);  // (N, 3)
  const Tensor middle = (left + right) * 0.5F, across = left - right;
  const Tensor ground = torch::tensor({1.F, 0.F, 1.F});
  const Tensor rotation = yaw_matrix(-yaw_of_left(across.to(torch::kDouble))).to(words.dtype());  // (N, 3, 3)
  const Tensor moved = words - (middle * ground).view({-1, 1, 1, 3});
  return torch::matmul(moved.flatten(1, 2), rotation.transpose(1, 2)).view_as(words);
}

Tensor word_poses(const Tensor& joints, const std::vector<int64_t>& rows) {
  const Tensor across = joints.select(1, 1) - joints.select(1, 2);                                 // hips, (T, 3)
  const Tensor rotation = yaw_matrix(-yaw_of_left(across.to(torch::kDouble))).to(joints.dtype());  // (T, 3, 3)
  const Tensor moved = joints.index_select(1, torch::tensor(rows)) - joints.narrow(1, 0, 1);
  return torch::matmul(moved, rotation.transpose(1, 2));
}

Tensor pose_words(const Tensor& joints, int64_t kappa, int64_t stride) {
  return motion_words(word_poses(joints), kappa, stride);
}

const std::map<std::string, WordKind>& word_kinds_by_name() {
  static const std::map<std::string, WordKind> all = {
      {"poses", WordKind::poses}, {"dlow", WordKind::dlow}, {"package", WordKind::package}};
  return all;
}

Tensor words_of(const Tensor& joints, int64_t kappa, WordKind kind) {
  if (kind != WordKind::package) return motion_words(word_poses(joints, rows_of(kind)), kappa);
  static const Tensor rows = torch::tensor({0, 1, 2, 4, 5, 7, 8, 10, 11, 16, 17, 18, 19, 20, 21, 15});
  return placed_words(motion_words(joints.index_select(1, rows), kappa), 1, 2);
}

Tensor database_words(const Tensor& joints, int64_t kappa, int64_t stride, WordKind kind) {
  if (kind == WordKind::package) return words_of(joints.slice(0, 0, c10::nullopt, stride), kappa, kind);
  const Tensor words = motion_words(word_poses(joints, rows_of(kind)), kappa, stride);
  Tensor other_side = torch::arange(words.size(2));
  other_side.narrow(0, 0, 12).bitwise_xor_(1);  // word_joints() has left and right in turn
  const Tensor mirrored = words.index_select(2, other_side) * torch::tensor({-1.F, 1.F, 1.F}, words.options());
  return torch::cat({words, mirrored});
}

WordIndex::WordIndex(const Tensor& words) : words_(flat(words)) {
  const torch::NoGradGuard no_gradients;
  if (words_.size(0) == 0) throw Error("the motion database has no word");
  mean_ = words_.mean(0);
  const Tensor centred = words_ - mean_;
  const Tensor covariance = centred.t().mm(centred).to(torch::kFloat64) / static_cast<double>(words_.size(0));
  const Tensor vectors = std::get<1>(torch::linalg_eigh(covariance));  // by rising eigenvalue
  const int64_t count = std::min<int64_t>(kAxes, words_.size(1));
  axes_ = vectors.slice(1, words_.size(1) - count).to(torch::kFloat32).contiguous();
  const Tensor low = projected(words_);
  low_squared_ = low.square().sum(1);
  low_ = low.t().contiguous();
}

Tensor WordIndex::projected(const Tensor& words) const {
  const Tensor centred = words - mean_, inside = centred.mm(axes_);
  const Tensor rest = (centred.square().sum(1) - inside.square().sum(1)).clamp_min(0).sqrt();
  return torch::cat({inside, rest.unsqueeze(1)}, 1);
}

Tensor WordIndex::nearest(const Tensor& queries) const {
  const torch::NoGradGuard no_gradients;
  const Tensor asked = flat(queries);
  if (asked.numel() > 0 && asked.size(1) != words_.size(1))
    throw Error("motion words of " + std::to_string(asked.size(1)) + " numbers, the database's have " +
                std::to_string(words_.size(1)));
  const int64_t count = words_.size(0), width = words_.size(1);
  const Tensor low = projected(asked), low_squared = low.square().sum(1);
  const float* word = words_.data_ptr<float>();
  const float* query = asked.data_ptr<float>();
  const float* squared = low_squared_.data_ptr<float>();
  Tensor out = torch::empty({asked.size(0)}, torch::kInt64);
  int64_t* found = out.data_ptr<int64_t>();
  Tensor products = torch::empty({kBlock, count});
  for (int64_t first = 0; first < asked.size(0); first += kBlock) {
    interruption_point();
    const int64_t some = std::min(kBlock, asked.size(0) - first);
    Tensor block = products.slice(0, 0, some);
    at::mm_out(block, low.slice(0, first, first + some), low_);
    at::parallel_for(0, some, 1, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        const Row q(query + (first + i) * width, width);
        const float own = low_squared[first + i].item<float>();
        float* bound = block.data_ptr<float>() + i * count;  // product -> least squared distance
        const auto exact = [&](int64_t n) { return (Row(word + n * width, width) - q).squaredNorm(); };
        int64_t lowest = 0;
        for (int64_t n = 0; n < count; ++n) {
          const float lengths = own + squared[n];
          bound[n] = lengths * (1 - kMargin) - 2 * bound[n];
          if (bound[n] < bound[lowest]) lowest = n;
        }
        float best = exact(lowest);
        int64_t at = lowest;
        for (int64_t n = 0; n < count; ++n) {
          if (bound[n] > best) continue;
          const float distance = exact(n);
          if (distance < best || (distance == best && n < at)) {
            best = distance;
            at = n;
          }
        }
        found[first + i] = at;
      }
    });
  }
  return out;
}

}  // namespace inhabit
