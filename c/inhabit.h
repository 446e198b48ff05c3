/** \file
 * inhabit for C and for every language that calls C: human motion in 3D scenes (docs/c.md).
 *
 * Metres, seconds, radians; right-handed, +Y up, a person faces +Z at rest. Handles are opaque; the caller frees what
 * functions give. A function that fails returns NULL or -1 and inhabit_last_error() of the same thread says why, in one
 * line. Systems and scenes may be used from several threads at once, other handles from one at a time. */
#ifndef INHABIT_H
#define INHABIT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Marks what the shared library shows; no part of a function's type. */
#define INHABIT_API __attribute__((visibility("default")))

typedef struct inhabit_clip inhabit_clip;     /**< one person's motion */
typedef struct inhabit_scene inhabit_scene;   /**< what a person moves in: meshes, points, or both */
typedef struct inhabit_system inhabit_system; /**< a system with its model */
typedef struct inhabit_result inhabit_result; /**< what a system made */
typedef struct inhabit_stream inhabit_stream; /**< poses that come in one at a time */

/** The version of the library, "0.1.0". */
INHABIT_API const char* inhabit_version(void);

/** Why the last function that failed in this thread did; "" where none has. Valid until the next one fails. */
INHABIT_API const char* inhabit_last_error(void);

/* ---- Arrays ---- */

/** What an array's numbers are: float or int64_t. */
enum {
  INHABIT_FLOAT32 = 0, /**< float */
  INHABIT_INT64 = 1    /**< int64_t */
};

/** Numbers in row order that belong to a handle and live as long as it does. */
typedef struct {
  const void* data; /**< the first of them */
  int type;         /**< INHABIT_FLOAT32 or INHABIT_INT64 */
  int dims;         /**< how many numbers of `shape` count, at most 8 */
  int64_t shape[8]; /**< of each dimension, the first one first */
} inhabit_array;

/* ---- Motion ---- */

/** The motion in a file: .bvh .fbx .dae .glb .gltf .amc .npz .npy .json .txt, in the file's own skeleton and rate. */
INHABIT_API inhabit_clip* inhabit_clip_read(const char* path);

/** A motion of joint positions alone: `joints` (frames, count, 3) metres at `rate` frames a second. `names` (count) of
 * the joints, NULL: the standard 22 (count must be 22). Where a child is named before its parent the clip has its
 * joints in another order: inhabit_clip_joint_name says which. */
INHABIT_API inhabit_clip* inhabit_clip_from_joints(const float* joints, int64_t frames, const char* const* names,
                                                   int64_t count, double rate);

/** Writes it as the extension says: .npz .json .bvh .glb; a .glb holds `scene` too (may be NULL). 0, or -1. */
INHABIT_API int inhabit_clip_write(const inhabit_clip* clip, const char* path, const inhabit_scene* scene);

/** How many frames it has; -1 of NULL. */
INHABIT_API int64_t inhabit_clip_frames(const inhabit_clip* clip);
/** Frames a second; NAN of NULL. */
INHABIT_API double inhabit_clip_rate(const inhabit_clip* clip);
/** How many joints its skeleton has; -1 of NULL. */
INHABIT_API int64_t inhabit_clip_joints(const inhabit_clip* clip);
/** The name of a joint, valid as long as the clip; NULL where there is no such joint. */
INHABIT_API const char* inhabit_clip_joint_name(const inhabit_clip* clip, int64_t joint);
/** The parent of a joint (-1: none); -2 where there is no such joint. */
INHABIT_API int inhabit_clip_joint_parent(const inhabit_clip* clip, int64_t joint);

/** "joints" (T, J, 3) metres, world; "rotations" (T, J, 3) axis-angle, each relative to its parent; "trans" (T, 3);
 * "offsets" (J, 3) of the skeleton; "betas", "action", "contact", "hand_targets", "object_pose" as docs/dataset.md has
 * them. 0, or -1 where the clip has no such array. */
INHABIT_API int inhabit_clip_array(const inhabit_clip* clip, const char* name, inhabit_array* out);

/** Frees a clip and the arrays that were taken from it; NULL may be freed. */
INHABIT_API void inhabit_clip_free(inhabit_clip* clip);

/* ---- Scenes ---- */

/** A mesh (.obj .ply .glb .gltf .fbx .dae .off .stl) or point cloud (.ply .pcd .xyz .npz); unit and up axis are
 * detected. */
INHABIT_API inhabit_scene* inhabit_scene_read(const char* path);

/** A scene of `vertices` (count, 3) metres and triangles `faces` (triangles, 3), or, without triangles, of points. */
INHABIT_API inhabit_scene* inhabit_scene_from_mesh(const float* vertices, int64_t count, const int64_t* faces,
                                                   int64_t triangles);

/** Frees a scene; NULL may be freed. Streams opened with it go on. */
INHABIT_API void inhabit_scene_free(inhabit_scene* scene);

/* ---- Systems ---- */

/** `system` is "forecast", "anticipate", "inbetween", "interact" or "refine" (which has no model). `model`: a file or
 * the name of a model; NULL: the one that ships. */
INHABIT_API inhabit_system* inhabit_system_load(const char* system, const char* model);

/** Runs it on a motion in a scene (NULL: none, a flat floor is assumed). `options` is a JSON object (docs/c.md lists
 * the keys of each system) or NULL: "{\"start\": 90, \"seed\": 2}". */
INHABIT_API inhabit_result* inhabit_run(const inhabit_system* system, const inhabit_clip* clip,
                                        const inhabit_scene* scene, const char* options);

/** Frees a system; NULL may be freed. Results and streams that it made go on. */
INHABIT_API void inhabit_system_free(inhabit_system* system);

/** The motions of a result: one, of anticipation the futures, of in-betweening and interaction as many as "samples". */
INHABIT_API int64_t inhabit_result_clips(const inhabit_result* result);
/** One of them, to be freed, on the standard skeleton at the model's rate. NULL where there are not as many. */
INHABIT_API inhabit_clip* inhabit_result_clip(const inhabit_result* result, int64_t index);
/** The same on the skeleton and at the rate of the clip that was given. */
INHABIT_API inhabit_clip* inhabit_result_on_source(const inhabit_result* result, int64_t index);

/** What else a system says: forecast "points" (N, 3), "contact_points" (T, 22, 4), "joints" (T, 22, 3) before anything
 * was refined; anticipate "labels" (S, T); inbetween "keys" (K); interact "seated" (S), the frames from which the
 * person sits (-1: not at all). 0, or -1 where there is no such array. */
INHABIT_API int inhabit_result_array(const inhabit_result* result, const char* name, inhabit_array* out);

/** Frees a result and the arrays that were taken from it; NULL may be freed. Clips that it gave go on. */
INHABIT_API void inhabit_result_free(inhabit_result* result);

/* ---- Streams ---- */

/** Forecasts or futures of people whose joints come in one pose at a time. `system` is a forecast or an anticipate one;
 * the stream keeps what it needs of system and scene. `options` as of inhabit_run, and "rate", "gap", "people",
 * "names", "parents" (docs/robots.md). */
INHABIT_API inhabit_stream* inhabit_stream_open(const inhabit_system* system, const inhabit_scene* scene,
                                                const char* options);

/** A person's joints (count, 3) metres at `time` seconds; NAN: not seen. 0, or -1 where it was not taken; the stream
 * goes on. */
INHABIT_API int inhabit_stream_push(inhabit_stream* stream, const char* person, double time, const float* joints,
                                    int64_t count);

/** The next result that is due: 1 and *result (to be freed), *person (valid until the next call with this stream) and
 * *time of its last pose; 0 where none is due; -1 where this person has none, and why (person and time are set, the
 * stream goes on). What several people are due is made at once, by the first call. */
INHABIT_API int inhabit_stream_next(inhabit_stream* stream, const char** person, double* time, inhabit_result** result);

/** Frees a stream; NULL may be freed. Results that it gave go on. */
INHABIT_API void inhabit_stream_free(inhabit_stream* stream);

#ifdef __cplusplus
}
#endif

#endif
