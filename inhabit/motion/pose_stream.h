#pragma once
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "inhabit/motion/pose_window.h"
#include "inhabit/motion/usual_skeleton.h"

namespace inhabit {

/// What is the same of every stream of poses.
struct PoseStreamOptions {
  std::vector<std::string> names = {};  ///< of the joints that are pushed; empty: the standard 22
  std::vector<int> parents = {};        ///< of these, -1 for the root; empty: told by the names (usual_skeleton)
  double rate = 10;          ///< results a second of each person, by the time stamps; infinite: one for every pose
  double longest_gap = 0.5;  ///< seconds without a pose after which a person begins anew
  int people = 100;          ///< at most, at once
  double forget = 10;        ///< seconds after which somebody who was not seen makes room for somebody new
};

/// Poses of several people as they come in, and when it is time for a result of each. What the systems' streams share.
/// Not for several threads at once.
class PoseStream {
 public:
  /// @param seconds that a result looks at; @param least seconds of them that must be there. Throws Error naming the
  /// option that is out of range, and as usual_skeleton() does.
  PoseStream(const PoseStreamOptions& options, double seconds, double least);

  /// The number of joints that are pushed.
  int64_t joints() const { return order_.size(0); }

  /// PoseWindow::push() of a person, joints in the order of the names. Throws Error as it does, and where there are
  /// too many people.
  void push(const std::string& person, double time, const torch::Tensor& joints);

  /// Whether a person's next result is wanted: as soon as enough was seen, then at the rate.
  bool due(const std::string& person) const;

  /// A person whose result is wanted.
  struct Due {
    std::string person;        ///< as push() called them
    double time = 0;           ///< seconds: the time stamp of the last pose
    const PoseWindow* window;  ///< until the next push
    std::string doubt;         ///< of their first result, what is implausible(), in one line: another unit, another up
  };
  /// All of them, by name; they are not due any more.
  std::vector<Due> take();

  /// How many are known now.
  size_t people() const { return people_.size(); }

 private:
  struct Person {
    PoseWindow window;
    double next = 0;  // seconds
    bool running = false, due = false, looked_at = false;
  };
  void make_room(double before, double time);

  PoseStreamOptions options_;
  double seconds_, least_;
  Skeleton skeleton_;
  torch::Tensor order_;  // (J) int64: joint j of the skeleton is joint order_[j] of what is pushed
  std::map<std::string, Person> people_;
  double clock_ = -std::numeric_limits<double>::infinity();  // time of the pose before, seconds
};

}  // namespace inhabit
