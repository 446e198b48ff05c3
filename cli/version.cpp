#include "version.h"

#include <cstdio>

#include "verbs.h"

void add_version(CLI::App& app) {
  app.set_version_flag("--version", kVersions);
  CLI::App* verb = app.add_subcommand("version", "Versions of inhabit and LibTorch");
  verb->callback([] { std::puts(kVersions); });
}
