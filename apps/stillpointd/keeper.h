/// Keeps what was learnt on disk, in a thread of its own: an fsync may take seconds, and a disk may be full or
/// read-only for a while. Nobody waits for it, and it tries again by itself.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "apps/stillpointd/troubles.h"
#include "io/state_file.h"

namespace stillpoint::app {

class Keeper {
 public:
  /// Both live longer than the process's other threads: they may be used by a thread that hangs in the kernel.
  Keeper(std::shared_ptr<io::StateStore> store, std::shared_ptr<Troubles> troubles);

  /// Takes the folder. False: another daemon has it. Where it cannot be written now, that is tried again before each
  /// save.
  [[nodiscard]] Result<void> claim();
  /// Writes these bytes, or what is given before it gets to them. Returns at once.
  void keep(std::span<const std::byte> state);
  /// What was given last is on disk. False: not within this time; the thread is left to itself.
  bool finish(double timeout_s);

 private:
  struct Shared;
  static void run(const std::shared_ptr<Shared>& shared);
  std::shared_ptr<Shared> shared_;
};

}  // namespace stillpoint::app
