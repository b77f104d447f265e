#include "io/state_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/scratch_folder.h"

namespace stillpoint::io {
namespace {

namespace fs = std::filesystem;

class StateFile : public ::testing::Test {
 protected:
  static std::span<const std::byte> bytes(const std::string& text) { return std::as_bytes(std::span(text)); }
  static std::string text(const StateStore::Loaded& loaded) {
    return {reinterpret_cast<const char*>(loaded.payload.data()), loaded.payload.size()};
  }
  static std::string anything(std::span<const std::byte>) { return {}; }
  test::ScratchFolder scratch_;
  const std::string folder_ = scratch_ / ".";
};

TEST_F(StateFile, GivesBackTheNewestAndKeepsTheOnesBefore) {
  StateStore store(folder_, "imu", 3);
  for (const char* content : {"one", "two", "three", "four"}) ASSERT_TRUE(store.save(bytes(content)).has_value());
  EXPECT_EQ(text(store.load(anything)), "four");
  fs::remove(store.path(0));
  EXPECT_EQ(text(store.load(anything)), "three");
  fs::remove(store.path(1));
  EXPECT_EQ(text(store.load(anything)), "two");
  EXPECT_FALSE(fs::exists(store.path(3)));
}

TEST_F(StateFile, EveryCutAndEveryFlippedBitIsNoticedAndTheOneBeforeServes) {
  StateStore store(folder_, "imu", 2);
  const std::string content("what was learnt\n\nabout it", 25);
  for (std::size_t damage = 0;; ++damage) {
    ASSERT_TRUE(store.save(bytes("older")).has_value());
    ASSERT_TRUE(store.save(bytes(content)).has_value());
    const auto size = fs::file_size(store.path());
    if (damage == 2 * size) break;
    if (damage < size) {
      fs::resize_file(store.path(), damage);
    } else {
      std::fstream file(store.path(), std::ios::binary | std::ios::in | std::ios::out);
      file.seekg(static_cast<std::streamoff>(damage - size));
      const int c = file.get();
      file.seekp(static_cast<std::streamoff>(damage - size));
      file.put(static_cast<char>(c ^ 0x10));
    }
    const auto loaded = store.load(anything);
    ASSERT_EQ(text(loaded), "older") << "damage " << damage;
    ASSERT_EQ(loaded.set_aside.size(), 1U);
    ASSERT_TRUE(fs::exists(store.path() + ".damaged"));
  }
}

TEST_F(StateFile, OfAnotherSensorOrOfAnotherLayoutIsSetAsideWithAMessage) {
  ASSERT_TRUE(StateStore(folder_, "first", 1).save(bytes("x")).has_value());
  fs::rename(folder_ + "/first.state", folder_ + "/second.state");
  const auto loaded = StateStore(folder_, "second", 1).load(anything);
  EXPECT_TRUE(loaded.payload.empty());
  ASSERT_EQ(loaded.set_aside.size(), 1U);
  EXPECT_NE(loaded.set_aside[0].find("another sensor"), std::string::npos);

  StateStore third(folder_, "third", 1);
  ASSERT_TRUE(third.save(bytes("y")).has_value());
  EXPECT_TRUE(third.load([](std::span<const std::byte>) { return std::string("of another layout"); }).payload.empty());
}

TEST_F(StateFile, AFolderRemovedMeanwhileIsMadeAgainAndStaysClaimed) {
  const std::string folder = folder_ + "/learnt";
  StateStore store(folder, "imu", 2);
  ASSERT_TRUE(store.claim().has_value());
  ASSERT_TRUE(store.save(bytes("before")).has_value());
  fs::remove_all(folder);
  ASSERT_TRUE(store.save(bytes("after")).has_value());
  EXPECT_EQ(text(store.load(anything)), "after");
  EXPECT_FALSE(StateStore(folder, "imu", 2).claim().has_value());
}

TEST_F(StateFile, WhoLostItsFolderToAnotherDaemonDoesNotWriteOverIt) {
  StateStore first(folder_, "imu", 2);
  ASSERT_TRUE(first.claim().has_value());
  fs::remove(folder_ + "/imu.lock");
  StateStore second(folder_, "imu", 2);
  ASSERT_TRUE(second.claim().has_value());
  ASSERT_TRUE(second.save(bytes("of the second")).has_value());
  EXPECT_FALSE(first.save(bytes("of the first")).has_value());
  EXPECT_EQ(text(second.load(anything)), "of the second");
}

TEST_F(StateFile, AFolderThatCannotBeWrittenIsReportedBeforeAnythingIsLearnt) {
  std::ofstream(folder_ + "/file") << "in the way";
  const auto claimed = StateStore(folder_ + "/file/below", "imu", 1).claim();
  ASSERT_FALSE(claimed.has_value());
  EXPECT_EQ(claimed.error().kind, ErrorKind::kCannotCreate);
  EXPECT_NE(claimed.error().message.find("Name a folder"), std::string::npos) << claimed.error().message;
}

TEST_F(StateFile, ASecondDaemonLeavesWhatTheFirstIsJustWriting) {
  StateStore first(folder_, "imu", 2), second(folder_, "imu", 2);
  ASSERT_TRUE(first.claim().has_value());
  const std::string half_written = first.path() + ".tmp";
  std::ofstream(half_written) << "half";
  EXPECT_FALSE(second.claim().has_value());
  EXPECT_TRUE(fs::exists(half_written));
}

TEST_F(StateFile, OfOneSensorBelongsToOneDaemonAtATime) {
  auto first = std::make_unique<StateStore>(folder_, "imu", 1);
  ASSERT_TRUE(first->claim().has_value());
  const auto second = StateStore(folder_, "imu", 1).claim();
  ASSERT_FALSE(second.has_value());
  EXPECT_NE(second.error().message.find("another stillpointd"), std::string::npos) << second.error().message;
  EXPECT_TRUE(StateStore(folder_, "other", 1).claim().has_value());
  first.reset();
  EXPECT_TRUE(StateStore(folder_, "imu", 1).claim().has_value());
}

}  // namespace
}  // namespace stillpoint::io
