// The attitude of a running stillpointd, without ROS: one line a second for five seconds. Needs Stillpoint::dds.
#include <stillpoint/io/dds_subscriber.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

int main(int, char** argv) {
  std::atomic<int> received = 0;
  stillpoint::io::DdsParams dds;
  if (argv[1] != nullptr) dds.domain = std::atoi(argv[1]);
  const auto subscriber = stillpoint::io::DdsSubscriber::create(
      dds, {.attitude = [&](const stillpoint::AttitudeMessage& m, std::int64_t) {
        const auto& [x, y, z, w] = m.q_world_body_xyzw;
        if (received++ % 100 == 0) std::printf("q %.4f %.4f %.4f %.4f, %s\n", w, x, y, z, name(m.status).data());
      }});
  if (!subscriber) return std::fprintf(stderr, "%s\n", subscriber.error().message.c_str()), 1;
  std::this_thread::sleep_for(std::chrono::seconds(5));
  std::printf("%d attitudes in 5 s\n", received.load());
  return received > 0 ? 0 : 1;
}
