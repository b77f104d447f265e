/// Files that somebody damaged or made up: each of these once ended the program, asked for all of its memory, or put
/// numbers into a recording that no sensor gave. Their bytes lie in tests/exchange/damaged.
#include <gmock/gmock.h>

#include <chrono>

#include "exchange/mcap.h"
#include "exchange/parameters.h"
#include "exchange/read_table.h"
#include "exchange/ulog.h"
#include "exchange/unpack.h"
#include "io/text_file.h"
#include "tests/source_folder.h"

namespace stillpoint::exchange {
namespace {

using testing::HasSubstr;

std::string damaged(const std::string& name) {
  const auto text = io::read_text_file(in_source("tests/exchange/damaged/") + name, "a damaged file");
  EXPECT_TRUE(text) << (text ? "" : text.error().message);
  return text.value_or("");
}

std::vector<Stream> ulog(const std::string& name) {
  std::vector<std::string> reasons;
  const auto streams = read_ulog(damaged(name), "f.ulg", reasons);
  return streams.value_or(std::vector<Stream>{});
}

TEST(Damaged, AFieldOfALogThatNoRecordCanHoldIsNotFoundInsteadOfFillingTheMemory) {
  EXPECT_EQ(ulog("accel.ulg").size(), 2U) << "accelerometer and its temperature";
  EXPECT_TRUE(ulog("endless_field.ulg").empty());
}

/// 12 kB, which took minutes.
TEST(Damaged, ALogThatSubscribesOftenToLongFieldsIsReadAtOnce) {
  std::string log("ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0", 16);
  const auto message = [&log](char type, const std::string& body) {
    log += static_cast<char>(body.size());
    log += '\0';
    log += type + body;
  };
  message('F', "sensor_combined:char[65000] a;char[500] b;float[3] gyro_rad;uint64_t timestamp;");
  for (int k = 0; k < 600; ++k) message('A', std::string("\0\1\0", 3) + "sensor_combined");
  std::vector<std::string> reasons;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(read_ulog(log, "f.ulg", reasons));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(Damaged, TimesOfALogThatNoClockHasAndRecordsThatAreTooShortGiveNoReading) {
  EXPECT_TRUE(ulog("time_as_double.ulg").empty());
  const auto beyond = ulog("time_beyond_range.ulg");
  ASSERT_FALSE(beyond.empty());
  EXPECT_EQ(beyond[0].t_ns, std::vector<std::int64_t>{5000});
  const auto cut = ulog("cut_record.ulg");
  ASSERT_FALSE(cut.empty());
  EXPECT_EQ(cut[0].values.size(), 1U) << "zeros were read behind the end of the second";
}

TEST(Damaged, AChunkThatClaimsAGigabyteIsRefusedBeforeTheMemoryIsAskedFor) {
  std::vector<std::string> reasons;
  const auto streams = read_mcap(damaged("chunk_of_a_gigabyte.mcap"), "f.mcap", "", reasons);
  ASSERT_FALSE(streams);
  EXPECT_THAT(streams.error().message, HasSubstr("says more of its size than it holds"));
}

TEST(Damaged, AZipWhoseMembersShareTheirBytesIsRefused) {
  const auto members = unzip(damaged("one_member_forty_times.zip"), "f.zip");
  ASSERT_FALSE(members);
  EXPECT_THAT(members.error().message, HasSubstr("larger than the archive"));
}

TEST(Damaged, TimesBeyondWhatNanosecondsHoldAreRefused) {
  const auto read = [](const std::string& name) {
    const auto table = parse_table(damaged(name), "f.csv");
    EXPECT_TRUE(table);
    std::vector<std::string> reasons;
    return read_streams(*table, guess(*table), reasons);
  };
  for (const char* name : {"farthest_whole_number.csv", "origin_in_seconds.csv"}) {
    const auto streams = read(name);
    ASSERT_FALSE(streams) << name;
    EXPECT_THAT(streams.error().message, HasSubstr("73 years at most")) << name;
  }
  Stream acc{Quantity::kAcc, "f", {}, {}};
  for (const std::int64_t t : {-4'500'000'000'000'000'000, 4'500'000'000'000'000'000}) acc.add(t, Vec3(0, 0, 9.8));
  const auto merged = merge({acc}, "f.csv");
  ASSERT_FALSE(merged);
  EXPECT_THAT(merged.error().message, HasSubstr("its times span 285 years"));
}

TEST(Damaged, ParametersThatAreNoNumbersOrNoSensorAreRefused) {
  const auto refusal = [](ParameterFormat format, const std::string& name) {
    const auto read = read_parameters(format, damaged(name), "f");
    EXPECT_FALSE(read) << name;
    return read ? "" : read.error().message;
  };
  for (const char* name : {"matlab_words.json", "matlab_short_row.json", "matlab_no_object.json"})
    EXPECT_THAT(refusal(ParameterFormat::kMatlab, name), HasSubstr("f: not as loadparams writes it"));
  EXPECT_THAT(refusal(ParameterFormat::kMatlab, "matlab_singular.json"), HasSubstr("no simulated sensor can have"));
  EXPECT_THAT(refusal(ParameterFormat::kKalibr, "kalibr_negative_rate.yaml"), HasSubstr("'rate_hz' is -1"));
  EXPECT_THAT(refusal(ParameterFormat::kPx4, "px4_no_scale.params"), HasSubstr("no simulated sensor can have"));
}

}  // namespace
}  // namespace stillpoint::exchange
