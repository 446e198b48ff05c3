/* A motion file and a room in, the next two seconds out:
 *   cc forecast.c $(pkg-config --cflags --libs inhabit) -o forecast && ./forecast walk.npz room.glb future.npz */
#include <stdio.h>

#include "inhabit.h"

static int failed(void) {
  fprintf(stderr, "%s\n", inhabit_last_error());
  return 1;
}

int main(int argc, char** argv) {
  enum { HEAD = 15, JOINTS = 22 };
  if (argc != 4) return fprintf(stderr, "usage: forecast MOTION SCENE OUT\n"), 2;

  inhabit_clip* clip = inhabit_clip_read(argv[1]);
  inhabit_scene* scene = clip ? inhabit_scene_read(argv[2]) : NULL;
  inhabit_system* system = scene ? inhabit_system_load("forecast", NULL) : NULL;
  inhabit_result* result = system ? inhabit_run(system, clip, scene, "{\"start\": 60}") : NULL;
  inhabit_clip* future = result ? inhabit_result_clip(result, 0) : NULL;
  inhabit_array joints; /* (T, 22, 3) metres */
  if (!future || inhabit_clip_array(future, "joints", &joints) != 0) return failed();
  if (inhabit_clip_write(future, argv[3], scene) != 0) return failed();

  const float* first = (const float*)joints.data + HEAD * 3;
  const float* last = first + (joints.shape[0] - 1) * JOINTS * 3;
  printf("the head goes from (%.2f, %.2f, %.2f) to (%.2f, %.2f, %.2f) in %d frames\n", first[0], first[1], first[2],
         last[0], last[1], last[2], (int)joints.shape[0]);

  inhabit_clip_free(future);
  inhabit_result_free(result);
  inhabit_system_free(system);
  inhabit_scene_free(scene);
  inhabit_clip_free(clip);
  return 0;
}
