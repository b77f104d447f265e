#include "pipeline/realtime.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace stillpoint::pipeline {
namespace {

/// More than the stages ever use; touched once so that no page fault meets a sample.
void touch_stack() {
  constexpr std::size_t kStack_bytes = 256 * 1024;
  [[maybe_unused]] volatile unsigned char pages[kStack_bytes];
  for (std::size_t i = 0; i < kStack_bytes; i += 4096) pages[i] = 0;
}

std::string reason(int error) { return std::strerror(error); }

}  // namespace

std::optional<std::string> lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return std::nullopt;
  return "memory stays unlocked: mlockall: " + reason(errno) +
         "; raise LimitMEMLOCK= in the unit (or ulimit -l), or set threads.lock_memory: false";
}

std::optional<std::string> limit_cpu_latency(int us) {
  constexpr const char* kDevice = "/dev/cpu_dma_latency";
  const std::int32_t wanted_us = us;
  const int device = open(kDevice, O_WRONLY | O_CLOEXEC);  // the wish holds while it is open: never closed
  if (device >= 0 && write(device, &wanted_us, sizeof wanted_us) == sizeof wanted_us) return std::nullopt;
  return std::string("processors sleep as the system decides: ") + kDevice + ": " + reason(errno) +
         "; let the daemon's user write it (a udev rule), or set threads.cpu_latency_us: -1";
}

std::vector<std::string> prepare_thread(const char* name, int core, int fifo_priority) {
  std::vector<std::string> refused;
  pthread_setname_np(pthread_self(), name);
  touch_stack();
  prctl(PR_SET_TIMERSLACK, 1UL);  // ns; never refused
  const std::string thread = std::string(name) + " thread: ";
  if (core >= 0) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    CPU_SET(static_cast<std::size_t>(core), &cores);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof cores, &cores))
      refused.push_back(thread + "not pinned to core " + std::to_string(core) + ": " + reason(error) +
                        "; it runs on any core");
  }
  if (fifo_priority > 0) {
    const sched_param param{.sched_priority = fifo_priority};
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param))
      refused.push_back(thread + "normal scheduling instead of SCHED_FIFO " + std::to_string(fifo_priority) + ": " +
                        reason(error) +
                        "; raise LimitRTPRIO= in the unit (or ulimit -r), or set threads.fifo_priority: 0");
  }
  return refused;
}

}  // namespace stillpoint::pipeline
