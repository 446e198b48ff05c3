#include <spdlog/spdlog.h>

#include <map>
#include <memory>

#include "inhabit/anticipate/train.h"
#include "inhabit/error.h"
#include "inhabit/forecast/train.h"
#include "inhabit/inbetween/train.h"
#include "outputs.h"
#include "verbs.h"

namespace {

void add_train_forecast(CLI::App& verb) {
  CLI::App* forecast =
      verb.add_subcommand("forecast", "Contact-aware forecasting: contact network, then motion network");
  auto options = std::make_shared<inhabit::forecast::Training>();
  auto device = std::make_shared<std::string>("cpu");
  forecast->add_option("--data", options->data, "Native data set folders")->required();
  forecast->add_option("--out", options->out, "Model file to write (.safetensors)")->required();
  forecast->add_option("--preset", options->preset, "compact or paper")
      ->check(CLI::IsMember({"compact", "paper"}))
      ->capture_default_str();
  forecast
      ->add_option("--stage", options->stage,
                   "contact, motion, adapt (motion on predicted contacts), both (these three), trajectory (LTD) or all")
      ->transform(CLI::CheckedTransformer(std::map<std::string, inhabit::forecast::Training::Stage>{
          {"contact", inhabit::forecast::Training::Stage::contact},
          {"motion", inhabit::forecast::Training::Stage::motion},
          {"trajectory", inhabit::forecast::Training::Stage::trajectory},
          {"adapt", inhabit::forecast::Training::Stage::adapt},
          {"both", inhabit::forecast::Training::Stage::both},
          {"all", inhabit::forecast::Training::Stage::all}}));
  forecast->add_option("--device", *device, "cpu or cuda")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  forecast->add_flag("--resume", options->resume, "Go on from the checkpoint beside the model file");
  forecast->add_option("--seed", options->seed, "Seed of weights, order and augmentation")
      ->check(whole_number)
      ->capture_default_str();
  forecast
      ->add_option("--contact-steps", options->contact_steps,
                   "Optimiser steps of the contact stage (default: the preset's)")
      ->check(whole_over_zero);
  forecast
      ->add_option("--motion-steps", options->motion_steps,
                   "Optimiser steps of each motion stage (default: the preset's)")
      ->check(whole_over_zero);
  forecast
      ->add_option("--adapt-steps", options->adapt_steps, "Optimiser steps of the last stage (default: the preset's)")
      ->check(whole_over_zero);
  forecast->add_option("--batch", options->batch, "Windows in a batch (default: the preset's)")->check(whole_over_zero);
  forecast->callback([options, device] {
    if (*device == "cuda" && !torch::cuda::is_available())
      throw inhabit::Error("--device cuda", "this LibTorch sees no CUDA device");
    options->device = torch::Device(*device);
    require_writable(options->out);
    if (!inhabit::forecast::train(*options)) throw CLI::RuntimeError(130);  // as shells say of what SIGINT ended
    spdlog::info("wrote {}", options->out);
  });
}

void add_train_anticipate(CLI::App& verb) {
  CLI::App* anticipate =
      verb.add_subcommand("anticipate", "Intention-driven anticipation, and the networks it is compared with");
  auto options = std::make_shared<inhabit::anticipate::Training>();
  auto settings = std::make_shared<std::vector<std::string>>();
  anticipate->add_option("--data", options->data, "cmu:FOLDER, h36m:FOLDER or a native data set folder")->required();
  anticipate->add_option("--out", options->out, "Model file to write (.safetensors)")->required();
  anticipate->add_option("--set", *settings, "Settings of the configuration, KEY=VALUE, such as gamma=5");
  anticipate->add_option("--stage", options->stage, "intention (ours), seq2seq, trajectory (LTD) or all")
      ->transform(CLI::CheckedTransformer(std::map<std::string, inhabit::anticipate::Training::Stage>{
          {"intention", inhabit::anticipate::Training::Stage::intention},
          {"seq2seq", inhabit::anticipate::Training::Stage::seq2seq},
          {"trajectory", inhabit::anticipate::Training::Stage::trajectory},
          {"all", inhabit::anticipate::Training::Stage::all}}));
  anticipate->add_flag("--resume", options->resume, "Go on from the checkpoint beside the model file");
  anticipate->add_option("--seed", options->seed, "Seed of clusters, weights, order and noise")
      ->check(whole_number)
      ->capture_default_str();
  anticipate->add_option("--steps", options->steps, "Optimiser steps of each stage (default: as for the shipped model)")
      ->check(whole_over_zero);
  anticipate->add_option("--batch", options->batch, "Windows in a batch")
      ->check(whole_over_zero)
      ->capture_default_str();
  anticipate->callback([options, settings] {
    for (const std::string& setting : *settings) inhabit::anticipate::set_field(options->config, setting);
    require_writable(options->out);
    inhabit::Notes notes;
    const bool done = inhabit::anticipate::train(*options, &notes);
    for (const std::string& note : notes) spdlog::info("{}", note);
    if (!done) throw CLI::RuntimeError(130);
    spdlog::info("wrote {}", options->out);
  });
}

void add_train_inbetween(CLI::App& verb) {
  CLI::App* inbetween = verb.add_subcommand("inbetween", "Scene-aware in-betweening: the denoiser");
  auto options = std::make_shared<inhabit::inbetween::Training>();
  auto preset = std::make_shared<std::string>("compact");
  auto without = std::make_shared<std::vector<std::string>>();
  auto t_star = std::make_shared<int>(20);
  auto noise_aware = std::make_shared<bool>(false), features = std::make_shared<bool>(false);
  inbetween->add_option("--data", options->data, "Native data set folders")->required();
  inbetween->add_option("--out", options->out, "Model file to write (.safetensors)")->required();
  inbetween->add_option("--preset", *preset, "compact or paper")
      ->check(CLI::IsMember({"compact", "paper"}))
      ->capture_default_str();
  inbetween->add_flag("--noise-aware", *noise_aware, "Key frames are noisy, and imputed down to step T* alone");
  inbetween->add_option("--t-star", *t_star, "T* of a noise-aware model")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  inbetween->add_option("--without", *without, "Leave out inputs: global, local (scene features), shape (of the body)")
      ->check(CLI::IsMember({"global", "local", "shape"}));
  inbetween->add_option("--from", options->from, "Model file of the same preset whose weights training starts from");
  inbetween->add_flag("--features", *features, "Train the motion features of the Frechet distance instead");
  inbetween->add_flag("--resume", options->resume, "Go on from the checkpoint beside the model file");
  inbetween->add_option("--seed", options->seed, "Seed of weights, order, keys and noise")
      ->check(whole_number)
      ->capture_default_str();
  inbetween->add_option("--steps", options->steps, "Optimiser steps")->check(whole_over_zero)->capture_default_str();
  inbetween->add_option("--batch", options->batch, "Windows in a batch")->check(whole_over_zero)->capture_default_str();
  inbetween->add_option("--stride", options->stride, "Frames from one window to the next")
      ->check(whole_over_zero)
      ->capture_default_str();
  inbetween->add_flag("--half", options->half, "Write weights in half precision");
  inbetween->add_flag("--bfloat16", options->bfloat16, "Faster products on CPUs with AMX, of 8 bits' precision");
  inbetween->callback([=] {
    options->config = inhabit::inbetween::preset(*preset);
    if (*noise_aware) options->config.t_star = *t_star;
    for (const std::string& input : *without)
      (input == "global"  ? options->config.global_scene
       : input == "local" ? options->config.local_scene
                          : options->config.body_shape) = false;
    require_writable(options->out);
    if (!(*features ? inhabit::inbetween::train_motion_features(*options) : inhabit::inbetween::train(*options)))
      throw CLI::RuntimeError(130);
    spdlog::info("wrote {}", options->out);
  });
}

}  // namespace

void add_train(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("train", "Train a system's networks");
  verb->require_subcommand(1);
  add_train_forecast(*verb);
  add_train_anticipate(*verb);
  add_train_inbetween(*verb);
}
