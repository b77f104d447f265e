#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "bench/portfolio_sets.h"
#include "core/units.h"
#include "io/recording.h"

namespace stillpoint::bench {
namespace {

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

std::vector<std::filesystem::path> recordings_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code absent;
  for (const auto& entry : std::filesystem::directory_iterator(folder, absent))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

struct Counted {
  bool moving_only;
  double from_s;   ///< after the begin
  double begin_s;  ///< rows before are left out
};

Series series_of(const std::string& name, const io::Recording& r, const Counted& counted) {
  Series series{name, {}, {}, {}};
  series.rows.reserve(r.size());
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double since_begin_s = r.t_s(i) - r.t_s(0) - counted.begin_s;
    if (since_begin_s < 0.0) continue;
    const RawSample row = r.sample(i);
    if ((row.has & (kAcc | kGyr | kMag)) != 0) series.rows.push_back(row);
    if (r.ref_q_world_body.empty() || !r.ref_q_world_body[i].allFinite()) continue;
    const Eigen::Vector4d& q = r.ref_q_world_body[i];
    const bool counts = counted.moving_only ? r.ref_moving[i] == 1.0 : since_begin_s >= counted.from_s;
    series.truths.push_back({r.t_ns[i], Quat(q(0), q(1), q(2), q(3)).normalized(), counts});
  }
  return series;
}

PortfolioSet read_set(const std::string& name, const std::string& peer, const std::filesystem::path& folder,
                      double scored_from_s, double begin_s, const std::function<bool(const std::string&)>& belongs) {
  PortfolioSet set{name, peer, scored_from_s, {}};
  const Counted counted{peer == "broad", scored_from_s, begin_s};
  for (const auto& file : recordings_in(folder)) {
    if (!belongs(file.stem().string())) continue;
    if (const auto read = io::read_recording(file.string())) {
      Series series = series_of(file.stem().string(), *read, counted);
      if (!series.rows.empty())
        set.series.push_back(std::move(series));
      else
        std::fprintf(stderr, "%s: no row from %g s on\n", file.c_str(), begin_s);
    } else {
      std::fprintf(stderr, "%s\n", read.error().message.c_str());
    }
  }
  return set;
}

}  // namespace

PeerScores read_peer(const std::string& csv_path) {
  PeerScores scores;
  std::ifstream in(csv_path);
  for (std::string line; std::getline(in, line);) {
    const auto after_name = line.find(',', line.find(',') + 1);
    if (line.empty() || line[0] == '#' || after_name == std::string::npos) continue;
    PeerScore s;
    if (std::sscanf(line.c_str() + after_name, ",%lf,%lf,%lf", &s.total, &s.heading, &s.inclination) == 3)
      scores[line.substr(0, after_name)] = s;
  }
  return scores;
}

std::vector<PortfolioSet> recorded_sets(const std::string& folder, const Wanted& wanted, double begin_s) {
  const auto running = [](const std::string& n) { return contains(n, "Running"); };
  const auto magnets = [](const std::string& n) { return contains(n, "_Dist_"); };
  const std::filesystem::path root(folder);
  std::vector<PortfolioSet> sets;
  const auto add = [&](const char* name, const char* peer, const std::filesystem::path& from, double scored_from_s,
                       const std::function<bool(const std::string&)>& belongs) {
    if (!wanted(name)) return;
    PortfolioSet set = read_set(name, peer, from, scored_from_s, begin_s, belongs);
    if (!set.series.empty()) sets.push_back(std::move(set));
  };
  add("broad", "broad", root / "broad", 0.0, [](const std::string&) { return true; });
  add("phones", "phones/even", root / "phones/even", 5.0,
      [&](const std::string& n) { return !running(n) && !magnets(n); });
  add("phones magnets", "phones/even", root / "phones/even", 5.0,
      [&](const std::string& n) { return !running(n) && magnets(n); });
  add("phones running", "phones/even", root / "phones/even", 5.0, running);
  add("phones streams", "", root / "phones/streams", 60.0, [](const std::string&) { return true; });
  return sets;
}

}  // namespace stillpoint::bench
