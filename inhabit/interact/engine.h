#pragma once
#include <array>
#include <memory>
#include <random>
#include <vector>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/interact/predictor.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// A model as it runs: networks and layouts, shared by any number of people. Safe to use from several threads.
class Engine {
 public:
  /// @param predictor what moves people. Throws Error where its network, or ControlNet beside PoseNet, is missing.
  explicit Engine(const Networks& networks, Predictor predictor = Predictor::pose);

  /// Sizes and settings of the networks.
  const Config& config() const { return networks_.config; }
  /// The networks themselves.
  const Networks& networks() const { return networks_; }
  /// Where the parts of PoseNet's input stand.
  const InputLayout& input() const { return input_; }
  /// Where the parts of its output stand.
  const OutputLayout& output() const { return output_; }
  /// The grid that people sense what is around them with.
  const EgoGrid& ego() const { return ego_; }
  bool controlled() const { return predictor_ == Predictor::pose; }  ///< ControlNet plans the hands

  /// What one person's frames are computed in, and what ControlNet carries from frame to frame.
  struct Workspace {
    /// @param seed of SAMP's z.
    explicit Workspace(const Engine& engine, uint64_t seed = 1);
    ~Workspace();
    std::vector<float> input;         ///< of PoseNet (InputLayout::size)
    std::vector<float> output;        ///< of PoseNet (OutputLayout::size)
    std::array<float, 8> contacts{};  ///< build_contacts(), for predictors that have them among the goals
    std::vector<float> memory;        ///< of ControlNet's LSTM
    std::mt19937_64 random;           ///< what SAMP draws from
    struct Networks;
    std::unique_ptr<Networks> networks;  ///< what the fast networks work in
  };

  /// The next frame: features as they are in work.input, which is overwritten, to work.output.
  void predict(Workspace& work) const;

  /// ControlNet begins a reach anew.
  void start_control(Workspace& work) const;
  /// One frame of it on features as they are (features.h): pose (66), control (56) to out (56).
  void control(const float* pose, const float* control, float* out, Workspace& work) const;

 private:
  /// What PoseNet is compared with, on a standardised row.
  void predict_baseline(Workspace& work) const;

  Networks networks_;
  Predictor predictor_;
  InputLayout input_;
  OutputLayout output_;
  EgoGrid ego_;
  struct Fast;
  std::shared_ptr<const Fast> fast_;
  std::vector<float> input_mean_, input_factor_, output_mean_, output_factor_;
};

}  // namespace inhabit::interact
