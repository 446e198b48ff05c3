#include "inhabit/inbetween/methods.h"

#include <sstream>
#include <utility>

#include "inhabit/error.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/interpolate_around.h"
#include "inhabit/inbetween/key_smoother.h"
#include "inhabit/io/number_text.h"
#include "inhabit/nn/used_settings.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/refine_generated.h"

namespace inhabit::inbetween {
namespace {

double temperature_named(const std::string& text) {
  double out = 0;
  if (!parse_number(text, out) || !(out >= 0 && out <= 2))
    throw Error("temperature '" + text + "'", "is no number from 0 to 2");
  return out;
}

/// Rows of a model with settings, further ones than all its rows have.
std::vector<Method> rows_with(const std::string& name, Networks networks, Options options,
                              const std::vector<std::string>& settings) {
  const bool other_detours = take_settings(settings, networks.config, options);
  return model_rows(name, networks, std::move(options), settings.empty() || other_detours);
}

}  // namespace

std::string row_name(const Config& c) {
  std::string without;
  if (!c.residual) {  // which sees all of them in another way
    if (!c.global_scene && !c.local_scene) {
      without = "scene";
    } else if (!c.global_scene) {
      without = "global feature";
    } else if (!c.local_scene) {
      without = "local feature";
    }
    if (!c.body_shape) without += (without.empty() ? "" : ", ") + std::string("body shape");
    if (!c.keys_seen) without += (without.empty() ? "" : ", ") + std::string("keys");
  }
  std::string name = without.empty() ? "ours" : "w/o " + without;
  if (c.t_star > 0) name += " (T* = " + std::to_string(c.t_star) + ")";
  return name;
}

Method model_method(const std::string& name, const std::shared_ptr<const SceneInbetweener>& model,
                    const Options& options) {
  return {
      name,
      [model, options](const FillTask& task, uint64_t seed) {
        const Window& w = task.window;
        Options own = options;
        own.keys = task.keys;
        own.seed = seed;
        if (model->config().takes_noise()) own.noise = task.noise;
        own.standard = true;
        return model->run(w.conditioning, w.scene ? *w.scene : floor_scene(), own).motion;
      },
      /*random=*/options.stage != Stage::baseline || (options.detours == Detours::learned && model->has_path_net())};
}

std::vector<Method> interpolation_methods(bool noisy) {
  using Interpolate = Clip (*)(const Clip&, const std::vector<int64_t>&);
  const auto method = [](const std::string& name, Interpolate interpolate) {
    return Method{name, [interpolate](const FillTask& task, uint64_t) {
                    return interpolate(task.window.conditioning, task.keys);
                  }};
  };
  const auto around = [](const std::string& name, Interpolate interpolate) {
    return Method{name, [interpolate](const FillTask& task, uint64_t) {
                    const Clip filled = interpolate(task.window.conditioning, task.keys);
                    if (!task.window.scene || task.window.scene->empty()) return filled;
                    return move_around_obstacles(filled, task.window.conditioning, task.keys,
                                                 SceneQuery(*task.window.scene));
                  }};
  };
  std::vector<Method> out = {method("linear + slerp", &interpolate_linear), method("cubic spline", &interpolate_spline),
                             around("slerp + detour", &interpolate_linear),
                             around("spline + detour", &interpolate_spline)};
  if (noisy)
    out.push_back({"smoother", [](const FillTask& task, uint64_t) {
                     return smooth_keys(task.window.conditioning, task.keys, task.noise);
                   }});
  return out;
}

Clip post_processed(const Clip& motion, const FillTask& task) {
  const bool whole = task.noise == 0 && task.key_joints.empty();
  refine::KeyPoses keys;
  refine::Options options;
  options.name = task.window.name;
  options.standard = true;
  options.generated = true;
  for (const int64_t key : task.keys) {
    const bool exact = whole || key == 0 || key + 1 == motion.frames();
    if (exact) options.keep_frames.push_back(key);
    if (exact || task.key_joints.empty()) {
      keys.frames.push_back(key);
      keys.exact.push_back(exact ? 1 : 0);
    } else {
      for (const refine::JointTarget& target :
           refine::joint_targets(task.window.conditioning, key, key, task.key_joints))
        keys.targets.push_back(target);
    }
  }
  keys.poses = frames_at(task.window.conditioning, keys.frames);
  refine::GeneratedOptions generated;
  if (task.noise > 0) generated.noise = task.noise;
  Clip met = refine::refine_generated(motion, keys, generated);
  met.betas = task.window.conditioning.betas;
  return refine::refine(met, task.window.scene ? *task.window.scene : Scene{}, options).clip;
}

Method with_refine(const Method& method) {
  return {method.name + " + refine",
          [run = method.run](const FillTask& task, uint64_t seed) { return post_processed(run(task, seed), task); },
          method.random};
}

std::vector<Method> interpolation_rows(bool noisy, bool refine) {
  std::vector<Method> out;
  for (const Method& method : interpolation_methods(noisy)) {
    out.push_back(method);
    if (refine) out.push_back(with_refine(method));
  }
  return out;
}

std::vector<Method> model_rows(const std::string& name, const Networks& networks, Options options, bool input) {
  const auto model = std::make_shared<SceneInbetweener>(networks);
  std::vector<Method> out;
  if (input && model->has_baseline()) {
    options.stage = Stage::baseline;
    out.push_back(model_method(name + ", input", model, options));
  }
  options.stage = Stage::network;
  out.push_back(model_method(name + ", raw", model, options));
  options.stage = Stage::finished;
  out.push_back(model_method(name, model, options));
  return out;
}

OtherSettings other_settings(const std::string& row) {
  const size_t colon = row.find(": ");
  if (colon == std::string::npos || colon == 0) throw Error("--row " + row, "is not 'NAME: KEY=VALUE ...'");
  std::istringstream rest(row.substr(colon + 2));
  OtherSettings out = {row.substr(0, colon), {}};
  for (std::string setting; rest >> setting;) out.settings.push_back(setting);
  return out;
}

bool take_settings(std::vector<std::string> settings, Config& config, Options& options) {
  bool other_detours = false;
  std::erase_if(settings, [&](const std::string& setting) {
    if (setting.starts_with("temperature=")) {
      options.temperature = temperature_named(setting.substr(12));
      return true;
    }
    if (!setting.starts_with("detours=")) return false;
    options.detours = detours_named(setting.substr(8));
    return other_detours = true;
  });
  set_used(config, settings);
  return other_detours;
}

std::vector<Method> evaluation_rows(const MeasuredModels& models, bool noisy) {
  std::vector<Method> out;
  if (!models.options.key_groups.defined()) out = interpolation_rows(noisy, models.refine);
  const auto add = [&](const std::string& name, const Networks& networks, const std::vector<std::string>& settings) {
    for (Method& row : rows_with(name, networks, models.options, settings)) out.push_back(std::move(row));
  };
  for (auto [file, networks] : models.networks) {
    if (!models.t_star.empty()) require_noise_aware(networks.config, file);
    for (const int t_star : models.t_star.empty() ? std::vector<int>{networks.config.t_star} : models.t_star) {
      networks.config.t_star = t_star;
      const std::string name = row_name(networks.config);
      add(name, networks, {});
      for (const OtherSettings& other : models.others) add(name + ", " + other.name, networks, other.settings);
    }
  }
  return out;
}

}  // namespace inhabit::inbetween
