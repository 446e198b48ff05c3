#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "inhabit/anticipate/intention_anticipator.h"
#include "inhabit/forecast/contact_forecaster.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/interact/chair_interactor.h"
#include "inhabit/scene/query.h"

namespace inhabit::serve {

/// Something to sit on, and its surface for contacts.
struct Seat {
  interact::Chair chair;  ///< the seat and its place
  SceneQuery surface;     ///< of it alone
};

/// Model files. Without one of the last three its preview is not offered.
struct ModelFiles {
  std::string interact;    ///< what moves people
  std::string forecast;    ///< of the preview of two seconds
  std::string inbetween;   ///< of moving to a pose
  std::string anticipate;  ///< of the preview of futures
};

/// `given`, with the files that ship in place of those left empty: of the last three where they are there.
/// Throws Error where a file is given that is not there, or there is none of the first.
ModelFiles with_shipped(ModelFiles given);

/// What all people of a server share: a scene whose floor is y = 0, and the systems. Safe to use from several threads.
struct World {
  Scene scene;                                                  ///< floor at y = 0
  std::shared_ptr<const interact::Surroundings> around;         ///< what people may run into
  std::vector<Seat> seats;                                      ///< all that one can sit on
  interact::ChairInteractor interactor;                         ///< moves people
  std::optional<forecast::ContactForecaster> forecaster;        ///< none: no such preview
  std::optional<inbetween::SceneInbetweener> inbetweener;       ///< none: poses cannot be moved to
  std::optional<anticipate::IntentionAnticipator> anticipator;  ///< none: no such preview
  Clip person;               ///< one frame: who everybody is at first, standing at a free place
  Eigen::Vector2d low;       ///< (x, z) metres, corner of the rectangle that places on the floor are in
  Eigen::Vector2d high;      ///< its opposite corner
  std::jthread preparation;  ///< of `around`, so that nobody stands still at every new place; stops with the world

  /// Throws Error naming the seats there are where none has this name.
  const Seat& seat(const std::string& name) const;
  /// Whether somebody can stand at (x, z): nothing is within a shoulder's width, and it is in the scene.
  bool free_at(const Eigen::Vector2d& place) const;
};

/// A room with an armchair, a chair, a stool and a sofa.
Scene default_room();

/// @param scene as read; it is moved so that what its seats stand on is y = 0. Throws Error where it holds no surface,
/// nobody can stand in it, or a model file is none.
std::shared_ptr<const World> make_world(const Scene& scene, const ModelFiles& models);

/// The same with a model in memory and no previews.
std::shared_ptr<const World> make_world(const Scene& scene, interact::ChairInteractor interactor);

}  // namespace inhabit::serve
