/// Parameters of sensors in the formats of other programs. What is taken can be written in our own format,
/// and reads back.
#include "exchange/parameters.h"
#include "tests/fuzz/fuzz.h"

using namespace stillpoint;
using exchange::ParameterFormat;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(fuzz::text(data, size));
  static_cast<void>(exchange::guess_format("f", text));
  for (const auto format :
       {ParameterFormat::kStillpoint, ParameterFormat::kSdf, ParameterFormat::kMatlab, ParameterFormat::kKalibr,
        ParameterFormat::kPx4, ParameterFormat::kSensor, ParameterFormat::kImuCalib}) {
    const auto read = exchange::read_parameters(format, text, "f.txt");
    if (!read) {
      fuzz::expect(read.error().message.starts_with("f.txt:"), "a fault names its file", read.error().message);
      continue;
    }
    fuzz::taken();
    const auto ours = exchange::write_parameters(ParameterFormat::kStillpoint, read->simulation);
    const auto again = exchange::read_parameters(ParameterFormat::kStillpoint, ours.text, "g.txt");
    fuzz::expect(again.has_value(), "what was taken reads back", again ? "" : ours.text + again.error().message);
    for (const auto other :
         {ParameterFormat::kSdf, ParameterFormat::kMatlab, ParameterFormat::kKalibr, ParameterFormat::kSensor})
      fuzz::expect(!exchange::write_parameters(other, read->simulation).text.empty(), "what was taken can be written");
    for (const auto part : {ParameterFormat::kPx4, ParameterFormat::kImuCalib})  // they know not every sensor
      static_cast<void>(exchange::write_parameters(part, read->simulation));
  }
  return 0;
}
