#pragma once
#include <memory>
#include <string>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

// The objects of a scene by name: an object is all meshes of its name, and of its name followed by ".1", ".2", ...
// Numbers of three digits and more tell copies apart, as modellers do: "chair.001" and "chair.002" are two objects.

/// "chair_0" of "chair_0.2"; "chair.002" of itself.
std::string object_of_mesh(const std::string& mesh_name);

/// True for floors, ground, rugs and carpets, however they are spelt ("Floor.001"), which feet stand on and nothing
/// collides with.
bool is_floor(const std::string& mesh_name);

/// Names of the objects of a scene that are no floor, each once, in the order of its meshes.
std::vector<std::string> object_names(const Scene& scene);

/// The scene without its floor, its points and, where one is named, an object.
Scene obstacles_of(const Scene& scene, const std::string& without = "");

/// The scene with its rooms looking in. A mesh as large as a room (1.5 x 1.8 x 1.5 m) whose faces look outwards, as
/// those of a scaled cube do, holds all that is in it; where that is most of `people`, (N, 3) places of pelvises, it is
/// turned inside out, and holds nothing (scene/solid.h).
Scene rooms_looking_in(Scene scene, const torch::Tensor& people);

/// The scene with meshes, by their numbers, turned inside out.
Scene turned_inside_out(Scene scene, const std::vector<size_t>& meshes);

/// What rooms_looking_in() asks of a scene, for several groups of people: it is made once, when it is first needed.
/// Safe to use from several threads.
class Rooms {
 public:
  /// @param scene later changes of it are not seen
  explicit Rooms(const Scene& scene);
  ~Rooms();

  /// Numbers of the meshes that are turned inside out for `people`, (N, 3) places of pelvises; ascending.
  std::vector<size_t> turned_for(const torch::Tensor& people) const;

 private:
  struct Room;
  std::vector<std::unique_ptr<Room>> rooms_;
};

/// The scene without the floor of a scan, which has no name: faces that look up from under 4 cm over `floor`, and
/// points under that.
Scene without_ground(Scene scene, double floor = 0);

}  // namespace inhabit
