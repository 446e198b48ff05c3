#pragma once
#include "inhabit/interact/chair.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// A motion on another chair, and how well it fits there.
struct Reseated {
  Clip clip;
  Scene scene;            ///< the clip's, the new chair in place of the old one and of its name
  int64_t contacts = 0;   ///< stays of hands at one place that were carried over
  int64_t lost = 0;       ///< those for which the new chair has no such place: they are contacts no more
  double hand_gap = 0;    ///< metres between the hands' skin and the points touched, at most
  double pelvis_gap = 0;  ///< metres between the height of the seated pelvis and what it should be, median over frames
  double depth = 0;       ///< metres that the skin is in the new chair, at most, beyond what it was in the old one
  double slide = 0;       ///< metres that feet in contact are from where they stood, at most

  /// Contacts within 1 cm of the new surface, nothing deeper than 2 cm, feet within 1 cm of where they stood.
  bool good() const { return hand_gap < 0.01 && pelvis_gap < 0.01 && depth < 0.02 && slide < 0.01; }
};

/// Carries what a person does on a chair over to another chair (COUCH, sec. 3, after NSM): the contacts of pelvis,
/// hands and feet go to the corresponding places, and the body follows by full-body inverse kinematics, all frames at
/// once. The new chair stands so that its seat's front edge is where the old one's is; the height of the seat changes
/// what the pelvis does, and a hand goes to the place of the new surface that lies alike from the seat. Feet stay.
/// Works on recorded and generated clips and any chair mesh.
/// @param clip on the standard skeleton with rotations, contacts and hand targets. @param chairs holds the new chair,
/// named `chair`, anywhere. @param lose_contacts whether a hand for whose place the new chair has no like may touch
/// nothing; else Error. Throws Error where nobody sits, and what find_chair does.
Reseated reseat(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& chair,
                bool lose_contacts = true);

/// The level part of a seat around where the pelvis rests, in the chair's frame, metres.
struct SeatExtent {
  double front = 0, rear = 0, left = 0, right = 0;  ///< z, z, x, x (right is negative)
};
SeatExtent seat_extent(const Chair& chair);

/// Where a place near one chair lies at another, both in their chairs' frames: along the seat in proportion, beyond its
/// edges and over it as far as before, below it in proportion of the heights.
Eigen::Vector3d corresponding(const Eigen::Vector3d& place, const SeatExtent& from, double from_height,
                              const SeatExtent& to, double to_height);

}  // namespace inhabit::interact
