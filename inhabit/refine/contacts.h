#pragma once
#include <cstdint>
#include <vector>

#include "inhabit/refine/trajectory.h"

namespace inhabit::refine {

/// A point that stays at one place in frames [first, last].
struct Contact {
  int joint = 0;      ///< of the standard skeleton
  int64_t first = 0;  ///< frame in which it begins
  int64_t last = 0;   ///< frame in which it ends, included
};

/// When a foot is in contact, and by other numbers a palm. Balls of the feet and ankles (heels) each for themselves, so
/// that feet roll.
struct ContactDetection {
  double low = 0.07;       ///< metres above where the joint stands, of palms from the surface: no farther
  double slow = 0.3;       ///< m/s, of feet along the floor: a contact is seen
  double quick = 0.5;      ///< m/s: it has ended
  double drift = 0.06;     ///< metres: what goes farther than this steps; its slower parts are contacts
  double shortest = 0.13;  ///< seconds
};

/// Whether a foot joint of the standard skeleton is a ball (10, 11) and no ankle (7, 8).
constexpr bool is_ball(int joint) { return joint >= 10; }
/// Of ankles, which stand for heels; the defaults are those of balls.
inline constexpr ContactDetection kHeelDetection = {0.03, 0.2, 0.3, 0.03, 0.1};

/// The track that is nearest to `track` and smooth: least sum of |x - track|^2 + (seconds rate / 2 pi)^4 |second
/// difference|^2, which keeps what lasts longer than `seconds` and takes away what is quicker.
Track smoothed(const Track& track, double rate, double seconds);

/// Height that the joint has while it stands: the 5th percentile of its heights above the floor, metres.
double standing_height(const Track& track, const std::vector<double>& floor);

/// Contacts of one joint. @param track smooth; @param floor (frames) height of the floor under it, metres.
/// @param standing see standing_height
std::vector<Contact> detect_contacts(int joint, const Track& track, const std::vector<double>& floor, double standing,
                                     double rate, const ContactDetection& detection = {});

/// Contacts of one joint that a network predicts: stretches of frames in which they are likelier than not, without the
/// frames at both ends in which the joint is more than 12 cm along the floor from its place or higher than `low`.
/// @param probability (frames); the others as of detect_contacts
std::vector<Contact> predicted_contacts(int joint, const std::vector<float>& probability, const Track& track,
                                        const std::vector<double>& floor, double standing, double rate,
                                        const ContactDetection& detection = {});

/// When a palm rests on a scene. By the labels of generated people on chairs, with noise 1 (docs/refinement.md) and
/// smoothed, 99 of 100 palms in contact are within 2.3 cm of the surface, and 99 of 100 that are slower than 0.1 m/s
/// and in none are farther than 6 cm.
inline constexpr ContactDetection kPalmDetection = {0.04, 0.1, 0.2, 0.06, 0.3};
/// Seconds that a palm's track is smoothed by before its contacts are told: what is left of noise moves a hand, at the
/// end of the longest chain of joints, faster than it may be in contact.
inline constexpr double kPalmSmoothing = 0.5;

/// Contacts of one palm with surfaces. They begin and end within 2 cm of their place.
/// @param joint its wrist; @param track of the palm, smoothed by kPalmSmoothing
/// @param distances (frames) metres to the nearest surface
std::vector<Contact> detect_palm_contacts(int joint, const Track& track, const std::vector<double>& distances,
                                          double rate);

/// Contacts made longer, at both ends, by frames in which the joint is low and near to where it stood: networks let
/// feet glide a little before they leave and when they come. No contact reaches the next one.
/// @param low metres above where the joint stands. @param near metres along the floor, of contact_place
void extend_contacts(std::vector<Contact>& contacts, const Track& track, const std::vector<double>& floor,
                     double standing, double low, double near);

/// Where a contact is: the median of each coordinate over its frames.
Eigen::Vector3d contact_place(const Contact& contact, const Track& track);

}  // namespace inhabit::refine
