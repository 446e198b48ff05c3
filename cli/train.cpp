#include <spdlog/spdlog.h>

#include <memory>

#include "inhabit/anticipate/train.h"
#include "inhabit/forecast/train.h"
#include "inhabit/inbetween/train.h"
#include "inhabit/interact/train.h"
#include "inhabit/io/many_files.h"
#include "inhabit/nn/device.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

/// What every system's training is asked for.
struct TrainArguments {
  inhabit::TrainRun run;
  std::string preset = "compact", device = "cpu";
  std::vector<std::string> settings;
};

/// A subcommand that trains: `train(run, config)` with the config of the preset and the settings.
template <class Preset, class Train>
void add_training(CLI::App& verb, const std::string& name, const std::string& what, const std::string& data,
                  const std::string& stages, const Preset& preset, const Train& train) {
  CLI::App* own = verb.add_subcommand(name, what);
  auto o = std::make_shared<TrainArguments>();
  // PathNet of in-betweening is trained without any.
  own->add_option("--data", o->run.data, data)->required(name != "inbetween");
  own->add_option("--out", o->run.out, "Model file to write (.safetensors)")->required();
  own->add_option("--preset", o->preset, "Configuration: compact, paper where there is one, of inbetween also features")
      ->capture_default_str();
  own->add_option("--set", o->settings,
                  "Settings of the configuration, KEY=VALUE, such as training.batch=16 (docs/training.md)");
  if (!stages.empty()) own->add_option("--stage", o->run.stages, stages);
  own->add_option("--from", o->run.from, "Model file whose weights training starts from");
  own->add_flag("--resume", o->run.resume, "Go on from the checkpoint beside the model file");
  own->add_flag(
      "--last", o->run.last,
      "End with the weights of the last step (their moving average, where the stage keeps one), not with those "
      "that validated best");
  own->add_flag("--half", o->run.half, "Write weights in half precision");
  own->add_option("--seed", o->run.seed, "Seed of weights, order and whatever else is drawn")
      ->check(whole_number)
      ->capture_default_str();
  own->add_option("--device", o->device, "cpu, cuda or cuda:N")->capture_default_str();
  own->add_option("--workers", o->run.workers, "Threads that make batches ahead, for a GPU that waits for them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  own->callback([o, preset, train] {
    auto config = preset(o->preset);
    set_fields(config, o->settings);
    o->run.data = inhabit::folders_matching(o->run.data);
    o->run.device = inhabit::nn::device_named(o->device);
    require_writable(o->run.out);
    if (shows_bars()) o->run.progress = progress_of;  // elsewhere the lines of losses say how far it is
    o->run.ranks = inhabit::DataParallel::from_environment(o->run.device);
    if (!train(o->run, config)) throw CLI::RuntimeError(130);  // as shells say of what SIGINT ended
    if (!o->run.ranks || o->run.ranks->rank() == 0) spdlog::info("wrote {}", o->run.out);
  });
}

}  // namespace

void add_train(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("train", "Train a system's networks");
  verb->require_subcommand(1);
  const std::string folders = "Native data set folders";
  add_training(
      *verb, "forecast", "Contact-aware forecasting: contact network, then motion network", folders,
      "Which of contact, motion, hypotheses (several ways to go on), ltd, hisrep, dmgnn and slt (baselines), and of "
      "preset paper no_contact and adapt (motion on predicted contacts); both: contact and motion; all (default: all "
      "but the baselines)",
      inhabit::forecast::preset, inhabit::forecast::train);
  add_training(*verb, "anticipate", "Intention-driven anticipation, and the networks it is compared with",
               "cmu:FOLDER, h36m:FOLDER or a native data set folder",
               "Which of intention (ours), and of what it is compared with seq2seq, ltd, hisrep, vae, dlow (needs "
               "vae), mix_match and grammar (default: the first four)",
               inhabit::anticipate::preset, [](inhabit::TrainRun& run, const inhabit::anticipate::Config& config) {
                 inhabit::Notes notes;
                 const bool done = inhabit::anticipate::train(run, config, &notes);
                 for (const std::string& note : notes) spdlog::info("{}", note);
                 return done;
               });
  add_training(*verb, "inbetween", "Scene-aware in-betweening: the denoiser, and what stands beside it",
               folders + " (path alone, with --from, needs none)",
               "Which of denoiser and, of residual motion, deployed (the denoiser as it is sampled in use), contacts "
               "(FootContactNet, when feet stand) and path (PathNet, detours around what stands between keys); "
               "default: all",
               inhabit::inbetween::preset, inhabit::inbetween::train);
  add_training(*verb, "interact", "Human-chair interaction: PoseNet, ControlNet and ContactNet", folders,
               "Which of pose, rollout (PoseNet on its own motion), control, contact, and of what they are compared "
               "with: nsm, nsm_control, samp, samp_control (default: the first four)",
               inhabit::interact::preset, inhabit::interact::train);
  add_training(*verb, "features", "The motion features that the Frechet distance of in-betweening is taken over",
               folders, "", inhabit::inbetween::preset, inhabit::inbetween::train_motion_features);
}
