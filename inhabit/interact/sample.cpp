#include "inhabit/interact/sample.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/interact/labels.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/mirror.h"
#include "inhabit/nn/parallel_chunks.h"

namespace inhabit::interact {
namespace {

constexpr int64_t kSequenceStep = 15;   // frames from one sequence of the same contact to the next
constexpr int64_t kSequencesAHold = 4;  // at most
constexpr float kAtRest = 0.15F;        // m/s of the root: such a clip's end may be taken to go on

/// A place in a recording.
struct FrameIndex {
  int32_t clip, frame;
};

/// Frames of a recording that have a next one, whose future is known.
int64_t usable_frames(const Recording& r) {
  const int64_t last = r.size() - 1, before = std::max<int64_t>(0, last - 9);
  const auto place = [&](int64_t t) { return r.frames[static_cast<size_t>(t)].sample.root.position; };
  const float speed = (place(last) - place(before)).norm() / 9 * static_cast<float>(r.rate);
  return std::max<int64_t>(0, last - (speed < kAtRest ? 0 : kSamples - 1 - kNow));
}

bool same_contact(const Recording::Frame& a, const Recording::Frame& b, size_t hand) {
  return a.wanted[hand] && b.wanted[hand] && (a.contact[hand] - b.contact[hand]).norm() < 1e-4F;
}

/// The room of a clip, and what stands in it for collisions.
struct Room {
  Scene scene;
  std::shared_ptr<const Surroundings> around, mirrored;

  Room() = default;
  Room(Scene read, bool with_mirrored) : scene(std::move(read)), around(std::make_shared<const Surroundings>(scene)) {
    if (with_mirrored) mirrored = std::make_shared<const Surroundings>(around->mirrored());
  }
};

}  // namespace

struct Data::Impl {
  Config config;
  InputLayout input;
  OutputLayout output;
  EgoGrid ego;
  std::vector<Recording> recordings;
  std::vector<ChairGrid> chairs;                            // of each recording
  std::vector<std::shared_ptr<const Surroundings>> around;  // of each recording
  std::vector<FrameIndex> poses, sequences, contact_sets;

  explicit Impl(const Config& c) : config(c), input(input_layout(c)), output(output_layout(c)), ego(c) {}

  /// A recording as training sees it; none where there is no chair.
  struct Part {
    Recording recording;
    ChairGrid chair;
    std::shared_ptr<const Surroundings> around;
  };

  std::optional<Part> part_of(const Clip& clip, const Scene& scene,
                              const std::shared_ptr<const Surroundings>& surroundings,
                              const std::string& subject) const {
    const std::optional<Chair> used = chair_of(clip, scene);
    std::vector<Chair> others = used ? std::vector<Chair>() : find_chairs(scene);
    if (!used && others.empty()) return std::nullopt;
    return Part{record(clip, label(clip, used), subject), sense_chair(used ? *used : others.front(), config),
                surroundings};
  }

  void add(Part part) {
    recordings.push_back(std::move(part.recording));
    chairs.push_back(std::move(part.chair));
    around.push_back(std::move(part.around));
    index(recordings.back(), static_cast<int32_t>(recordings.size() - 1));
  }

  void index(const Recording& r, int32_t clip) {
    for (int64_t t = 0; t < usable_frames(r); ++t) poses.push_back({clip, static_cast<int32_t>(t)});
    const int64_t last_start = r.size() - config.training.control_frames - 1;
    for (size_t hand = 0; hand < 2; ++hand)
      for (int64_t t = 0; t < r.size(); ++t) {
        const auto at = [&](int64_t k) -> const Recording::Frame& { return r.frames[static_cast<size_t>(k)]; };
        if (!at(t).wanted[hand] || (t > 0 && same_contact(at(t - 1), at(t), hand))) continue;
        // From here on this hand reaches for a contact.
        int64_t end = t + 1;
        while (end < r.size() && same_contact(at(end - 1), at(end), hand)) ++end;
        for (int64_t k = 0; k < kSequencesAHold && t + k * kSequenceStep < end; ++k)
          if (t + k * kSequenceStep <= last_start)
            sequences.push_back({clip, static_cast<int32_t>(t + k * kSequenceStep)});
        int64_t there = t;
        while (there < end && at(there).sample.hand_phase[hand] < 1) ++there;
        if (there < end) contact_sets.push_back({clip, static_cast<int32_t>(std::min(there + 10, end - 1))});
      }
  }

  const FrameIndex& at(const std::vector<FrameIndex>& of, int64_t i) const { return of[static_cast<size_t>(i)]; }
};

Data::Data(const std::vector<std::string>& folders, const std::string& split, const Config& config, bool with_mirrored)
    : impl_(new Impl(config)) {
  require_window(config, "configuration");
  for (const std::string& folder : folders) {
    const Dataset set = open_dataset(folder);
    if (set.rate != config.rate)
      throw Error(folder, fmt::format("has {} frames a second, the model {}", set.rate, config.rate));
    if (static_cast<int>(set.parents.size()) != config.joints)
      throw Error(folder, fmt::format("has {} joints, the model {}", set.parents.size(), config.joints));
    std::map<std::string, Room> rooms;
    std::vector<size_t> clips;
    for (const size_t c : clips_at_hand(set, split))
      if (!set.clips[c].scene.empty()) {
        clips.push_back(c);
        rooms[set.clips[c].scene];
      }
    std::vector<std::pair<const std::string, Room>*> unread;
    unread.reserve(rooms.size());
    for (auto& room : rooms) unread.push_back(&room);
    nn::parallel_chunks(static_cast<int64_t>(unread.size()), [&](int64_t i) {
      auto& [name, room] = *unread[static_cast<size_t>(i)];
      room = Room(load_scene(set, name), with_mirrored);
    });
    std::vector<std::array<std::optional<Impl::Part>, 2>> parts(clips.size());
    nn::parallel_chunks(static_cast<int64_t>(clips.size()), [&](int64_t i) {
      const DatasetClip& entry = set.clips[clips[static_cast<size_t>(i)]];
      auto& [plain, other] = parts[static_cast<size_t>(i)];
      const std::string subject = folder + "/" + entry.file;
      const Clip clip = load_clip(set, entry);
      const Room& room = rooms.at(entry.scene);
      try {
        plain = impl_->part_of(clip, room.scene, room.around, subject);
        if (with_mirrored) other = impl_->part_of(mirrored(clip), mirrored(room.scene), room.mirrored, subject);
      } catch (const Error& e) {
        throw Error(subject, e.what());
      }
    });
    for (auto& both : parts)
      for (auto& part : both)
        if (part) impl_->add(std::move(*part));
  }
}

Data::~Data() = default;

int64_t Data::clips() const { return static_cast<int64_t>(impl_->recordings.size()); }
const Recording& Data::recording(int64_t clip) const { return impl_->recordings[static_cast<size_t>(clip)]; }
Senses Data::senses(int64_t clip) const {
  const auto c = static_cast<size_t>(clip);
  return {impl_->chairs[c], impl_->ego, *impl_->around[c]};
}
const Config& Data::config() const { return impl_->config; }
Data::FramePlace Data::pose_place(int64_t index) const {
  const FrameIndex& at = impl_->at(impl_->poses, index);
  return {at.clip, at.frame};
}
int64_t Data::poses() const { return static_cast<int64_t>(impl_->poses.size()); }
int64_t Data::sequences() const { return static_cast<int64_t>(impl_->sequences.size()); }
int64_t Data::contact_sets() const { return static_cast<int64_t>(impl_->contact_sets.size()); }

PoseRows Data::pose_rows(const std::vector<int64_t>& indices) const {
  const auto rows = static_cast<int64_t>(indices.size());
  PoseRows out{torch::empty({rows, impl_->input.size}), torch::empty({rows, impl_->output.size}),
               torch::zeros({rows, 8})};
  float *input = out.input.data_ptr<float>(), *target = out.target.data_ptr<float>(),
        *contact = out.contacts.data_ptr<float>();
  for (const int64_t i : indices) {
    const FrameIndex& at = impl_->at(impl_->poses, i);
    const Recording& r = recording(at.clip);
    const State now = state_at(r, at.frame), next = state_at(r, at.frame + 1);
    build_input(impl_->input, now, senses(at.clip), input);
    build_target(impl_->output, now, next, target);
    input += impl_->input.size;
    target += impl_->output.size;
    build_contacts(now, contact);
    contact += 8;
  }
  return out;
}

ControlSequences Data::control_sequences(const std::vector<int64_t>& indices) const {
  const int64_t frames = impl_->config.training.control_frames, batch = static_cast<int64_t>(indices.size());
  ControlSequences out{torch::empty({frames, batch, kControlPose}),
                       torch::empty({frames, batch, kControlSize}),
                       torch::empty({frames, batch, kControlSize}),
                       torch::zeros({frames, batch, 2}),
                       torch::zeros({frames, batch, 2}),
                       torch::zeros({frames, batch, 2})};
  const auto row = [](torch::Tensor& of, int64_t t, int64_t b) {
    return of.data_ptr<float>() + (t * of.size(1) + b) * of.size(2);
  };
  for (int64_t b = 0; b < batch; ++b) {
    const FrameIndex& start = impl_->at(impl_->sequences, indices[static_cast<size_t>(b)]);
    const Recording& r = recording(start.clip);
    State now = state_at(r, start.frame);
    Place before = now.now().root;
    for (int64_t t = 0; t < frames; ++t) {
      const State next = state_at(r, start.frame + t + 1);
      build_control_input(now, row(out.pose, t, b), row(out.control, t, b));
      build_control_target(now, next, row(out.target, t, b));
      // v in the present axes = turned_in(turned_out_before(v)): a rotation about the vertical.
      const Eigen::Vector2f turned = now.now().root.turned_in(before.facing);  // where the old ahead is now
      row(out.rotation, t, b)[0] = turned.y();
      row(out.rotation, t, b)[1] = turned.x();
      const auto at = static_cast<size_t>(start.frame + t);
      for (size_t i = 0; i < 2; ++i) {
        const size_t hand = 1 - i;  // right first
        row(out.wanted, t, b)[i] = now.wanted[hand] ? 1.F : 0.F;
        row(out.again, t, b)[i] = t > 0 && same_contact(r.frames[at - 1], r.frames[at], hand) ? 1.F : 0.F;
      }
      before = now.now().root;
      now = next;
    }
  }
  return out;
}

ContactRows Data::contact_rows(const std::vector<int64_t>& indices) const {
  const auto rows = static_cast<int64_t>(indices.size());
  ContactRows out{torch::empty({rows, impl_->input.chair.size}), torch::empty({rows, 6})};
  for (int64_t i = 0; i < rows; ++i) {
    const FrameIndex& at = impl_->at(impl_->contact_sets, indices[static_cast<size_t>(i)]);
    const ChairGrid& chair = impl_->chairs[static_cast<size_t>(at.clip)];
    const Recording::Frame& frame = recording(at.clip).frames[static_cast<size_t>(at.frame)];
    contact_condition(chair, out.chair.data_ptr<float>() + i * impl_->input.chair.size);
    const std::array<float, 6> contacts = contacts_in_seat(chair, frame.contact, frame.wanted);
    std::copy(contacts.begin(), contacts.end(), out.contacts.data_ptr<float>() + 6 * i);
  }
  return out;
}

std::pair<FeatureScale, FeatureScale> Data::scales(int64_t rows) const {
  FeatureStatistics input, output;
  const std::vector<int64_t> chosen = spread_indices(poses(), rows);
  constexpr size_t kTogether = 512;
  for (size_t first = 0; first < chosen.size(); first += kTogether) {
    const size_t end = std::min(first + kTogether, chosen.size());
    const PoseRows some =
        pose_rows({chosen.begin() + static_cast<long>(first), chosen.begin() + static_cast<long>(end)});
    input.add(some.input);
    output.add(some.target);
  }
  const auto steady = [](FeatureScale scale, double least) {
    scale.deviation =
        torch::where(scale.deviation < 1e-5, torch::ones_like(scale.deviation), scale.deviation.clamp_min(least));
    return scale;
  };
  FeatureScale in = steady(input.scale(), 0.01), out = steady(output.scale(), 0.001);
  const InputLayout& l = impl_->input;
  for (const Span& rare : {l.goals, l.ego, l.chair, l.hands})
    in.deviation.slice(0, rare.first, rare.end()).clamp_min_(0.1);
  out.deviation.slice(0, impl_->output.goals.first, impl_->output.goals.end()).clamp_min_(0.1);
  return {in, out};
}

std::vector<int64_t> spread_indices(int64_t size, int64_t count) {
  std::vector<int64_t> out;
  count = std::min(size, count);
  for (int64_t i = 0; i < count; ++i) out.push_back(i * size / count);
  return out;
}

}  // namespace inhabit::interact
