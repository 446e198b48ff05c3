/* Protects the C interface as an engine's plug-in loads it, by dlopen, beside symbols of its own. */
#define LAST_ERROR dlerror
#include "check.h"

#include <dlfcn.h>
#include <string.h>

#include "inhabit.h"

/* ISO C has no conversion from an object's address to a function's. */
static void find(void* library, const char* name, void* function) {
  void* found = dlsym(library, name);
  CHECK(found != NULL);
  memcpy(function, &found, sizeof found);
}

int main(int argc, char** argv) {
  void* library;
  const char* (*last_error)(void);
  inhabit_clip* (*read)(const char*);
  int (*array)(const inhabit_clip*, const char*, inhabit_array*);
  inhabit_system* (*load)(const char*, const char*);
  inhabit_result* (*run)(const inhabit_system*, const inhabit_clip*, const inhabit_scene*, const char*);
  int64_t (*clips)(const inhabit_result*);
  void (*free_clip)(inhabit_clip*);
  void (*free_system)(inhabit_system*);
  void (*free_result)(inhabit_result*);
  inhabit_clip* clip;
  inhabit_system* system_;
  inhabit_result* result;
  inhabit_array joints;
  CHECK(argc == 2);
  library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  CHECK(library != NULL);
  find(library, "inhabit_last_error", &last_error);
  find(library, "inhabit_clip_read", &read);
  find(library, "inhabit_clip_array", &array);
  find(library, "inhabit_system_load", &load);
  find(library, "inhabit_run", &run);
  find(library, "inhabit_result_clips", &clips);
  find(library, "inhabit_clip_free", &free_clip);
  find(library, "inhabit_system_free", &free_system);
  find(library, "inhabit_result_free", &free_result);
  CHECK(dlsym(library, "_ZN7inhabit9read_clipERKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE") == NULL);
  CHECK(read("none.npz") == NULL && strstr(last_error(), "none.npz") != NULL);
  clip = read(SOURCE_DIR "/examples/data/walk.npz");
  CHECK(clip != NULL && array(clip, "joints", &joints) == 0 && joints.shape[0] == 90);
  system_ = load("anticipate", NULL);
  CHECK(system_ != NULL);
  result = run(system_, clip, NULL, "{\"samples\": 2, \"seconds\": 1, \"standard\": true}");
  CHECK(result != NULL && clips(result) == 2);
  free_result(result);
  free_system(system_);
  free_clip(clip);
  puts("loaded: all is well");
  return 0;
}
