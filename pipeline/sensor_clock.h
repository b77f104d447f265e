/// Times of sensor readings: the pipeline's own time, which only goes forward, and how often each sensor speaks.
#pragma once
#include <algorithm>
#include <cstdint>

namespace stillpoint::pipeline {

/// A running median of steps: moves by a fixed share towards each one, so single gaps hardly count.
class UsualStep {
 public:
  void learn(std::int64_t step_ns) noexcept {
    const auto step = static_cast<double>(step_ns);
    if (ns_ == 0.0)
      ns_ = step;
    else
      ns_ *= step > ns_ ? 1.02 : 1.0 / 1.02;
  }
  [[nodiscard]] double ns() const noexcept { return ns_; }  ///< 0 before it is known

 private:
  double ns_ = 0.0;
};

/// When one sensor was last heard, in the pipeline's time.
class ReadingTimes {
 public:
  /// False: not after the last one.
  [[nodiscard]] bool follows(std::int64_t t_ns) const noexcept { return !seen_ || t_ns > last_ns_; }
  void note(std::int64_t t_ns) noexcept {
    if (seen_ && t_ns > last_ns_) usual_.learn(t_ns - last_ns_);
    last_ns_ = seen_ ? std::max(last_ns_, t_ns) : t_ns;
    seen_ = true;
  }
  [[nodiscard]] bool seen() const noexcept { return seen_; }
  /// Later than `factor` times its usual step after its last reading; one second where that is not known yet.
  [[nodiscard]] bool overdue(std::int64_t t_ns, double factor) const noexcept {
    const double allowed_ns = usual_.ns() > 0.0 ? factor * usual_.ns() : 1e9;
    return static_cast<double>(t_ns - last_ns_) > allowed_ns;
  }
  [[nodiscard]] double usual_step_ns() const noexcept { return usual_.ns(); }

 private:
  std::int64_t last_ns_ = 0;
  UsualStep usual_;
  bool seen_ = false;
};

/// The pipeline's time from a sensor's: the same, shifted where the sensor's clock was set.
class SensorClock {
 public:
  struct Step {
    std::int64_t t_ns = 0;  ///< in the pipeline's time
    bool gap = false;
    bool clock_was_set = false;
    std::int64_t gap_ns = 0;  ///< 0 unless there is one on one time base
  };
  /// False: this time does not advance, or is none. Remembers a run of such times: eight in a row that advance among
  /// themselves, all behind, are a clock that was set back.
  [[nodiscard]] bool advance(std::int64_t sensor_ns, double gap_factor, double clock_step_s, Step& out) noexcept;
  /// The reading of the last advance() is used: time stands there from now on.
  void keep(std::int64_t sensor_ns, std::int64_t t_ns) noexcept {
    last_sensor_ns_ = sensor_ns;
    last_ns_ = t_ns;
    started_ = true;
  }
  [[nodiscard]] bool started() const noexcept { return started_; }
  [[nodiscard]] std::int64_t last_ns() const noexcept { return last_ns_; }
  /// The pipeline's time of another reading by the same clock.
  [[nodiscard]] std::int64_t in_pipeline_time(std::int64_t sensor_ns) const noexcept {
    return started_ ? last_ns_ + (sensor_ns - last_sensor_ns_) : sensor_ns;
  }
  [[nodiscard]] double usual_step_ns() const noexcept { return usual_.ns(); }
  /// 126 years either way: the difference of two such times fits into 64 bits, a time beyond is none.
  [[nodiscard]] static bool is_time(std::int64_t ns) noexcept { return ns <= kLargest_ns && ns >= -kLargest_ns; }

 private:
  static constexpr std::int64_t kLargest_ns = 4'000'000'000'000'000'000;

  std::int64_t last_ns_ = 0;           ///< pipeline time of the last reading let through
  std::int64_t last_sensor_ns_ = 0;    ///< the sensor's own time of it
  std::int64_t backward_last_ns_ = 0;  ///< last of a run of sensor times that lie behind
  int backward_run_ = 0;
  UsualStep usual_;
  bool started_ = false;
};

}  // namespace stillpoint::pipeline
