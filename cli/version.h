#pragma once
#include <torch/version.h>

#include "inhabit/version.h"

inline constexpr const char* kVersions = "inhabit " INHABIT_VERSION ", LibTorch " TORCH_VERSION;
