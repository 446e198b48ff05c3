#pragma once
#include <vector>

#include "inhabit/interact/chair_pair.h"
#include "inhabit/interact/insides.h"
#include "inhabit/interact/seated.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/scene_terms.h"

namespace inhabit::interact {

/// A hand at the old chair in frames [first, last].
struct Hold {
  int side = 0;                         ///< 0 left, 1 right
  int64_t first = 0;                    ///< frame
  int64_t last = 0;                     ///< frame, held too
  std::vector<Eigen::Vector3d> points;  ///< (frames) touched, world
  std::optional<CarriedTouch> to;       ///< nothing: not carried over
};

/// What is carried over of a clip: all that the person does on one chair.
struct ChairStays {
  std::string chair;        ///< its name
  std::vector<Stay> stays;  ///< on it, in order
  std::vector<Hold> holds;  ///< of hands at it
  int64_t first = 0;        ///< first frame that may change
  int64_t last = 0;         ///< last one
};
/// What a clip does on the pair's old chair: stays that rest within 1 m of it, hands that hold it, and a margin of
/// frames around both.
ChairStays stays_on(const ChairPair& chairs, const Clip& clip);

/// Full-body inverse kinematics of a clip on its new chair as a problem of refine/.
class ReseatProblem {
 public:
  /// Everything must outlive this. @param insides of the new chair; @param scene the new one
  ReseatProblem(const ChairPair& chairs, const Insides& insides, const Clip& clip, const Scene& scene,
                const ChairStays& stays, bool frame_by_frame);

  /// The whole clip's poses on the new chair.
  refine::Trajectory solve();

 private:
  void set_up(bool frame_by_frame);
  void add_place(int64_t frame, int point, const Eigen::Vector3d& target, const Eigen::Vector3d& sigma);
  void add_pelvis();
  void add_feet();
  void add_hold(const Hold& hold);
  void add_hands_on_thighs(const refine::Poses& poses);
  void add_skin(const refine::Poses& poses);
  void add_skin_plane(int64_t frame, size_t vertex, const Eigen::Vector3d& place, Eigen::Vector3d surface);
  int skin_point(size_t vertex);

  const ChairPair& chairs_;
  const Insides& insides_;
  const Clip& clip_;
  const ChairStays& stays_;
  refine::Surroundings surroundings_;
  refine::Skin skin_;
  std::vector<refine::BodyBall> balls_;
  std::vector<int> owner_;         ///< (V) the joint that moves a vertex most
  std::vector<int> vertex_point_;  ///< (V) its number among the problem's points, or -1
  refine::Trajectory start_;       ///< of the whole clip
  refine::Poses before_;
  refine::Problem problem_;
  size_t given_places_ = 0;  ///< terms that do not depend on the pose
};

/// Joints that are skinned to what one sits on.
inline bool sits_on(int joint) { return joint <= 2; }
/// (V) the joint that moves each vertex of the built-in body most.
std::vector<int> skin_owners();

}  // namespace inhabit::interact
