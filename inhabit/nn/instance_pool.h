#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace inhabit::nn {

/// Instances of a type that keeps workspaces, so that several threads can use a facade at once: each takes one for as
/// long as it needs it, made when none is free, and later calls find the workspaces warm.
template <class T>
class InstancePool {
 public:
  explicit InstancePool(std::function<T()> make) : make_(std::move(make)) {
    free_.push_back(std::make_unique<T>(make_()));
  }

  /// An instance, given back when this goes.
  class Lease {
   public:
    Lease(InstancePool& pool, std::unique_ptr<T> instance) : pool_(pool), instance_(std::move(instance)) {}
    ~Lease() {
      const std::lock_guard<std::mutex> lock(pool_.mutex_);
      pool_.free_.push_back(std::move(instance_));
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    T* operator->() { return instance_.get(); }
    T& operator*() { return *instance_; }

   private:
    InstancePool& pool_;
    std::unique_ptr<T> instance_;
  };

  Lease take() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!free_.empty()) {
        auto instance = std::move(free_.back());
        free_.pop_back();
        return {*this, std::move(instance)};
      }
    }
    return {*this, std::make_unique<T>(make_())};
  }

 private:
  std::function<T()> make_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace inhabit::nn
