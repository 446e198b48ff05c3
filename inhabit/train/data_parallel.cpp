#include "inhabit/train/data_parallel.h"

#include <cstdlib>
#include <optional>

#include "inhabit/error.h"

#ifdef INHABIT_C10D
#ifndef USE_C10D_GLOO
#define USE_C10D_GLOO  // NOLINT: what LibTorch's own build calls it
#endif
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>
#ifdef INHABIT_NCCL
#ifndef USE_C10D_NCCL
#define USE_C10D_NCCL  // NOLINT
#endif
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>
#endif
#endif

namespace inhabit {
namespace {

constexpr int kPort = 29500;

std::optional<int> number_of(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return std::nullopt;
  char* end = nullptr;
  const long value = std::strtol(text, &end, 10);
  if (end == text || *end != '\0' || value < 0 || value > 1'000'000)
    throw Error(variable, "is '" + std::string(text).substr(0, 40) + "', no whole number");
  return static_cast<int>(value);
}

std::optional<int> number_of(const char* variable, const char* other) {
  const auto value = number_of(variable);
  return value ? value : number_of(other);
}

}  // namespace

std::shared_ptr<DataParallel> DataParallel::from_environment(torch::Device& device) {
  const auto size = number_of("WORLD_SIZE", "OMPI_COMM_WORLD_SIZE");
  if (!size || *size <= 1) return nullptr;
  const auto rank = number_of("RANK", "OMPI_COMM_WORLD_RANK");
  if (!rank || *rank >= *size)
    throw Error("RANK", "must be from 0 to " + std::to_string(*size - 1) + ", as there are " + std::to_string(*size) +
                            " processes");
  const char* address = std::getenv("MASTER_ADDR");
  const int port = number_of("MASTER_PORT").value_or(kPort);
  if (port < 1 || port > 65535) throw Error("MASTER_PORT", "must be from 1 to 65535");
  if (device.is_cuda() && !device.has_index())
    device = torch::Device(
        torch::kCUDA, static_cast<c10::DeviceIndex>(number_of("LOCAL_RANK", "OMPI_COMM_WORLD_LOCAL_RANK").value_or(0)));
  return std::make_shared<DataParallel>(*rank, *size, address == nullptr ? "127.0.0.1" : address, port, device);
}

#ifdef INHABIT_C10D

struct DataParallel::Impl {
#ifdef INHABIT_NCCL
  c10::intrusive_ptr<c10d::ProcessGroupNCCL> nccl;
#endif
  c10::intrusive_ptr<c10d::ProcessGroupGloo> gloo;

  void all_reduce(torch::Tensor& t) const {
    std::vector<torch::Tensor> one{t};
#ifdef INHABIT_NCCL
    if (t.is_cuda() && nccl) {
      nccl->allreduce(one)->wait();
      return;
    }
#endif
    if (t.is_cuda()) {
      one[0] = t.cpu();
      gloo->allreduce(one)->wait();
      t.copy_(one[0]);
    } else {
      gloo->allreduce(one)->wait();
    }
  }
};

DataParallel::DataParallel(int rank, int size, const std::string& address, int port, torch::Device device)
    : impl_(std::make_unique<Impl>()), rank_(rank), size_(size) {
  try {
    c10d::TCPStoreOptions store_options;
    store_options.port = static_cast<uint16_t>(port);
    // torchrun keeps the store itself.
    const char* agents = std::getenv("TORCHELASTIC_USE_AGENT_STORE");
    store_options.isServer = rank == 0 && (agents == nullptr || std::string(agents) != "True");
    store_options.numWorkers = static_cast<size_t>(size);
    store_options.waitWorkers = false;
    const auto store = c10::make_intrusive<c10d::TCPStore>(address, store_options);
    // The store waits five minutes for the others. From then on a rank may wait for as long as another one validates.
    const auto options = c10d::ProcessGroupGloo::Options::create(std::chrono::hours(24));
    options->devices.push_back(c10d::ProcessGroupGloo::createDefaultDevice());
    options->threads = 2;
    impl_->gloo = c10::make_intrusive<c10d::ProcessGroupGloo>(store, rank, size, options);
#ifdef INHABIT_NCCL
    if (device.is_cuda()) impl_->nccl = c10::make_intrusive<c10d::ProcessGroupNCCL>(store, rank, size);
#else
    (void)device;
#endif
    wait_for_all();
  } catch (const std::exception& e) {
    const std::string reason = e.what();
    throw Error(address + ":" + std::to_string(port),
                "the ranks of this training do not come together: " + reason.substr(0, reason.find('\n')));
  }
}

void DataParallel::average(std::vector<torch::Tensor>& tensors) const {
  if (tensors.empty()) return;
  const torch::NoGradGuard no_gradients;
  std::vector<torch::Tensor> flat;
  flat.reserve(tensors.size());
  for (const torch::Tensor& t : tensors) flat.push_back(t.reshape({-1}));
  torch::Tensor all = torch::cat(flat);
  impl_->all_reduce(all);
  all.div_(size_);
  int64_t at = 0;
  for (torch::Tensor& t : tensors) {
    t.copy_(all.slice(0, at, at + t.numel()).view(t.sizes()));
    at += t.numel();
  }
}

void DataParallel::broadcast(std::vector<torch::Tensor>& tensors) const {
  const torch::NoGradGuard no_gradients;
  for (torch::Tensor& t : tensors) {
    torch::Tensor sum = rank_ == 0 ? t.clone() : torch::zeros_like(t);
    impl_->all_reduce(sum);
    t.copy_(sum);
  }
}

void DataParallel::wait_for_all() const {
  torch::Tensor nothing = torch::zeros({1});
  impl_->all_reduce(nothing);
}

#else

struct DataParallel::Impl {};
DataParallel::DataParallel(int, int, const std::string&, int, torch::Device) {
  throw Error("training", "in several processes needs inhabit built with gloo's headers (libgloo-dev)");
}
void DataParallel::average(std::vector<torch::Tensor>&) const {}
void DataParallel::broadcast(std::vector<torch::Tensor>&) const {}
void DataParallel::wait_for_all() const {}

#endif

DataParallel::~DataParallel() = default;

}  // namespace inhabit
