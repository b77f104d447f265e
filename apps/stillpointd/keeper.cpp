#include "apps/stillpointd/keeper.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace stillpoint::app {
namespace {

using Bytes = std::vector<std::byte>;
constexpr auto kTryAgain = std::chrono::seconds(5);
constexpr const char* kSubject = "state";

}  // namespace

/// Owned by the thread too, which may outlive the daemon's other parts in a write that does not return.
struct Keeper::Shared {
  std::shared_ptr<io::StateStore> store;
  std::shared_ptr<Troubles> troubles;
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<Bytes> next;
  bool claimed = false, writing = false, ending = false, started = false;

  /// Nothing of it is locked while the disk works.
  bool save(const Bytes& state) {
    if (!claimed) {
      const auto taken = store->claim();
      troubles->set(kSubject, taken ? "" : "what is learnt is not kept: " + taken.error().message);
      if (!taken) return false;
      claimed = true;
    }
    const auto saved = store->save(state);
    troubles->set(kSubject, saved ? "" : "what is learnt is not kept: " + saved.error().message);
    return saved.has_value();
  }
};

Keeper::Keeper(std::shared_ptr<io::StateStore> store, std::shared_ptr<Troubles> troubles)
    : shared_(std::make_shared<Shared>()) {
  shared_->store = std::move(store);
  shared_->troubles = std::move(troubles);
}

Result<void> Keeper::claim() {
  const auto taken = shared_->store->claim();
  shared_->claimed = taken.has_value();
  if (taken || taken.error().kind == ErrorKind::kUnavailable) return taken;
  shared_->troubles->set(kSubject, "what is learnt is not kept: " + taken.error().message);
  return {};
}

void Keeper::keep(std::span<const std::byte> state) {
  const std::lock_guard lock(shared_->mutex);
  shared_->next = Bytes(state.begin(), state.end());
  if (!shared_->started) std::thread(run, shared_).detach();
  shared_->started = true;
  shared_->changed.notify_all();
}

void Keeper::run(const std::shared_ptr<Shared>& shared) {
  std::unique_lock lock(shared->mutex);
  while (true) {
    shared->changed.wait(lock, [&] { return shared->next.has_value() || shared->ending; });
    if (!shared->next) return;
    const Bytes state = *std::exchange(shared->next, std::nullopt);
    shared->writing = true;
    lock.unlock();
    const bool saved = shared->save(state);
    lock.lock();
    shared->writing = false;
    if (!saved && !shared->next && !shared->ending) {
      shared->next = state;
      shared->changed.wait_for(lock, kTryAgain, [&] { return shared->ending || *shared->next != state; });
    }
    shared->changed.notify_all();
  }
}

bool Keeper::finish(double timeout_s) {
  std::unique_lock lock(shared_->mutex);
  shared_->ending = true;
  shared_->changed.notify_all();
  return shared_->changed.wait_for(lock, std::chrono::duration<double>(timeout_s),
                                   [this] { return !shared_->writing && (!shared_->next || !shared_->started); });
}

}  // namespace stillpoint::app
