// Skin against a room: the exact queries for every vertex, and the meter, which asks a distance field first and says
// the same. Needs nothing beyond examples/data; collisions_benchmark MOTION SCENE measures others.
#include <benchmark/benchmark.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/scene/objects.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using torch::Tensor;

/// The depth of the deepest vertex that collides, of every frame.
Tensor plain_depths(const SceneQuery& query, const Clip& clip) {
  const BodyModel& body = builtin_body();
  const Tensor trans = clip.root_path() - shaped_skeleton(body, clip.betas).offsets[0];
  const Tensor points = skin(body, clip.betas, axis_angle_to_matrix(clip.rotations), trans);
  const Tensor allowed = torch::where(supporting_skin(body), torch::tensor(static_cast<float>(kSupportedDepth)),
                                      torch::tensor(static_cast<float>(kCollisionDepth)));
  const Tensor inside = query.inside(points.view({-1, 3})), which = inside.nonzero().flatten();
  Tensor depth = torch::zeros({inside.size(0)});
  depth.index_copy_(0, which, query.closest(points.view({-1, 3}).index_select(0, which)).distances);
  depth = depth.view({clip.frames(), -1});
  return std::get<0>((depth * (depth > allowed)).max(1));
}

Scene without_floor(const Scene& scene) {
  Scene out;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name)) out.meshes.push_back(mesh);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  const torch::NoGradGuard no_gradients;
  const std::string data = INHABIT_SOURCE_DIR "/examples/data/", motion = argc > 2 ? argv[1] : data + "sit.npz";
  const Scene scene = read_scene_file(argc > 2 ? argv[2] : data + "sit_room.glb").scene;
  const Clip clip = retarget(read_clip(motion), motion);
  const SceneQuery query(without_floor(scene));
  const auto count = [&](benchmark::State& state) { state.SetItemsProcessed(state.iterations() * clip.frames()); };
  benchmark::RegisterBenchmark("collisions/plain",
                               [&](benchmark::State& state) {
                                 for (auto _ : state) benchmark::DoNotOptimize(plain_depths(query, clip));
                                 count(state);
                               })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  benchmark::RegisterBenchmark(
      "collisions/meter",
      [&](benchmark::State& state) {
        if (!torch::equal(CollisionMeter(builtin_body(), scene).measure(clip).depth, plain_depths(query, clip)))
          return state.SkipWithError("the meter says something else than the exact queries");
        for (auto _ : state)
          benchmark::DoNotOptimize(CollisionMeter(builtin_body(), scene).measure(clip));  // a new field each time
        count(state);
      })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  benchmark::RunSpecifiedBenchmarks();
}
