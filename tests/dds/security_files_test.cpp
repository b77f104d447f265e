/// What is wrong with keys is said before Fast DDS sees them, each fault with its file and what to do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "io/dds_security.h"
#include "tests/dds/keys.h"

namespace stillpoint::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class SecurityFiles : public testing::Test {
 protected:
  [[nodiscard]] io::SecurityParams daemon() const { return {.folder = keys_ / "daemon"}; }
  Keys keys_{"daemon=daemon laptop"};
};

TEST_F(SecurityFiles, AsTheScriptMakesThemHaveNoFaultAndNothingNamedIsNoSecurity) {
  EXPECT_THAT(io::check(daemon()), IsEmpty());
  EXPECT_THAT(io::warnings(daemon()), IsEmpty());
  EXPECT_FALSE(io::is_secured(io::SecurityParams{}));
  EXPECT_THAT(io::check(io::SecurityParams{}), IsEmpty());
}

TEST_F(SecurityFiles, ThatAreNotThereAreNamedEachWithItsKey) {
  io::SecurityParams one;
  one.certificate = keys_ / "daemon/cert.pem";
  EXPECT_EQ(io::check(one).size(), 5U) << "the other five";
  EXPECT_THAT(io::check(one).front(), AllOf(StartsWith("'identity_ca' is missing"), HasSubstr("identity_ca.cert.pem")));
  EXPECT_THAT(io::check(io::SecurityParams{.folder = keys_ / "nobody"}),
              ElementsAre(AllOf(StartsWith("folder: "), HasSubstr("dds_keys.sh"))));
  std::filesystem::remove(keys_ / "daemon/key.pem");
  EXPECT_THAT(io::check(daemon()), ElementsAre(AllOf(StartsWith("private_key: " + (keys_ / "daemon/key.pem")),
                                                     HasSubstr("No such file"), HasSubstr("dds_keys.sh"))));
  write_file(keys_ / "daemon/key.pem", "");
  EXPECT_THAT(io::check(daemon()), ElementsAre(HasSubstr("an empty one")));
}

TEST_F(SecurityFiles, ThatDoNotBelongTogetherAreNamedWithWhatDoesNot) {
  io::SecurityParams mixed = daemon();
  mixed.private_key = keys_ / "laptop/key.pem";
  EXPECT_THAT(io::check(mixed), ElementsAre(AllOf(StartsWith("private_key: "), HasSubstr("does not belong"))));
  mixed = daemon();
  mixed.permissions = keys_ / "laptop/permissions.p7s";
  EXPECT_THAT(io::check(mixed),
              ElementsAre(AllOf(StartsWith("permissions: "), HasSubstr("'CN=laptop'"), HasSubstr("'CN=daemon'"))));
  const Keys others("daemon=daemon");
  mixed = daemon();
  mixed.identity_ca = others / "ca/cert.pem";
  EXPECT_THAT(io::check(mixed), ElementsAre(AllOf(StartsWith("certificate: "), HasSubstr("not accepted"))));
  mixed = daemon();
  mixed.permissions_ca = others / "ca/cert.pem";
  EXPECT_THAT(io::check(mixed), ElementsAre(StartsWith("governance: "), StartsWith("permissions: ")));
  mixed.permissions_ca = keys_ / "daemon/key.pem";
  EXPECT_THAT(io::check(mixed), ElementsAre(HasSubstr("holds no certificate")));
}

TEST_F(SecurityFiles, ThatWereChangedAfterTheyWereSignedAreRefusedAndSignedAnewByTheScript) {
  keys_.edit("daemon/permissions.p7s", "stillpoint/*", "stillpoint/x");
  EXPECT_THAT(io::check(daemon()), ElementsAre(AllOf(StartsWith("permissions: "), HasSubstr("not signed"))));
  keys_.make("daemon");
  EXPECT_THAT(io::check(daemon()), IsEmpty());
}

TEST_F(SecurityFiles, ACertificateThatHasExpiredIsSaidToHave) {
  std::filesystem::remove(keys_ / "daemon/cert.pem");
  keys_.make("daemon", "DAYS=0");
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));  // valid for the second in which it was made
  EXPECT_THAT(io::check(daemon()),
              ElementsAre(AllOf(StartsWith("certificate: "), HasSubstr("expired"), HasSubstr("clock"))));
}

TEST_F(SecurityFiles, APrivateKeyThatEverybodyMayReadIsWarnedOf) {
  ASSERT_EQ(chmod((keys_ / "daemon/key.pem").c_str(), 0644), 0);
  EXPECT_THAT(io::check(daemon()), IsEmpty());
  EXPECT_THAT(io::warnings(daemon()), ElementsAre(AllOf(HasSubstr("daemon/key.pem"), HasSubstr("chmod o="))));
}

/// `--check-config` names the place in the configuration; paths are relative to it.
TEST_F(SecurityFiles, AreCheckedWithTheConfiguration) {
  const std::string config = keys_ / "d.yaml", log = keys_ / "log";
  const auto checked = [&](const std::string& security) {
    write_file(config, "source: {kind: stream, from: stdin}\ndds:\n  security: " + security + "\n");
    return run(STILLPOINTD " --check-config --config " + config, log);
  };
  EXPECT_EQ(checked("{folder: daemon}"), 0) << read_file(log);
  EXPECT_EQ(read_file(log), "");
  ASSERT_EQ(chmod((keys_ / "daemon/key.pem").c_str(), 0644), 0);
  EXPECT_EQ(checked("{folder: daemon}"), 0);
  EXPECT_THAT(read_file(log), HasSubstr("everybody on this machine may read the private key"));
  EXPECT_EQ(checked("{folder: daemon, private_key: laptop/key.pem}"), 78);
  EXPECT_THAT(read_file(log), AllOf(HasSubstr("d.yaml:3:13: private_key: "), HasSubstr("does not belong")));
  EXPECT_EQ(checked("{folder: daemon}\n  transport: data_sharing"), 78);
  EXPECT_THAT(read_file(log), HasSubstr("use udp or shm"));
}

}  // namespace
}  // namespace stillpoint::test
