/// The judge of datagrams alone: what two vendors really send passes untouched, every lie about a length is refused,
/// and nothing that can be sent makes it read outside the datagram (the sanitizers watch this test too).
#include "io/dds_rtps.h"

#include <gtest/gtest.h>

#include <random>

#include "io/dds_admission.h"
#include "io/dds_publisher.h"
#include "tests/dds/datagram.h"

namespace stillpoint::io {
namespace {

std::optional<RtpsMessage> judge(std::string& datagram) {
  return judge_rtps({reinterpret_cast<std::uint8_t*>(datagram.data()), datagram.size()});
}
std::optional<RtpsMessage> judged(std::string datagram) { return judge(datagram); }

std::string header() { return std::string("RTPS\x02\x03\x01\x0f", 8) + "senders guid"; }
std::string le(std::uint64_t value, int bytes) {
  std::string out;
  for (int k = 0; k < bytes; ++k) out += static_cast<char>(value >> (8 * k) & 0xffU);
  return out;
}
std::string sequence_number(std::uint64_t n) { return le(n >> 32U, 4) + le(n & 0xffffffffU, 4); }
std::string submessage(int id, int flags, const std::string& body) {
  return std::string{static_cast<char>(id), static_cast<char>(flags)} + le(body.size(), 2) + body;
}
const std::string kEntities = std::string("\0\1\0\xc7\0\1\0\xc2", 8);  // of the participants' discovery
const std::string kUsersEntities = std::string("\0\0\1\4\0\0\1\3", 8);

TEST(Rtps, AnAnnouncementOfFastDdsPassesUnchangedAndNamesItsSender) {
  const auto publisher = DdsPublisher::create(test::test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  const std::string real = test::announcement();
  std::string copy = real;
  const auto message = judge(copy);
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->announces_participant);
  EXPECT_FALSE(message->announces_for_another);
  EXPECT_EQ(std::string(message->sender.begin(), message->sender.end()), real.substr(8, 12));
  std::string without_statistics = real;
  without_statistics.replace(without_statistics.find("\x80\x01\x38", 20, 3), 1, "\1");
  EXPECT_EQ(copy, without_statistics) << "statistics are made padding, the rest is as it was";
  std::string relayed = real;
  relayed.replace(8, 12, "another host");
  EXPECT_TRUE(judged(relayed)->announces_for_another);
}

TEST(Rtps, WhatIsCutAnywhereOrClaimsMoreThanItHasIsRefused) {
  const auto publisher = DdsPublisher::create(test::test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  const std::string real = test::announcement();
  int passed = 0;
  for (std::size_t length = 0; length < real.size(); ++length) passed += judged(real.substr(0, length)) ? 1 : 0;
  EXPECT_LE(passed, 3) << "only a cut between two submessages leaves a whole message";
  EXPECT_FALSE(judged(header() + submessage(0x15, 0x05, "") + "\1"));
  EXPECT_FALSE(judged(header() + std::string("\x07\x01\xff\x00", 4) + std::string(28, '\0')));
}

TEST(Rtps, StatisticsOfAVendorBecomePadding) {
  std::string datagram = test::statistics_datagram();
  ASSERT_TRUE(judge(datagram));
  EXPECT_EQ(datagram[20], 1);
}

TEST(Rtps, WhatAVendorsLastSubmessageHoldsStaysInsideThePaddingThatItBecomes) {
  const std::string hidden = submessage(0x15, 0x05, "no data of any kind!");
  for (const char byte_order : {'\0', '\1'}) {
    std::string datagram = header() + std::string{'\x80', byte_order, '\0', '\0'} + hidden;
    ASSERT_TRUE(judge(datagram));
    EXPECT_EQ(datagram[20], '\1');
    EXPECT_EQ(static_cast<std::size_t>(datagram[byte_order == 1 ? 22 : 23]), hidden.size())
        << "padding of length 0 would end before it, and it would be read as a submessage";
  }
}

TEST(Rtps, SetsOfSequenceNumbersLieInsideAndRangesRunForward) {
  const auto gap = [](std::uint64_t start, std::uint64_t base, std::uint32_t bits, int words) {
    return header() + submessage(0x08, 1,
                                 kEntities + sequence_number(start) + sequence_number(base) + le(bits, 4) +
                                     std::string(static_cast<std::size_t>(4 * words), '\1'));
  };
  EXPECT_TRUE(judged(gap(1, 5, 40, 2)));
  EXPECT_FALSE(judged(gap(1, 5, 40, 1))) << "two words are promised";
  EXPECT_FALSE(judged(gap(1, 5, 257, 9))) << "more than RTPS allows";
  EXPECT_FALSE(judged(gap(0, 5, 0, 0)));
  EXPECT_FALSE(judged(gap(9, 5, 0, 0)));
  const auto heartbeat = [](std::uint64_t first, std::uint64_t last) {
    return header() + submessage(0x07, 1, kEntities + sequence_number(first) + sequence_number(last) + le(1, 4));
  };
  EXPECT_TRUE(judged(heartbeat(1, 0))) << "nothing written yet";
  EXPECT_FALSE(judged(heartbeat(0, 4)));
  EXPECT_FALSE(judged(heartbeat(9, 4)));
  EXPECT_FALSE(judged(heartbeat(1, ~std::uint64_t{0})));
}

TEST(Rtps, FragmentsLieInsideTheirSampleAndHoldWhatTheyPromise) {
  const auto fragment = [](std::uint32_t first, std::uint16_t count, std::uint16_t size, std::uint32_t sample,
                           std::size_t bytes) {
    return header() + submessage(0x16, 1,
                                 le(0, 2) + le(28, 2) + kUsersEntities + sequence_number(1) + le(first, 4) +
                                     le(count, 2) + le(size, 2) + le(sample, 4) + std::string(bytes, 'x'));
  };
  EXPECT_TRUE(judged(fragment(1, 1, 100, 250, 100)));
  EXPECT_TRUE(judged(fragment(3, 1, 100, 250, 52))) << "the last one is shorter";
  EXPECT_FALSE(judged(fragment(1, 1, 100, 250, 60)));
  EXPECT_FALSE(judged(fragment(0, 1, 100, 250, 100)));
  EXPECT_FALSE(judged(fragment(4, 1, 100, 250, 100))) << "there are three";
  EXPECT_FALSE(judged(fragment(1, 1, 0, 250, 100)));
  EXPECT_FALSE(judged(fragment(1, 1, 100, 0xfffffff0, 100))) << "four gigabytes to be kept ready";
}

TEST(Rtps, TextsAndListsOfDiscoveryDataLieInsideTheirParameter) {
  const auto announced = [](const std::string& parameter) {
    return header() + submessage(0x15, 0x05,
                                 le(0, 2) + le(16, 2) + std::string("\0\1\0\xc7\0\1\0\xc2", 8) + sequence_number(1) +
                                     std::string("\0\3\0\0", 4) + parameter + std::string("\1\0\0\0", 4));
  };
  const auto parameter = [](int id, const std::string& value) {
    return le(static_cast<std::uint64_t>(id), 2) + le(value.size(), 2) + value;
  };
  EXPECT_TRUE(judged(announced(parameter(0x62, le(4, 4) + std::string("abc\0", 4)))));
  EXPECT_FALSE(judged(announced(parameter(0x62, le(5, 4) + std::string("abc\0", 4)))));
  EXPECT_FALSE(judged(announced(parameter(0x62, le(4, 4) + "abcd")))) << "without an end";
  EXPECT_FALSE(judged(announced(parameter(0x59, le(0x40000000, 4) + std::string(8, '\0')))));
  EXPECT_FALSE(judged(announced(parameter(0x2c, le(100, 4)))));
  EXPECT_FALSE(judged(announced(parameter(0x50, "too short"))));
  std::string with_types = announced(parameter(0x75, "anything"));
  ASSERT_TRUE(judge(with_types));
  EXPECT_EQ(with_types.find('\x75', 20), std::string::npos) << "type objects become padding";
}

/// A class, one property, one binary property.
std::string token(std::uint32_t properties, std::uint32_t binaries, std::uint32_t octets) {
  const auto text = [](const std::string& t) { return le(t.size(), 4) + t; };
  return text(std::string("DDS:Id\0\0", 8)) + le(properties, 4) + text(std::string("abc\0", 4)) +
         text(std::string("def\0", 4)) + le(binaries, 4) + text(std::string("ghi\0", 4)) + le(octets, 4) + "1234";
}

/// What Fast DDS reads of tokens makes room for as many properties as are claimed.
TEST(Rtps, TokensOfASecuredParticipantHoldWhatTheyClaim) {
  for (const int id : {0x1001, 0x1002}) {
    const auto announced = [id](const std::string& value) {
      return judged(header() + submessage(0x15, 0x05,
                                          le(0, 2) + le(16, 2) + kEntities + sequence_number(1) +
                                              std::string("\0\3\0\0", 4) + le(static_cast<std::uint64_t>(id), 2) +
                                              le(value.size(), 2) + value + std::string("\1\0\0\0", 4)));
    };
    EXPECT_TRUE(announced(token(1, 1, 4)));
    EXPECT_FALSE(announced(token(0x7fffffff, 1, 4)));
    EXPECT_FALSE(announced(token(2, 1, 4)));
    EXPECT_FALSE(announced(token(1, 0x7fffffff, 4)));
    EXPECT_FALSE(announced(token(1, 1, 5)));
    EXPECT_FALSE(announced(token(1, 1, 4).substr(0, 16))) << "a class and nothing more";
  }
}

TEST(Rtps, MessagesOfTheHandshakeHoldWhatTheyClaimWhoeverTheyNameAsWriter) {
  const std::string reader("\0\2\1\xc4", 4), writer("\0\2\1\xc3", 4), other("\0\0\1\3", 4);
  const auto sent = [&](const std::string& to, const std::string& from, const std::string& tokens, char kind = '\1') {
    return judged(header() + submessage(0x15, 0x05,
                                        le(0, 2) + le(16, 2) + to + from + sequence_number(1) +
                                            std::string{'\0', kind, '\0', '\0'} + std::string(96, 'i') + le(4, 4) +
                                            std::string("abc\0", 4) + tokens));
  };
  EXPECT_TRUE(sent(reader, writer, le(1, 4) + token(1, 1, 4)));
  EXPECT_TRUE(sent(reader, writer, le(2, 4) + token(1, 1, 4) + token(1, 1, 4)));
  for (const auto& [to, from] : {std::pair{reader, writer}, {reader, other}, {other, writer}}) {
    EXPECT_FALSE(sent(to, from, le(0x7fffffff, 4) + token(1, 1, 4)));
    EXPECT_FALSE(sent(to, from, le(2, 4) + token(1, 1, 4)));
    EXPECT_FALSE(sent(to, from, le(1, 4) + token(0x7fffffff, 1, 4)));
    EXPECT_FALSE(sent(to, from, le(1, 4) + token(1, 1, 4), '\3')) << "no list of parameters";
  }
  EXPECT_TRUE(sent(other, other, le(0x7fffffff, 4))) << "a user's own data is the type's business";
  EXPECT_FALSE(sent(other, std::string(4, '\0'), "")) << "a writer without a name is taken by any reader";
}

TEST(Rtps, FragmentsOfWhatIsReadBeforeAnybodyIsKnownAreRefused) {
  const auto fragment = [](const std::string& entities) {
    return judged(header() + submessage(0x16, 1,
                                        le(0, 2) + le(28, 2) + entities + sequence_number(1) + le(1, 4) + le(1, 2) +
                                            le(100, 2) + le(250, 4) + std::string(100, 'x')));
  };
  EXPECT_TRUE(fragment(kUsersEntities));
  EXPECT_FALSE(fragment(kEntities));
  EXPECT_FALSE(fragment(std::string("\0\2\1\xc4\0\2\1\xc3", 8)));
  EXPECT_FALSE(fragment(std::string(8, '\0')));
}

TEST(Rtps, SecuredSubmessagesAreFramedWhole) {
  const auto secured = [](int id, const std::string& body) { return judged(header() + submessage(id, 1, body)); };
  for (const int prefix : {0x31, 0x33}) {
    EXPECT_TRUE(secured(prefix, std::string(20, 'x')));
    EXPECT_FALSE(secured(prefix, std::string(16, 'x')));
  }
  EXPECT_TRUE(secured(0x30, std::string(8, 'x')));
  EXPECT_FALSE(secured(0x30, ""));
  for (const int postfix : {0x32, 0x34}) {
    const std::string mac(16, 'm'), of_receiver(20, 'r'), two("\0\0\0\2", 4);
    EXPECT_TRUE(secured(postfix, mac + std::string(4, '\0')));
    EXPECT_TRUE(secured(postfix, mac + two + of_receiver + of_receiver));
    EXPECT_FALSE(secured(postfix, mac + two + of_receiver));
    EXPECT_FALSE(secured(postfix, mac));
  }
}

TEST(Rtps, NothingThatCanBeSentIsReadBeyondItsEnd) {
  const auto publisher = DdsPublisher::create(test::test_params());
  ASSERT_TRUE(publisher) << publisher.error().message;
  const std::string real = test::announcement();
  std::mt19937 random(5);
  int refused = 0;
  for (int n = 0; n < 200'000; ++n) {
    std::string damaged = real.substr(0, 20 + random() % (real.size() - 20));
    for (unsigned k = 0; k < 1 + random() % 6; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    const std::vector<char> exact(damaged.begin(), damaged.end());  // its end is the end of an allocation
    refused += judge_rtps({reinterpret_cast<std::uint8_t*>(const_cast<char*>(exact.data())), exact.size()}) ? 0 : 1;
  }
  EXPECT_GT(refused, 190'000);
}

GuidPrefix participant(int n) {
  GuidPrefix out{};
  out[0] = static_cast<std::uint8_t>(n % 256);
  out[1] = static_cast<std::uint8_t>(n / 256);
  out[2] = 1;
  return out;
}
constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(Admission, ARobotsHundredProgramsComeInAtOnceAndStay) {
  Admission admission;
  for (int n = 0; n < 100; ++n) EXPECT_TRUE(admission.admit(participant(n), 1000 + static_cast<std::uint64_t>(n), 5));
  for (int n = 0; n < 100; ++n) EXPECT_TRUE(admission.admit(participant(n), 1000 + static_cast<std::uint64_t>(n), 6));
}

TEST(Admission, OneProgramThatFloodsUsesUpItsOwnShareAndNotThatOfTheOthers) {
  Admission admission;
  int let_in = 0;
  for (int n = 0; n < 10'000; ++n) let_in += admission.admit(participant(n), 7, n * kSecond_ns / 1000) ? 1 : 0;
  EXPECT_LE(let_in, 16) << "four, and one more each second of ten";
  EXPECT_TRUE(admission.admit(participant(60'000), 8, 10 * kSecond_ns));
}

TEST(Admission, AFloodFromManySourcesIsHeldToTenASecondAndEndsWithIt) {
  Admission admission;
  int let_in = 0;
  for (int n = 0; n < 10'000; ++n)
    let_in += admission.admit(participant(n), static_cast<std::uint64_t>(n), n * kSecond_ns / 1000) ? 1 : 0;
  EXPECT_LE(let_in, 240);
  EXPECT_TRUE(admission.admit(participant(60'000), 8, 30 * kSecond_ns));
}

}  // namespace
}  // namespace stillpoint::io
