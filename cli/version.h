#pragma once
#include <torch/version.h>

inline constexpr const char* kVersions = "inhabit 0.1.0, LibTorch " TORCH_VERSION;
