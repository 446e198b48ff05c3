#pragma once
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace inhabit {

/// The last `capacity` values asked for, each made by `make` when it is not there. Safe to use from several threads.
template <class Value>
class RecentCache {
 public:
  /// @param make called with a key while the cache is locked; what it throws goes to who asked
  RecentCache(size_t capacity, std::function<Value(const std::string&)> make)
      : capacity_(capacity), make_(std::move(make)) {}

  /// The value of a key, made now where it is not among the last.
  Value get(const std::string& key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = where_.find(key);
    if (found != where_.end()) {
      recent_.splice(recent_.begin(), recent_, found->second);
      return recent_.front().second;
    }
    recent_.emplace_front(key, make_(key));
    where_[key] = recent_.begin();
    if (recent_.size() > capacity_) {
      where_.erase(recent_.back().first);
      recent_.pop_back();
    }
    return recent_.front().second;
  }

 private:
  using Entry = std::pair<std::string, Value>;
  size_t capacity_;
  std::function<Value(const std::string&)> make_;
  std::list<Entry> recent_;
  std::map<std::string, typename std::list<Entry>::iterator> where_;
  std::mutex mutex_;
};

}  // namespace inhabit
