#pragma once
#include <torch/version.h>

inline constexpr const char* kVersions = "inhabit " INHABIT_VERSION ", LibTorch " TORCH_VERSION;
