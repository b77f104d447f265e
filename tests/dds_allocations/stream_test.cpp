#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bench/allocations.h"
#include "sources/stream_source.h"

namespace stillpoint::sources {
namespace {

/// Ten thousand readings of each form, damaged lines among them.
std::string content(int form) {
  std::string text = form == 0 ? "time_us,acc_x_g,acc_y_g,acc_z_g,gyr_x_dps,gyr_y_dps,gyr_z_dps\n" : "";
  for (int k = 1; k <= 10'000; ++k) {
    const std::string t = std::to_string(1000 * k);
    if (form == 0) text += t + ",0.01,0.02,1.00,0.1,0.2,0.3\n" + (k % 100 == 0 ? "1,2,\n" : "");
    if (form == 1) text += R"({"time_us":)" + t + R"(,"acc_g":[0.01,0.02,1.0],"gyr_dps":[1,2,3]})" + "\n";
    if (form < 2) continue;
    Reading r;
    r.has_time = true;
    r.sample.t_ns = 1'000'000LL * k;
    r.sample.has = kAcc | kGyr;
    std::array<std::uint8_t, kLongestFrame> bytes{};
    const std::size_t n = write_frame(r, static_cast<std::uint8_t>(k), bytes);
    text.append(reinterpret_cast<const char*>(bytes.data()), n);
  }
  return text;
}

TEST(StreamAllocations, NoReadingMakesOneOnceTheStreamRuns) {
  const std::string path = std::filesystem::temp_directory_path() / ("stillpoint_stream_" + std::to_string(getpid()));
  for (const int form : {0, 1, 2}) {
    std::ofstream(path, std::ios::binary) << content(form);
    io::StreamParams params;
    params.from = path;
    auto source = StreamSource::create(params, 1.0);
    ASSERT_TRUE(source);
    pipeline::Arrival out;
    std::size_t before = 0;
    int readings = 0;
    for (auto state = pipeline::SourceState::kNothing; state != pipeline::SourceState::kEnd;
         state = source->next(out)) {
      if (state == pipeline::SourceState::kSample && ++readings == 10) before = bench::allocations();
      if (readings == 10'000) break;
    }
    EXPECT_EQ(bench::allocations() - before, 0U) << "form " << form;
    EXPECT_EQ(readings, 10'000) << "form " << form;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace stillpoint::sources
