#pragma once
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/synth/life_plan.h"
#include "inhabit/synth/perform.h"
#include "inhabit/synth/room.h"

namespace inhabit {

/// A body shape, (B) with at most 10 coefficients.
torch::Tensor draw_betas(const BodyModel& body, std::mt19937_64& random);

/// A person with a plan of what to do, and what it is performed with.
struct Life {
  torch::Tensor betas;                   ///< (B) shape
  std::shared_ptr<const Figure> figure;  ///< of that shape
  LifePlan plan;                         ///< what is done
  double from;                           ///< second of the plan that is the clip's first
  std::mt19937_64 sway;                  ///< what the small motions are drawn from

  /// Frames [first, last) of the clip.
  Performance performed(int first, int last) const;
  /// All frames that are planned, to the end of what is going on when the clip ends or its next chapter begins: that
  /// cannot be drawn again then.
  int planned() const;
};

/// What is wrong with a performance: radians beyond the joint limits, and metres beyond 8 mm that the body's capsules
/// are in walls and furniture (times ten); 0 when it has no fault.
double faults_of(const Room& room, const BodyModel& body, const Life& life, const Performance& performance);

/// The first of at most `tries` lives without a fault, else the one with the least. @param least what that one has
Life draw_faultless(int tries, const std::function<Life()>& draw, const std::function<double(const Life&)>& faults,
                    double* least = nullptr);

/// The clip of a performance with every annotation. @param used furniture whose place is told, indices into
/// Room::furniture.
Clip clip_of(const Room& room, const BodyModel& body, const torch::Tensor& betas, const Performance& performance,
             const std::vector<int>& used);

}  // namespace inhabit
