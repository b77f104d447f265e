#include "io/recording_stream.h"

#include <fmt/format.h>

#include <iterator>

namespace stillpoint::io {

Result<RecordingStream> RecordingStream::create(const std::string& path,
                                                const std::map<std::string, std::string>& header) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr)
    return fail(ErrorKind::kCannotCreate, fmt::format("{}: cannot be created; does the folder exist?", path));
  RecordingStream stream(path, file);
  for (const auto& [key, value] : header) std::fprintf(file, "# %s: %s\n", key.c_str(), value.c_str());
  std::fputs(
      "time_ns,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyr_x_radps,gyr_y_radps,gyr_z_radps,mag_x_uT,mag_y_uT,mag_z_uT,temp_"
      "degC\n",
      file);
  if (auto done = stream.flush(); !done) return tl::unexpected(done.error());
  return stream;
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
  if (std::fwrite(row.data(), 1, row.size(), file_.get()) != row.size())
    return fail(ErrorKind::kCannotCreate,
                fmt::format("{}: row {} could not be written; is the disk full?", path_, rows_ + 1));
  ++rows_;
  return {};
}

Result<void> RecordingStream::flush() {
  if (std::fflush(file_.get()) != 0)
    return fail(ErrorKind::kCannotCreate, fmt::format("{}: could not be written; is the disk full?", path_));
  return {};
}

}  // namespace stillpoint::io
