#include "inhabit/serve/hub.h"

#include <random>

namespace inhabit::serve {

std::string Hub::keep(Recording recording) {
  std::random_device random;  // the system's, not a seeded generator
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[random() % 16];
  const std::lock_guard lock(mutex_);
  recordings_[token] = std::move(recording);
  return token;
}

Recording Hub::recording(const std::string& token) {
  const std::lock_guard lock(mutex_);
  const auto at = recordings_.find(token);
  return at == recordings_.end() ? nullptr : at->second;
}

void Hub::forget(const std::string& token) {
  const std::lock_guard lock(mutex_);
  recordings_.erase(token);
}

void Hub::join(LiveSession* session, std::weak_ptr<LiveSession> weak) {
  const std::lock_guard lock(mutex_);
  sessions_[session] = std::move(weak);
}

void Hub::leave(LiveSession* session) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(session);
}

std::vector<std::shared_ptr<LiveSession>> Hub::sessions() {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<LiveSession>> out;
  for (const auto& [session, weak] : sessions_)
    if (auto alive = weak.lock()) out.push_back(std::move(alive));
  return out;
}

}  // namespace inhabit::serve
