#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/train/model_mean.h"
#include "verbs.h"

namespace {

struct Average {
  std::vector<std::string> models;
  std::vector<double> weights;
  std::string out;
  bool half = false;
};

}  // namespace

void add_average(CLI::App& app) {
  CLI::App* verb =
      app.add_subcommand("average", "The mean of models of one training, which often does better than each");
  auto o = std::make_shared<Average>();
  verb->add_option("models", o->models, "Model files (.safetensors) of the same configuration")->required();
  verb->add_option("--weights", o->weights, "How much each counts (default: all alike)")->expected(1, 100);
  verb->add_option("-o,--out", o->out, "Model file to write (.safetensors)")->required();
  verb->add_flag("--half", o->half, "Write weights in half precision; of one model, too");
  verb->callback([o] {
    if (o->models.size() < 2 && !o->half)
      throw inhabit::Error("models", "one is no mean: name two or more files, or --half");
    if (o->weights.empty()) o->weights.assign(o->models.size(), 1);
    inhabit::write_safetensors(o->out, inhabit::mean_of_models(o->models, o->weights), o->half);
    std::printf("%s: the mean of %zu model%s\n", o->out.c_str(), o->models.size(), o->models.size() == 1 ? "" : "s");
  });
}
