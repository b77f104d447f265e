/// `stillpoint page` as a browser, a stranger's page and an operator meet it.
#include <gmock/gmock.h>
#include <httplib.h>

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/daemon/daemon_fixture.h"
#include "tests/source_folder.h"

namespace stillpoint::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Page : public DaemonFaults {
 protected:
  /// The page of this test's domain on a free port, or the one asked for.
  void open(const std::string& port = "0") {
    page_ = std::make_unique<Process>(
        std::vector<std::string>{STILLPOINT, "page", "--domain", std::to_string(io::own_domain()), "--port", port},
        scratch_ / "page.log");
    address_ = page_->some_output();
    const auto colon = address_.rfind(':');
    ASSERT_NE(colon, std::string::npos) << address_ << read_file(scratch_ / "page.log");
    port_ = std::stoi(address_.substr(colon + 1));
  }
  [[nodiscard]] httplib::Client client() const {
    httplib::Client made("127.0.0.1", port_);
    made.set_read_timeout(20);
    return made;
  }
  [[nodiscard]] json state() const {
    const auto answer = client().Get("/state");
    return answer && answer->status == 200 ? json::parse(answer->body) : json::object();
  }
  [[nodiscard]] bool becomes(const std::string& freshness) const {
    return within_20_s([&] { return state().value("freshness", "") == freshness; });
  }
  /// What the stream sends until it holds `events` of them.
  [[nodiscard]] std::string stream(std::size_t events) const {
    std::string all;
    client().Get("/events", [&](const char* data, std::size_t size) {
      all.append(data, size);
      std::size_t ends = 0;
      for (std::size_t at = all.find("\n\n"); at != std::string::npos; at = all.find("\n\n", at + 2)) ++ends;
      return ends < events;
    });
    return all;
  }

  std::unique_ptr<Process> page_;
  std::string address_;
  int port_ = 0;
};

TEST_F(Page, StreamsTheHistoryThenUnitQuaternionsOfTheRunningDaemon) {
  configure("", "1");
  const auto daemon = start();
  open();
  ASSERT_TRUE(becomes("live")) << state().dump();
  ASSERT_TRUE(within_20_s([&] { return state()["watch"]["attitude"]["status"] == "ok"; })) << state().dump();

  const std::string events = stream(8);
  EXPECT_THAT(events, ::testing::StartsWith("retry: 1000\nevent: history\ndata: {"));
  int attitudes = 0;
  std::uint64_t before = 0;
  std::istringstream lines(events);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("data: ", 0) != 0 || line.find("stillpoint.page/1") == std::string::npos) continue;
    const json attitude = json::parse(line.substr(6))["watch"]["attitude"];
    const auto q = attitude["orientation_xyzw"].get<std::vector<double>>();
    ASSERT_EQ(q.size(), 4U);
    EXPECT_NEAR(std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3])), 1.0, 1e-9);  // rounding of the daemon's
    EXPECT_GE(attitude["sequence"].get<std::uint64_t>(), before);
    before = attitude["sequence"];
    ++attitudes;
  }
  EXPECT_GE(attitudes, 6);
  EXPECT_EQ(end(*daemon), 0);
}

TEST_F(Page, ShowsCalibrationHealthRestsAndLatencyOfEachSensor) {
  configure("", "5");
  const auto daemon = start();
  open();
  ASSERT_TRUE(within_20_s([&] {
    json s = state();
    return s["status"].is_object() && s["coverage"]["share"] > 0.0;
  })) << state().dump();
  const json s = state();
  EXPECT_EQ(s["status"]["sensors"]["gyr"]["health"]["state"], "ok");
  EXPECT_EQ(s["watch"]["calibration"]["sensors"].size(), 3U);
  EXPECT_THAT(s["coverage"]["missing"].get<std::string>(), HasSubstr(" up"));
  ASSERT_FALSE(s["rests"].empty());
  const auto up = s["rests"][0]["up_body"].get<std::vector<double>>();
  EXPECT_NEAR(std::hypot(up[0], up[1], up[2]), 1.0, 1e-9);
  double rested_s = 0.0;
  for (const double part_s : s["coverage"]["rested_s"]) rested_s += part_s;
  EXPECT_GT(rested_s, 0.0);
  EXPECT_LE(rested_s, s["t_s"].get<double>());
  for (const std::string way : {"daemon", "here"}) {
    const json& bins = s["latency"][way];
    EXPECT_EQ(bins["edges_us"].size(), bins["counts"].size() + 1) << way;
    EXPECT_GT(bins["counts"].front().get<int>(), 0) << way;
    EXPECT_GT(bins["counts"].back().get<int>(), 0) << way;
  }
}

TEST_F(Page, SaysStaleAndWhyWhenTheDaemonIsStoppedAndLiveWhenItIsBack) {
  configure("", "1");
  auto daemon = start();
  open();
  ASSERT_TRUE(becomes("live")) << state().dump();
  EXPECT_EQ(end(*daemon), 0);
  ASSERT_TRUE(becomes("stale")) << state().dump();
  EXPECT_TRUE(within_20_s([&] {
    return state()["why"].get<std::string>().find("daemon has gone") != std::string::npos;
  })) << state()["why"];
  daemon = start();
  EXPECT_TRUE(becomes("live")) << state().dump();
}

TEST_F(Page, WithoutADaemonWaitsAndSaysWhatMayBeWrong) {
  open();
  const json s = state();
  EXPECT_EQ(s["freshness"], "waiting");
  EXPECT_THAT(s["why"].get<std::string>(), HasSubstr("is stillpointd running, with the same domain"));
  EXPECT_TRUE(s["watch"]["attitude"].is_null());
  EXPECT_TRUE(s["status"].is_null());
  page_->send(SIGTERM);
  EXPECT_EQ(page_->wait(), 0);
}

TEST_F(Page, IsOneDocumentThatTheBrowserMayLoadNothingFor) {
  open();
  const auto answer = client().Get("/");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  EXPECT_THAT(answer->get_header_value("Content-Type"), HasSubstr("text/html"));
  const std::string policy = answer->get_header_value("Content-Security-Policy");
  EXPECT_THAT(policy, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(policy, Not(HasSubstr("unsafe")));
  for (const std::string loads : {" src=", "@import", "url(", "rel=\"stylesheet\""})
    EXPECT_THAT(answer->body, Not(HasSubstr(loads)));
}

TEST_F(Page, RefusesAnotherHostAsARebindingPageWouldSend) {
  open();
  const std::string port = ":" + std::to_string(port_);
  for (const std::string host : {"evil.example", "evil.example:8420", "127.0.0.1.evil.example",
                                 "localhost.evil.example", "127.0.0.1:80@evil.example", ""})
    for (const std::string path : {"/", "/state", "/events"}) {
      const auto answer = client().Get(path, httplib::Headers{{"Host", host}});
      ASSERT_TRUE(answer) << host;
      EXPECT_EQ(answer->status, 403) << host << path;
    }
  for (const std::string& host : {"localhost" + port, "127.0.0.1" + port, std::string("localhost")})
    EXPECT_EQ(client().Get("/state", httplib::Headers{{"Host", host}})->status, 200) << host;
}

TEST_F(Page, AnswersNothingButGetAndNothingButItsThreeAddresses) {
  open();
  EXPECT_EQ(client().Post("/state", "x", "text/plain")->status, 405);
  EXPECT_EQ(client().Delete("/state")->status, 405);
  EXPECT_EQ(client().Post("/state", "x", "text/plain")->get_header_value("Allow"), "GET");
  EXPECT_EQ(client().Get("/../etc/passwd")->status, 404);
  EXPECT_EQ(client().Get("/state")->status, 200);
}

TEST_F(Page, FeedsEightStreamsTellsTheNinthSoAndTakesItsPlaceWhenOneCloses) {
  open();
  std::atomic<int> fed = 0;
  std::atomic<bool> enough = false;
  std::vector<std::thread> readers;
  for (int i = 0; i < 8; ++i)
    readers.emplace_back([&, is_first = true]() mutable {
      client().Get("/events", [&](const char*, std::size_t) {
        if (is_first) ++fed;
        is_first = false;
        return !enough;
      });
    });
  EXPECT_TRUE(within_20_s([&] { return fed == 8; }));
  const auto ninth = client().Get("/events");
  EXPECT_EQ(client().Get("/state")->status, 200) << "a full house must not stop the rest";
  enough = true;
  for (auto& reader : readers) reader.join();
  ASSERT_TRUE(ninth);
  EXPECT_EQ(ninth->status, 503);
  EXPECT_THAT(ninth->body, HasSubstr("close a page"));
  EXPECT_TRUE(within_20_s([&] { return stream(2).find("stillpoint.page/1") != std::string::npos; }));
}

TEST_F(Page, APortInUseIsNamedWithWhatToDo) {
  open();
  const std::string line = STILLPOINT " page --domain " + std::to_string(io::own_domain()) + " --port ";
  EXPECT_EQ(run(line + std::to_string(port_), scratch_ / "err"), 69);
  EXPECT_EQ(read_file(scratch_ / "err"), "stillpoint: port " + std::to_string(port_) +
                                             " of 127.0.0.1 cannot be had: Address already in use; give another one "
                                             "with --port, or 0 for a free one\n");
  EXPECT_EQ(run(line + "70000", scratch_ / "err"), 64);
}

TEST_F(Page, IsDrawnByABrowserAtBothWidthsAndTellsStaleAndLost) {
  if (run("command -v chromium > /dev/null", scratch_ / "err") != 0) GTEST_SKIP() << "LOUD: SKIPPED, no chromium here";
  configure("", "1");
  const auto daemon = start();
  open();
  ASSERT_TRUE(becomes("live")) << state().dump();
  const std::string address = address_.substr(0, address_.find('\n'));
  Process browser({"/usr/bin/env", "python3", in_source("tests/apps/page_browser.py"), address});
  ASSERT_EQ(browser.some_output(), "drawn\n") << browser.output();
  EXPECT_EQ(end(*daemon), 0);
  ASSERT_EQ(browser.some_output(), "stale\n") << browser.output();
  page_->send(SIGTERM);
  EXPECT_EQ(page_->wait(), 0) << "an open stream must not keep it";
  ASSERT_EQ(browser.some_output(), "lost\n") << browser.output();
  EXPECT_EQ(browser.wait(), 0);
}

}  // namespace
}  // namespace stillpoint::test
