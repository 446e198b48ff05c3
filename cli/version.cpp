#include <torch/version.h>

#include <cstdio>

#include "verbs.h"

void add_version(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("version", "Versions of inhabit and LibTorch");
  verb->callback([] { std::printf("inhabit 0.1.0, LibTorch %s\n", TORCH_VERSION); });
}
