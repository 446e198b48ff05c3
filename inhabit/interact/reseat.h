#pragma once
#include "inhabit/interact/chair.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// How well a motion fits a chair that it was carried over to. Metres, radians.
struct ReseatFit {
  double hand_gap = 0;    ///< between the touched point of a palm and the surface, at most
  double pelvis_gap = 0;  ///< between the skin of pelvis and thighs and the seat, at most over seated frames
  double depth = 0;       ///< that the skin is in the new chair, at most over the whole clip
  double elsewhere = 0;   ///< deeper in the rest of the scene than it was before, at most
  double slide = 0;       ///< that a foot in contact is from where it stood, at most
  double beyond = 0;      ///< joint limits, over what the clip was beyond them
  double bent = 0;        ///< that a joint of spine, neck or head is rotated otherwise than it was, at most

  /// Contacts within 1 cm of the new surface, nothing deeper than 2 cm, feet within 1 cm of where they stood, joints
  /// within 0.02 rad of their limits, and those of the trunk rotated by 0.45 rad at most.
  bool good() const { return fault().empty(); }
  /// The first of these that is missed, in words; empty where none is.
  std::string fault() const;
};

/// A motion on another chair.
struct Reseated {
  Clip clip;             ///< as long as the one before
  Scene scene;           ///< the clip's, the new chair in place of the old one and of its name
  int64_t contacts = 0;  ///< stays of hands at the chair that were carried over
  int64_t lost = 0;      ///< those for which the new chair has no such place: they are contacts no more
  ReseatFit fit;         ///< how well it fits
};

/// What a motion may lose on its new chair.
struct ReseatChoices {
  bool lose_contacts = true;    ///< whether a hand for whose place the new chair has no like may touch nothing
  bool frame_by_frame = false;  ///< every frame on its own: nothing but contacts ties it to the frames beside it
};

/// Carries what a person does on a chair over to another chair (COUCH, sec. 3, after NSM): the contacts of pelvis,
/// hands and feet go to the corresponding places (chair_pair.h), and the body follows by full-body inverse kinematics,
/// all frames at once. The seat's height and depth change what the pelvis does; hands that lie on the thighs go with
/// them; feet stay. Frames before and after (over 1.5 s from a stay and its contacts) keep their bits.
/// Works on recorded and generated clips and any chair mesh.
/// @param clip on the standard skeleton with rotations, contacts and, for hands, hand targets. @param chairs holds the
/// new chair, named `chair`, anywhere. Throws Error where nobody sits, where a hand has no place and must have one, and
/// what find_chair does.
Reseated reseat(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& chair,
                const ReseatChoices& choices = {});

}  // namespace inhabit::interact
