#include "inhabit/refine/contacts.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "inhabit/math/block_band.h"
#include "inhabit/math/quantile.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kSlowest = 0.1;  // m/s: what drifts more slowly than this is nobody's step, but no contact either

constexpr float kPredicted = 0.5F;        // probability
constexpr double kPredictedGlide = 0.12;  // metres

constexpr double kPalmApart = 0.02;  // metres from its place: a hand comes or goes

/// Speed in each frame, m/s, by central differences.
std::vector<double> speeds_of(const Track& track, double rate) {
  const auto frames = static_cast<int64_t>(track.size());
  std::vector<double> out(track.size(), 0);
  for (int64_t t = 0; t < frames && frames > 1; ++t) {
    const int64_t before = std::max<int64_t>(0, t - 1), after = std::min(frames - 1, t + 1);
    out[t] = (track[after] - track[before]).norm() * rate / static_cast<double>(after - before);
  }
  return out;
}

/// Stretches in which a point that is `near` stays where it is.
std::vector<Contact> still_stretches(int joint, const Track& track, const std::vector<char>& near, double rate,
                                     const ContactDetection& detection) {
  const std::vector<double> speeds = speeds_of(track, rate);
  const auto stands = [&](int64_t t, double speed) { return near[t] != 0 && speeds[t] < speed; };
  const auto shortest = static_cast<int64_t>(std::ceil(detection.shortest * rate));
  std::vector<Contact> out;
  // Frames [begin, end): stretches below `quick` that are somewhere below `slow`; those that drift, by lower speeds.
  const std::function<void(int64_t, int64_t, double, double)> search = [&](int64_t begin, int64_t end, double slow,
                                                                           double quick) {
    for (int64_t t = begin; t < end; ++t) {
      if (!stands(t, quick)) continue;
      int64_t last = t;
      bool still = false;
      Eigen::AlignedBox3d box;
      for (; last < end && stands(last, quick); ++last) {
        still = still || speeds[last] < slow;
        box.extend(track[last]);
      }
      const bool drifts = box.diagonal().norm() > detection.drift;
      if (drifts && quick > kSlowest)
        search(t, last, std::min(slow, 0.6 * quick), 0.75 * quick);
      else if (still && !drifts && last - t >= shortest)
        out.push_back({joint, t, last - 1});
      t = last;
    }
  };
  search(0, static_cast<int64_t>(track.size()), detection.slow, detection.quick);
  return out;
}

}  // namespace

Track smoothed(const Track& track, double rate, double seconds) {
  const auto frames = static_cast<int64_t>(track.size());
  if (frames < 3) return track;
  BlockBand matrix(frames, 1, 2);
  const double strength = std::pow(seconds * rate / (2 * M_PI), 4);
  constexpr std::array<double, 3> kSecond = {1, -2, 1};
  const auto fill = [&](int64_t t) {
    matrix.clear(t);
    matrix.at(t, 0)(0, 0) = 1;
    for (int m = 0; m < 3; ++m)  // second differences in which frame t is number m
      for (int n = m; n < 3 && t >= m && t - m + 2 < frames; ++n)
        matrix.at(t, n - m)(0, 0) += strength * kSecond[n] * kSecond[m];
  };
  Track out = track;
  for (int i = 0; i < 3; ++i) {
    Eigen::VectorXd x(frames);
    for (int64_t t = 0; t < frames; ++t) x[t] = track[t][i];
    matrix.solve(fill, x);
    for (int64_t t = 0; t < frames; ++t) out[t][i] = x[t];
  }
  return out;
}

double standing_height(const Track& track, const std::vector<double>& floor) {
  std::vector<double> heights;
  for (size_t t = 0; t < track.size(); ++t) heights.push_back(track[t].y() - floor[t]);
  return quantile(std::move(heights), 0.05);
}

std::vector<Contact> detect_contacts(int joint, const Track& track, const std::vector<double>& floor, double standing,
                                     double rate, const ContactDetection& detection) {
  Track level = track;
  std::vector<char> low(track.size());
  for (size_t t = 0; t < track.size(); ++t) {
    low[t] = track[t].y() - floor[t] < standing + detection.low ? 1 : 0;
    level[t].y() = 0;
  }
  return still_stretches(joint, level, low, rate, detection);
}

std::vector<Contact> predicted_contacts(int joint, const std::vector<float>& probability, const Track& track,
                                        const std::vector<double>& floor, double standing, double rate,
                                        const ContactDetection& detection) {
  const auto frames = static_cast<int64_t>(track.size());
  const auto shortest = static_cast<int64_t>(std::ceil(detection.shortest * rate));
  std::vector<Contact> out;
  for (int64_t first = 0; first < frames; ++first) {
    if (probability[first] < kPredicted) continue;
    int64_t last = first;
    while (last + 1 < frames && probability[last + 1] >= kPredicted) ++last;
    Contact contact{joint, first, last};
    first = last;
    const Vector3d place = contact_place(contact, track);
    const auto away = [&](int64_t t) {
      return track[t].y() - floor[t] > standing + detection.low ||
             std::hypot(track[t].x() - place.x(), track[t].z() - place.z()) > kPredictedGlide;
    };
    while (contact.first <= contact.last && away(contact.first)) ++contact.first;
    while (contact.last >= contact.first && away(contact.last)) --contact.last;
    if (contact.last + 1 - contact.first >= shortest) out.push_back(contact);
  }
  return out;
}

std::vector<Contact> detect_palm_contacts(int joint, const Track& track, const std::vector<double>& distances,
                                          double rate) {
  std::vector<char> near(track.size());
  for (size_t t = 0; t < track.size(); ++t) near[t] = distances[t] < kPalmDetection.low ? 1 : 0;
  std::vector<Contact> out = still_stretches(joint, track, near, rate, kPalmDetection);
  for (Contact& contact : out) {
    const Vector3d place = contact_place(contact, track);
    const auto apart = [&](int64_t t) { return (track[static_cast<size_t>(t)] - place).norm() > kPalmApart; };
    while (contact.first < contact.last && apart(contact.first)) ++contact.first;
    while (contact.last > contact.first && apart(contact.last)) --contact.last;
  }
  const auto shortest = static_cast<int64_t>(std::ceil(kPalmDetection.shortest * rate));
  std::erase_if(out, [&](const Contact& contact) { return contact.last + 1 - contact.first < shortest; });
  return out;
}

void extend_contacts(std::vector<Contact>& contacts, const Track& track, const std::vector<double>& floor,
                     double standing, double low, double near) {
  const auto frames = static_cast<int64_t>(track.size());
  for (size_t i = 0; i < contacts.size(); ++i) {
    Contact& contact = contacts[i];
    const Vector3d place = contact_place(contact, track);
    const auto stands = [&](int64_t t) {
      const Vector3d off = track[static_cast<size_t>(t)] - place;
      return track[static_cast<size_t>(t)].y() - floor[static_cast<size_t>(t)] < standing + low &&
             std::hypot(off.x(), off.z()) < near;
    };
    const int64_t begin = i > 0 ? contacts[i - 1].last + 2 : 0,
                  end = i + 1 < contacts.size() ? contacts[i + 1].first - 1 : frames;
    while (contact.first > begin && stands(contact.first - 1)) --contact.first;
    while (contact.last + 1 < end && stands(contact.last + 1)) ++contact.last;
  }
}

Vector3d contact_place(const Contact& contact, const Track& track) {
  Vector3d place;
  for (int i = 0; i < 3; ++i) {
    std::vector<double> values;
    for (int64_t t = contact.first; t <= contact.last; ++t) values.push_back(track[static_cast<size_t>(t)][i]);
    place[i] = quantile(std::move(values), 0.5);
  }
  return place;
}

}  // namespace inhabit::refine
