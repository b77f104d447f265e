#include "io/recording_stream.h"

#include <fmt/format.h>

#include <iterator>

namespace stillpoint::io {

Result<RecordingStream> RecordingStream::create(const std::string& path,
                                                const std::map<std::string, std::string>& header) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::string text;
  for (const auto& [key, value] : header) text += fmt::format("# {}: {}\n", key, value);
  text +=
      "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_uT,"
      "temp_degC\n";
  if (auto written = file->write(text); !written) return tl::unexpected(written.error());
  if (auto written = file->flush(); !written) return tl::unexpected(written.error());
  return RecordingStream(std::move(*file));
}

Result<void> RecordingStream::append(const RawSample& sample) {
  fmt::memory_buffer row;
  const auto to = std::back_inserter(row);
  fmt::format_to(to, "{}", sample.t_ns);
  const auto triad = [&](SamplePart part, const Array3& v) {
    if (sample.holds(part))
      fmt::format_to(to, ",{},{},{}", v[0], v[1], v[2]);
    else
      fmt::format_to(to, ",,,");
  };
  triad(kAcc, sample.acc_mps2);
  triad(kGyr, sample.gyr_radps);
  triad(kMag, sample.mag_uT);
  if (sample.holds(kTemp))
    fmt::format_to(to, ",{}\n", sample.temp_degC);
  else
    fmt::format_to(to, ",\n");
  if (auto written = file_.write({row.data(), row.size()}); !written) return written;
  ++rows_;
  return {};
}

}  // namespace stillpoint::io
