#include "inhabit/forecast/network.h"

#include "inhabit/error.h"
#include "inhabit/math/dct.h"
#include "inhabit/nn/last_state.h"

namespace inhabit::forecast {

namespace tn = torch::nn;
using torch::Tensor;

namespace {

int64_t features_per_point(const Config& config) {
  return static_cast<int64_t>(config.contact_coefficients) * config.joints;
}

/// A level is a list of modules, unless it has only one: so the released parameters are numbered.
void register_level(tn::ModuleList& list, const std::vector<std::shared_ptr<tn::Module>>& modules) {
  if (modules.size() == 1) {
    list->push_back(modules.front());
    return;
  }
  tn::ModuleList level;
  for (const auto& module : modules) level->push_back(module);
  list->push_back(level.ptr());
}

std::vector<nn::PointVoxelConv> make_convolutions(const std::optional<PointVoxelSpec>& spec, int64_t& channels,
                                                  std::vector<std::shared_ptr<tn::Module>>& modules) {
  std::vector<nn::PointVoxelConv> convolutions;
  for (int i = 0; spec && i < spec->blocks; ++i) {
    convolutions.emplace_back(channels, spec->channels, spec->grid);
    modules.push_back(convolutions.back().ptr());
    channels = spec->channels;
  }
  return convolutions;
}

Tensor expect(const Tensor& tensor, at::IntArrayRef sizes, const char* what) {
  bool good = tensor.defined() && tensor.dim() == static_cast<int64_t>(sizes.size());
  for (size_t i = 0; good && i < sizes.size(); ++i)
    good = sizes[i] < 0 || tensor.size(static_cast<int64_t>(i)) == sizes[i];
  if (!good) throw Error(std::string("forecast network: ") + what + " has the wrong shape");
  return tensor;
}

}  // namespace

Tensor local_pose(const Tensor& joints, int root) {
  const Tensor path = joints.slice(-2, root, root + 1);
  const Tensor relative = joints - path;
  return torch::cat({relative.slice(-2, 0, root), path, relative.slice(-2, root + 1)}, -2);
}

PointEncoderImpl::PointEncoderImpl(const Config& config) {
  tn::ModuleList sa_layers;
  int64_t channels = 3 + features_per_point(config);
  for (const AbstractionSpec& spec : config.abstraction) {
    level_channels.push_back(channels);
    std::vector<std::shared_ptr<tn::Module>> modules;
    Level level;
    level.convolutions = make_convolutions(spec.convolution, channels, modules);
    level.abstraction = nn::SetAbstraction(channels, spec.centres, spec.radius, spec.neighbours, spec.mlp);
    channels = spec.mlp.back();
    modules.push_back(level.abstraction.ptr());
    register_level(sa_layers, modules);
    levels.push_back(std::move(level));
  }
  level_channels.push_back(channels);
  register_module("sa_layers", sa_layers);
}

std::vector<nn::PointFeatures> PointEncoderImpl::forward(const nn::PointFeatures& input) {
  std::vector<nn::PointFeatures> inputs{input};
  for (Level& level : levels) {
    nn::PointFeatures x = inputs.back();
    for (nn::PointVoxelConv& convolution : level.convolutions) x = convolution(x);
    inputs.push_back(level.abstraction(x));
  }
  return inputs;
}

PointDecoderImpl::PointDecoderImpl(const Config& config, const std::vector<int64_t>& level_channels) {
  tn::ModuleList fp_layers;
  channels = level_channels.back();
  for (size_t i = 0; i < config.propagation.size(); ++i) {
    const PropagationSpec& spec = config.propagation[i];
    std::vector<std::shared_ptr<tn::Module>> modules;
    Level level;
    level.propagation = nn::FeaturePropagation(channels + level_channels[level_channels.size() - 2 - i], spec.mlp);
    channels = spec.mlp.back();
    modules.push_back(level.propagation.ptr());
    level.convolutions = make_convolutions(spec.convolution, channels, modules);
    register_level(fp_layers, modules);
    levels.push_back(std::move(level));
  }
  register_module("fp_layers", fp_layers);
}

Tensor PointDecoderImpl::forward(const std::vector<nn::PointFeatures>& encoded) {
  nn::PointFeatures x = encoded.back();
  for (size_t i = 0; i < levels.size(); ++i) {
    x = levels[i].propagation(x, encoded[encoded.size() - 2 - i]);
    for (nn::PointVoxelConv& convolution : levels[i].convolutions) x = convolution(x);
  }
  return x.features;
}

ContactNetworkImpl::ContactNetworkImpl(const Config& given) : config(given) {
  validate(config, "forecast network");
  const int64_t features = features_per_point(config);
  x_enc = register_module("x_enc", tn::Linear(config.joints * 3, config.hidden));
  x_gru = register_module("x_gru", tn::GRU(config.hidden, config.hidden));
  pointnet_sa = register_module("pointnet_sa", PointEncoder(config));
  // The finest level joins the contact features without positions, the coarsest the code of the past motion.
  std::vector<int64_t> channels = pointnet_sa->level_channels;
  channels.front() = features;
  channels.back() += config.hidden;
  pointnet_fp = register_module("pointnet_fp", PointDecoder(config, channels));
  out_mlp->push_back(tn::Linear(pointnet_fp->channels, config.hidden));
  out_mlp->push_back(tn::Tanh());
  out_mlp->push_back(tn::Linear(config.hidden, features));
  register_module("out_mlp", out_mlp);
}

Tensor ContactNetworkImpl::forward(const Tensor& scene, const Tensor& contact_dct, const Tensor& past) {
  const int64_t batch = expect(scene, {-1, -1, 3}, "scene").size(0), count = scene.size(1);
  expect(contact_dct, {batch, features_per_point(config), count}, "contact_dct");
  expect(past, {batch, config.past, config.joints, 3}, "past");
  const Tensor code = nn::last_state(x_gru, x_enc->forward(local_pose(past, config.root).flatten(2)));
  std::vector<nn::PointFeatures> levels =
      pointnet_sa->forward({torch::cat({scene.transpose(1, 2), contact_dct}, 1), scene});
  levels.front().features = contact_dct;
  Tensor& coarsest = levels.back().features;
  coarsest = torch::cat({coarsest, code.unsqueeze(2).expand({batch, code.size(1), coarsest.size(2)})}, 1);
  const Tensor features = pointnet_fp->forward(levels);
  // The MLP of every point with channels before points, as they lie: large maps are never transposed.
  const auto linear = [batch](const tn::LinearImpl& layer, const Tensor& x, const Tensor& base) {
    const Tensor weight = layer.weight.unsqueeze(0).expand({batch, layer.weight.size(0), layer.weight.size(1)});
    return torch::baddbmm(base + layer.bias.unsqueeze(1), weight, x);
  };
  const Tensor hidden = torch::tanh(linear(out_mlp->at<tn::LinearImpl>(0), features, torch::zeros({})));
  return linear(out_mlp->at<tn::LinearImpl>(2), hidden, contact_dct);
}

MotionNetworkImpl::MotionNetworkImpl(const Config& given, bool contact) : config(given), with_contact(contact) {
  validate(config, "forecast network");
  const int hidden = config.hidden, pose = config.joints * 3, touch = with_contact ? config.joints * 4 : 0;
  x_enc = register_module("x_enc", tn::Linear(pose, hidden));
  x_gru = register_module("x_gru", tn::GRU(hidden, hidden));
  if (with_contact) {
    cont_enc = register_module("cont_enc", tn::Linear(touch, hidden));
    cont_gru = register_module("cont_gru", tn::GRU(hidden, hidden));
  }
  const auto push_layer = [hidden](tn::Sequential& layers, int inputs) {
    layers->push_back(tn::Linear(inputs, hidden));
    layers->push_back(nn::BatchNorm(hidden));
    layers->push_back(tn::Tanh());
  };
  push_layer(g_w1, config.root_coefficients * 3 + hidden + (with_contact ? hidden : 0));
  for (tn::Sequential* block : {&g_w2, &g_w3}) {
    push_layer(*block, hidden);
    push_layer(*block, hidden);
  }
  register_module("g_w1", g_w1);
  register_module("g_w2", g_w2);
  register_module("g_w3", g_w3);
  g_w4 = register_module("g_w4", tn::Linear(hidden, config.root_coefficients * 3));
  out_enc = register_module("out_enc", tn::Linear(pose + 3 + touch, hidden));
  out_gru = register_module("out_gru", tn::GRUCell(hidden, hidden));
  out_mlp = register_module("out_mlp", tn::Linear(hidden, pose));
}

MotionNetworkImpl::Codes MotionNetworkImpl::encode(const Tensor& past, const Tensor& contact_points) {
  const int64_t batch = expect(past, {-1, config.past, config.joints, 3}, "past").size(0);
  if (with_contact) expect(contact_points, {batch, config.future, config.joints, 4}, "contact_points");
  Codes codes;
  codes.local = local_pose(past, config.root).flatten(2);
  codes.past = nn::last_state(x_gru, x_enc->forward(codes.local));
  const Tensor padded_dct = padded_dct_matrix(config.past, config.future, config.root_coefficients).to(past.device());
  const Tensor path_dct = padded_dct.matmul(past.select(2, config.root)).flatten(1);
  std::vector<Tensor> inputs{path_dct, codes.past};
  if (with_contact) inputs.push_back(nn::last_state(cont_gru, cont_enc->forward(contact_points.flatten(2))));
  Tensor h = g_w1->forward(torch::cat(inputs, 1));
  h = g_w2->forward(h) + h;
  h = g_w3->forward(h) + h;
  const Tensor coefficients = (g_w4->forward(h) + path_dct).view({batch, config.root_coefficients, 3});
  codes.root_path = idct_matrix(config.frames(), config.root_coefficients).to(past.device()).matmul(coefficients);
  return codes;
}

MotionForecast MotionNetworkImpl::forward(const Tensor& past, const Tensor& contact_points) {
  const Codes codes = encode(past, contact_points);
  const Tensor future_path = codes.root_path.slice(1, config.past);
  // What does not depend on the decoded pose enters all frames at once.
  const int64_t pose = config.joints * 3;
  std::vector<Tensor> known{future_path};
  if (with_contact) known.push_back(contact_points.flatten(2));
  const Tensor given =
      torch::nn::functional::linear(torch::cat(known, 2), out_enc->weight.slice(1, pose), out_enc->bias);
  const Tensor pose_weight = out_enc->weight.slice(1, 0, pose).t();
  Tensor pose_now = codes.local.select(1, config.past - 1), state = codes.past;
  std::vector<Tensor> poses;
  for (int t = 0; t < config.future; ++t) {
    const Tensor input = torch::addmm(given.select(1, t), pose_now, pose_weight);
    const Tensor next = out_gru->forward(input, config.decode_from_past ? codes.past : state);
    state = next;
    pose_now = pose_now + out_mlp->forward(next);
    poses.push_back(pose_now);
  }
  return {codes.root_path, torch::stack(poses, 1).view({past.size(0), config.future, config.joints, 3})};
}

Tensor forecast_joints(const MotionForecast& forecast, int root) {
  const int64_t future = forecast.local.size(1);
  const Tensor path = forecast.root_path.slice(1, forecast.root_path.size(1) - future).unsqueeze(2);
  return torch::cat({forecast.local.slice(2, 0, root) + path, path, forecast.local.slice(2, root + 1) + path}, 2);
}

}  // namespace inhabit::forecast
