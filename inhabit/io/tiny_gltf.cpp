// The one place where tinygltf's implementation is compiled: no images, which inhabit neither reads nor writes.
#define TINYGLTF_IMPLEMENTATION
#include "inhabit/io/tiny_gltf_config.h"
