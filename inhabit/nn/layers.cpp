#include "inhabit/nn/layers.h"

#include "inhabit/nn/grid_conv.h"
#include "inhabit/nn/point_ops.h"

namespace inhabit::nn {

namespace tn = torch::nn;

SharedMlpImpl::SharedMlpImpl(int64_t in_channels, const std::vector<int>& widths, int dimensions) {
  for (const int width : widths) {
    if (dimensions == 1) {
      layers->push_back(tn::Conv1d(in_channels, width, 1));
      layers->push_back(BatchNorm(width));
    } else {
      layers->push_back(tn::Conv2d(in_channels, width, 1));
      layers->push_back(BatchNorm(width));
    }
    layers->push_back(tn::ReLU(tn::ReLUOptions(true)));
    in_channels = width;
  }
  register_module("layers", layers);
}

VoxelGateImpl::VoxelGateImpl(int64_t channels)
    : fc(tn::Linear(tn::LinearOptions(channels, std::max<int64_t>(1, channels / 8)).bias(false)), tn::ReLU(),
         tn::Linear(tn::LinearOptions(std::max<int64_t>(1, channels / 8), channels).bias(false)), tn::Sigmoid()) {
  register_module("fc", fc);
}

torch::Tensor VoxelGateImpl::forward(const torch::Tensor& x) {
  return x * fc->forward(x.mean({2, 3, 4})).view({x.size(0), x.size(1), 1, 1, 1});
}

PointVoxelConvImpl::PointVoxelConvImpl(int64_t in_channels, int64_t out_channels, int64_t grid_size) : grid(grid_size) {
  int64_t channels = in_channels;
  for (int i = 0; i < 2; ++i) {
    convolutions[i] = tn::Conv3d(tn::Conv3dOptions(channels, out_channels, 3).padding(1));
    norms[i] = BatchNorm(out_channels, kVoxelNormEps);
    voxel_layers->push_back(convolutions[i]);
    voxel_layers->push_back(norms[i]);
    voxel_layers->push_back(tn::LeakyReLU(tn::LeakyReLUOptions().negative_slope(kVoxelLeak)));
    channels = out_channels;
  }
  gate = VoxelGate(out_channels);
  voxel_layers->push_back(gate);
  register_module("voxel_layers", voxel_layers);
  point_features =
      register_module("point_features", SharedMlp(in_channels, std::vector<int>{static_cast<int>(out_channels)}, 1));
}

torch::Tensor PointVoxelConvImpl::convolve(const SparseMap& average, const torch::Tensor& features) {
  const std::vector<int64_t> cube{features.size(0), -1, grid, grid, grid};
  if (dense || !features.device().is_cpu()) return voxel_layers->forward(scatter(average, features).view(cube));
  torch::Tensor x = grid_conv3d_of_points(average, features, convolutions[0]->weight, convolutions[0]->bias);
  x = torch::leaky_relu(norms[0]->forward(x), kVoxelLeak);
  // Out of reach of every occupied voxel the first convolution gave its bias, so `x` has one value there.
  const torch::Tensor occupied =
      torch::zeros({features.size(0), average.inputs}, features.options()).scatter_(1, average.index.squeeze(2), 1.0);
  const torch::Tensor reached = torch::max_pool3d(occupied.view(cube), 3, 1, 1).flatten();
  const int64_t away = reached.argmin().item<int64_t>();
  const int64_t cells = grid * grid * grid;
  const torch::Tensor background = reached[away].item<float>() == 0 ? x.flatten(2)[away / cells].select(1, away % cells)
                                                                    : torch::zeros({x.size(1)}, x.options());
  x = grid_conv3d_over(background, x, convolutions[1]->weight, convolutions[1]->bias);
  return gate->forward(torch::leaky_relu(norms[1]->forward(x), kVoxelLeak));
}

PointFeatures PointVoxelConvImpl::forward(const PointFeatures& input) {
  const torch::Tensor coordinates = voxel_coordinates(input.points, grid);
  const torch::Tensor mixed = convolve(voxel_average(coordinates, grid), input.features);
  return {gather(voxel_interpolation(coordinates, grid), mixed.flatten(2)) + point_features(input.features),
          input.points};
}

SetAbstractionImpl::SetAbstractionImpl(int64_t in_channels, int64_t centre_count, double ball_radius,
                                       int64_t neighbour_count, const std::vector<int>& widths)
    : centres(centre_count), neighbours(neighbour_count), radius(ball_radius) {
  // Released weights allow several radii per level, one MLP each; only one is ever used.
  tn::ModuleList mlps;
  mlp = SharedMlp(in_channels + 3, widths, 2);
  mlps->push_back(mlp);
  register_module("mlps", mlps);
}

PointFeatures SetAbstractionImpl::forward(const PointFeatures& input) {
  const int64_t batch = input.points.size(0);
  const torch::Tensor at = select_points(input.points, furthest_points(input.points, centres));
  const torch::Tensor near = ball_neighbours(input.points, at, radius, neighbours).view({batch, centres * neighbours});
  const torch::Tensor offsets =
      select_points(input.points, near).view({batch, centres, neighbours, 3}) - at.unsqueeze(2);
  const torch::Tensor around = gather({near.unsqueeze(2), {}, input.points.size(1)}, input.features)
                                   .view({batch, input.features.size(1), centres, neighbours});
  return {mlp(torch::cat({offsets.permute({0, 3, 1, 2}), around}, 1)).amax(3), at};
}

FeaturePropagationImpl::FeaturePropagationImpl(int64_t in_channels, const std::vector<int>& widths) {
  mlp = register_module("mlp", SharedMlp(in_channels, widths, 1));
}

PointFeatures FeaturePropagationImpl::forward(const PointFeatures& coarse, const PointFeatures& fine) {
  // The first layer of the MLP over what is carried and the fine points' own features. It is linear, so the carried
  // half is had at the centres, of which there are fewer; and fine features that need no gradient get none.
  const auto& first = mlp->layers->at<tn::Conv1dImpl>(0);
  const int64_t carried = coarse.features.size(1);
  torch::Tensor x = gather(nearest_interpolation(fine.points, coarse.points),
                           torch::conv1d(coarse.features, first.weight.narrow(1, 0, carried))) +
                    torch::conv1d(fine.features, first.weight.slice(1, carried), first.bias);
  for (auto layer = std::next(mlp->layers->begin()); layer != mlp->layers->end(); ++layer) x = layer->forward(x);
  return {x, fine.points};
}

}  // namespace inhabit::nn
