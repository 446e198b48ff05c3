#pragma once
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace inhabit {

/// The last `capacity` values asked for, each made by `make` when it is not there. Safe to use from several threads:
/// values of different keys are made at the same time, one that several ask for is made once.
template <class Value>
class RecentCache {
 public:
  /// @param make called with a key, from the thread that asks first; what it throws goes to all who wait for that key,
  /// and who asks later has it made again
  RecentCache(size_t capacity, std::function<Value(const std::string&)> make)
      : capacity_(capacity), make_(std::move(make)) {}

  /// The value of a key, made now where it is not among the last.
  Value get(const std::string& key) {
    std::promise<Value> made;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto found = where_.find(key);
      if (found != where_.end()) {
        recent_.splice(recent_.begin(), recent_, found->second);
        const std::shared_future<Value> value = recent_.front().second;
        lock.unlock();
        return value.get();
      }
      recent_.emplace_front(key, made.get_future().share());
      where_[key] = recent_.begin();
      if (recent_.size() > capacity_) {
        where_.erase(recent_.back().first);
        recent_.pop_back();
      }
    }
    try {
      Value value = make_(key);
      made.set_value(value);
      return value;
    } catch (...) {
      made.set_exception(std::current_exception());
      const std::lock_guard<std::mutex> lock(mutex_);
      if (const auto found = where_.find(key); found != where_.end()) {
        recent_.erase(found->second);
        where_.erase(found);
      }
      throw;
    }
  }

 private:
  using Entry = std::pair<std::string, std::shared_future<Value>>;
  size_t capacity_;
  std::function<Value(const std::string&)> make_;
  std::list<Entry> recent_;
  std::map<std::string, typename std::list<Entry>::iterator> where_;
  std::mutex mutex_;
};

}  // namespace inhabit
