// Headers that nearly every source needs and that are slow to parse. <torch/torch.h> is not among them: its templates
// cost every source three seconds; modules with networks have it in a precompiled header of their own.
#pragma once
#include <torch/types.h>
#include <torch/utils.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>
