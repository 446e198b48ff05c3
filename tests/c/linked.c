/* Protects the C interface as a C program that is linked with it uses it: files, all systems, streams, and what is said
 * of wrong arguments. */
#define LAST_ERROR inhabit_last_error
#include "check.h"

#include <math.h>
#include <string.h>

#include "inhabit.h"

#define DATA SOURCE_DIR "/examples/data/"

static int said(const char* part) { return strstr(inhabit_last_error(), part) != NULL; }

static inhabit_array array_of(const inhabit_clip* clip, const char* name) {
  inhabit_array out;
  CHECK(inhabit_clip_array(clip, name, &out) == 0);
  return out;
}

static double difference(const float* a, const float* b, int64_t count) {
  double most = 0;
  int64_t i;
  for (i = 0; i < count; ++i) most = fmax(most, fabs((double)a[i] - (double)b[i]));
  return most;
}

static void clips_and_scenes(const char* folder) {
  char path[4096];
  inhabit_clip *clip = inhabit_clip_read(DATA "walk.npz"), *again;
  inhabit_array joints, rotations, other;
  static const float corners[] = {-5, 0, -5, 5, 0, -5, 5, 0, 5, -5, 0, 5};
  static const int64_t faces[] = {0, 2, 1, 0, 3, 2}, wrong[] = {0, 1, 4};
  static const char* const human36m[] = {"Hip",    "RHip",   "RKnee",     "RFoot",  "LHip",  "LKnee",
                                         "LFoot",  "Spine",  "Thorax",    "Neck",   "Head",  "LShoulder",
                                         "LElbow", "LWrist", "RShoulder", "RElbow", "RWrist"};
  inhabit_scene* scene;
  CHECK(clip != NULL);
  CHECK(inhabit_clip_frames(clip) == 90 && inhabit_clip_rate(clip) == 30 && inhabit_clip_joints(clip) == 22);
  CHECK(strcmp(inhabit_clip_joint_name(clip, 15), "head") == 0 && inhabit_clip_joint_parent(clip, 15) == 12);
  CHECK(inhabit_clip_joint_name(clip, 22) == NULL && inhabit_clip_joint_parent(clip, -1) == -2);
  CHECK(inhabit_clip_joint_parent(clip, 0) == -1);
  joints = array_of(clip, "joints");
  CHECK(joints.type == INHABIT_FLOAT32 && joints.dims == 3);
  CHECK(joints.shape[0] == 90 && joints.shape[1] == 22 && joints.shape[2] == 3);
  rotations = array_of(clip, "rotations");
  CHECK(rotations.dims == 3 && array_of(clip, "trans").shape[1] == 3 && array_of(clip, "offsets").shape[0] == 22);
  CHECK(inhabit_clip_array(clip, "colour", &other) == -1 && said("colour") && said("joints"));

  snprintf(path, sizeof path, "%s/walk.npz", folder);
  CHECK(inhabit_clip_write(clip, path, NULL) == 0);
  again = inhabit_clip_read(path);
  CHECK(again != NULL && inhabit_clip_frames(again) == 90);
  CHECK(difference(joints.data, array_of(again, "joints").data, 90 * 22 * 3) == 0);
  inhabit_clip_free(again);
  CHECK(inhabit_clip_write(clip, "/nowhere/x.npz", NULL) == -1 && said("/nowhere/x.npz"));

  again = inhabit_clip_from_joints(joints.data, 90, NULL, 22, 30);
  CHECK(again != NULL && difference(joints.data, array_of(again, "joints").data, 90 * 22 * 3) == 0);
  inhabit_clip_free(again);
  /* Names in another order than the standard one, parents first: the clip's joints are those that were given. */
  again = inhabit_clip_from_joints(joints.data, 5, human36m, 17, 50);
  CHECK(again != NULL && difference(joints.data, array_of(again, "joints").data, 5 * 17 * 3) == 0);
  for (int j = 0; again != NULL && j < 17; ++j) CHECK(strcmp(inhabit_clip_joint_name(again, j), human36m[j]) == 0);
  inhabit_clip_free(again);
  CHECK(inhabit_clip_from_joints(joints.data, 90, NULL, 21, 30) == NULL && said("22"));
  CHECK(inhabit_clip_from_joints(joints.data, -1, NULL, 22, 30) == NULL && said("frames"));
  CHECK(inhabit_clip_from_joints(joints.data, 90, NULL, 22, -30) == NULL && said("rate"));
  CHECK(inhabit_clip_from_joints(NULL, 90, NULL, 22, 30) == NULL && said("joints: is NULL"));
  inhabit_clip_free(clip);

  CHECK(inhabit_clip_read("none.bvh") == NULL && said("none.bvh"));
  CHECK(inhabit_clip_read(NULL) == NULL && said("path: is NULL"));
  CHECK(inhabit_scene_read(DATA "walk.npz/x.glb") == NULL && said("walk.npz/x.glb"));
  scene = inhabit_scene_from_mesh(corners, 4, faces, 2);
  CHECK(scene != NULL);
  inhabit_scene_free(scene);
  CHECK(inhabit_scene_from_mesh(corners, 4, wrong, 1) == NULL && said("no vertex"));
  CHECK(inhabit_scene_from_mesh(corners, -4, faces, 2) == NULL && said("count"));
  scene = inhabit_scene_from_mesh(corners, 4, NULL, 0);
  CHECK(scene != NULL);
  inhabit_scene_free(scene);
}

/* One run of a system; its first motion. */
static inhabit_clip* first_of(const char* name, const inhabit_clip* clip, const inhabit_scene* scene,
                              const char* options, int64_t count) {
  inhabit_system* system = inhabit_system_load(name, NULL);
  inhabit_result* result;
  inhabit_clip *out, *source;
  CHECK(system != NULL);
  result = inhabit_run(system, clip, scene, options);
  CHECK(result != NULL);
  CHECK(inhabit_result_clips(result) == count);
  out = inhabit_result_clip(result, count - 1);
  CHECK(out != NULL);
  source = inhabit_result_on_source(result, count - 1);
  CHECK(source != NULL && inhabit_clip_joints(source) == 22);
  inhabit_clip_free(source);
  CHECK(inhabit_result_clip(result, count) == NULL && said("index"));
  CHECK(inhabit_run(system, clip, scene, "{\"colour\": 1}") == NULL && said("colour"));
  CHECK(inhabit_run(system, clip, scene, "{") == NULL && said("options"));
  CHECK(inhabit_run(system, clip, scene, "7") == NULL && said("options"));
  CHECK(inhabit_run(system, clip, scene, "{\"start\": -5}") == NULL && said("start"));
  CHECK(inhabit_run(system, clip, scene, "{\"standard\": \"yes\"}") == NULL && said("standard"));
  CHECK(inhabit_run(system, NULL, scene, NULL) == NULL && said("clip: is NULL"));
  inhabit_result_free(result);
  inhabit_system_free(system);
  return out;
}

static void systems(void) {
  inhabit_clip *walk = inhabit_clip_read(DATA "walk.npz"), *sitter = inhabit_clip_read(DATA "sit.npz"), *out;
  inhabit_scene *room = inhabit_scene_read(DATA "walk_room.glb"), *chairs = inhabit_scene_read(DATA "sit_room.glb");
  inhabit_system* anticipate;
  const float *before, *after;
  CHECK(walk != NULL && sitter != NULL && room != NULL && chairs != NULL);
  out = first_of("forecast", walk, room, "{\"start\": 60, \"points\": 500}", 1);
  CHECK(inhabit_clip_frames(out) == 60);
  before = (const float*)array_of(walk, "joints").data + (60 - 1) * 22 * 3;
  after = array_of(out, "joints").data;
  CHECK(difference(before, after, 22 * 3) < 0.15);
  inhabit_clip_free(out);
  out = first_of("anticipate", walk, NULL, "{\"samples\": 3, \"seconds\": 1}", 3);
  CHECK(inhabit_clip_frames(out) == 25);
  inhabit_clip_free(out);
  out = first_of("inbetween", walk, room, "{\"keys\": \"every:45\", \"samples\": 2}", 2);
  CHECK(inhabit_clip_frames(out) == 90);
  inhabit_clip_free(out);
  out = first_of("refine", walk, room, "{\"keep\": \"0\"}", 1);
  CHECK(inhabit_clip_frames(out) == 90);
  inhabit_clip_free(out);
  out = first_of("interact", sitter, chairs,
                 "{\"chair\": \"armchair_0\", \"seconds\": 2, \"left\": \"armrest\", \"standard\": false}", 1);
  CHECK(inhabit_clip_frames(out) >= 30);
  inhabit_clip_free(out);
  anticipate = inhabit_system_load("anticipate", NULL);
  CHECK(inhabit_run(anticipate, walk, NULL, "{\"samples\": 100001}") == NULL && said("samples: must be at most"));
  CHECK(inhabit_run(anticipate, walk, NULL, "{\"start\": -2}") == NULL && said("start: is under 0"));
  inhabit_system_free(anticipate);
  CHECK(inhabit_system_load("dance", NULL) == NULL && said("dance"));
  CHECK(inhabit_system_load("forecast", "none.safetensors") == NULL && said("none.safetensors"));
  CHECK(inhabit_system_load(NULL, NULL) == NULL && said("system: is NULL"));
  inhabit_scene_free(room);
  inhabit_scene_free(chairs);
  inhabit_clip_free(sitter);
  inhabit_clip_free(walk);
}

static void streams(void) {
  inhabit_clip *walk = inhabit_clip_read(DATA "walk.npz"), *out;
  inhabit_scene* room = inhabit_scene_read(DATA "walk_room.glb");
  inhabit_system *forecast = inhabit_system_load("forecast", NULL), *refine = inhabit_system_load("refine", NULL);
  inhabit_stream* stream;
  inhabit_result *result, *expected;
  inhabit_array joints = array_of(walk, "joints"), got, wanted;
  const float* poses = joints.data;
  float far[22 * 3];
  const char* person = NULL;
  double time = 0;
  int64_t t, i;
  CHECK(inhabit_stream_open(refine, room, NULL) == NULL && said("no stream"));
  CHECK(inhabit_stream_open(forecast, room, "{\"rate\": -1}") == NULL && said("rate"));
  CHECK(inhabit_stream_open(forecast, room, "{\"names\": [1]}") == NULL && said("names"));
  stream = inhabit_stream_open(forecast, room, "{\"rate\": 10, \"points\": 500}");
  CHECK(stream != NULL);
  inhabit_system_free(forecast); /* the stream goes on */
  for (t = 0; t < 30; ++t) {
    CHECK(inhabit_stream_next(stream, &person, &time, &result) == 0 && result == NULL);
    for (i = 0; i < 22 * 3; ++i) far[i] = poses[t * 66 + i] + 300;
    CHECK(inhabit_stream_push(stream, "b", (double)t / 30, poses + t * 66, 22) == 0);
    CHECK(inhabit_stream_push(stream, "a", (double)t / 30, far, 22) == 0);
  }
  CHECK(inhabit_stream_push(stream, "b", 0, poses, 22) == -1 && said("time"));
  CHECK(inhabit_stream_push(stream, "b", 1, poses, 21) == -1 && said("(22, 3)"));
  CHECK(inhabit_stream_push(stream, NULL, 1, poses, 22) == -1 && said("person"));
  CHECK(inhabit_stream_next(stream, &person, &time, &result) == -1 && said("2.50 m"));
  CHECK(strcmp(person, "a") == 0 && result == NULL);
  CHECK(inhabit_stream_next(stream, &person, &time, &result) == 1 && result != NULL);
  CHECK(strcmp(person, "b") == 0 && fabs(time - 29.0 / 30) < 1e-12);
  out = inhabit_clip_from_joints(poses, 30, NULL, 22, 30);
  forecast = inhabit_system_load("forecast", NULL);
  expected = inhabit_run(forecast, out, room, "{\"points\": 500, \"joints_alone\": true}");
  CHECK(inhabit_result_array(expected, "joints", &wanted) == 0 && inhabit_result_array(result, "joints", &got) == 0);
  CHECK(got.shape[0] == 60 && difference(got.data, wanted.data, 60 * 22 * 3) < 1e-5);
  inhabit_result_free(expected);
  inhabit_clip_free(out);
  inhabit_result_free(result);
  CHECK(inhabit_stream_next(stream, &person, &time, &result) == 0);
  CHECK(inhabit_stream_next(stream, NULL, NULL, NULL) == -1 && said("result: is NULL"));
  inhabit_stream_free(stream);
  inhabit_system_free(forecast);
  inhabit_system_free(refine);
  inhabit_scene_free(room);
  inhabit_clip_free(walk);
}

int main(int argc, char** argv) {
  CHECK(argc == 2);
  CHECK(strlen(inhabit_version()) >= 5 && strcmp(inhabit_last_error(), "") == 0);
  inhabit_clip_free(NULL);
  inhabit_scene_free(NULL);
  inhabit_system_free(NULL);
  inhabit_result_free(NULL);
  inhabit_stream_free(NULL);
  clips_and_scenes(argv[1]);
  systems();
  streams();
  puts("linked: all is well");
  return 0;
}
