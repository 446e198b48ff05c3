#include <spdlog/spdlog.h>

#include <map>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/forecast/train.h"
#include "outputs.h"
#include "verbs.h"

void add_train(CLI::App& app) {
  using inhabit::ForecastTraining;
  CLI::App* verb = app.add_subcommand("train", "Train a system's networks");
  verb->require_subcommand(1);
  CLI::App* forecast =
      verb->add_subcommand("forecast", "Contact-aware forecasting: contact network, then motion network");
  auto options = std::make_shared<ForecastTraining>();
  auto device = std::make_shared<std::string>("cpu");
  forecast->add_option("--data", options->data, "Native data set folders")->required();
  forecast->add_option("--out", options->out, "Model file to write (.safetensors)")->required();
  forecast->add_option("--preset", options->preset, "compact or paper")
      ->check(CLI::IsMember({"compact", "paper"}))
      ->capture_default_str();
  forecast
      ->add_option("--stage", options->stage,
                   "contact, motion, adapt (motion on predicted contacts) or all of them, both")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, ForecastTraining::Stage>{{"contact", ForecastTraining::Stage::contact},
                                                         {"motion", ForecastTraining::Stage::motion},
                                                         {"adapt", ForecastTraining::Stage::adapt},
                                                         {"both", ForecastTraining::Stage::both}}));
  forecast->add_option("--device", *device, "cpu or cuda")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  forecast->add_flag("--resume", options->resume, "Go on from the checkpoint beside the model file");
  forecast->add_option("--seed", options->seed, "Seed of weights, order and augmentation")->capture_default_str();
  forecast
      ->add_option("--contact-steps", options->contact_steps,
                   "Optimiser steps of the contact stage (default: the preset's)")
      ->check(CLI::PositiveNumber);
  forecast
      ->add_option("--motion-steps", options->motion_steps,
                   "Optimiser steps of each motion stage (default: the preset's)")
      ->check(CLI::PositiveNumber);
  forecast
      ->add_option("--adapt-steps", options->adapt_steps, "Optimiser steps of the last stage (default: the preset's)")
      ->check(CLI::PositiveNumber);
  forecast->add_option("--batch", options->batch, "Windows in a batch (default: the preset's)")
      ->check(CLI::PositiveNumber);
  forecast->callback([options, device] {
    if (*device == "cuda" && !torch::cuda::is_available())
      throw inhabit::Error("--device cuda", "this LibTorch sees no CUDA device");
    options->device = torch::Device(*device);
    require_writable(options->out);
    if (!inhabit::train_forecast(*options)) throw CLI::RuntimeError(130);  // as shells say of what SIGINT ended
    spdlog::info("wrote {}", options->out);
  });
}
