/// The simulated sensor: motion and surroundings in, readings out, one row at a time and without allocation, so that
/// the daemon can use it as its source. In physical order: force, rate and field at the place and at the time of the
/// sensor's clock; the element (element.h); readings (triad.h); transport; beside them the reference.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "simulation/clock.h"
#include "simulation/config.h"
#include "simulation/element.h"
#include "simulation/environment.h"
#include "simulation/motion.h"
#include "simulation/reference.h"
#include "simulation/triad.h"

namespace stillpoint::sim {

/// One row of the recording that the simulated sensor gives, and the truth of that time.
struct SimulatedSample {
  RawSample sample;
  double current_A = 0.0, supply_V = 0.0;
  bool has_reference = false;
  Quat ref_q_world_body = Quat::Identity();  ///< with the reference's errors
  Vec3 ref_position_m = Vec3::Zero();
  bool moving = false;
  Quat true_q_world_body = Quat::Identity();
  Vec3 true_position_m = Vec3::Zero();
  Vec3 true_rate_radps = Vec3::Zero();
  Array3 true_acc_mps2{}, true_gyr_radps{}, true_mag_uT{};  ///< f, omega, m at the body's reference point, no effect
};

class Simulator {
 public:
  /// Pre: the effects' IDs and counts are those of the catalogue (io::read_simulation sees to it).
  Simulator(const SimulationConfig& config, std::shared_ptr<const Motion> motion, std::uint64_t seed,
            RecordedEnvironment recorded = {});

  /// The next row; false after the motion's end. Rows lost in transport are skipped, their sequence numbers with them.
  bool next(SimulatedSample& out) noexcept;

  /// u = H (y - B) of a reading; for measuring what an effect changes.
  [[nodiscard]] Vec3 corrected(Sensor sensor, const Array3& y) const noexcept;
  /// Whether a table of the file was asked outside its range so far: what it then gave is its end value, no truth.
  [[nodiscard]] bool outside_table() const noexcept { return outside_table_; }
  [[nodiscard]] bool has(Sensor sensor) const noexcept { return chains_[static_cast<std::size_t>(sensor)].has_value(); }

 private:
  /// Axes of one triad that share clock and frame. Usually all three; faults on chosen axes split them.
  struct Channel {
    Element element;
    int axis;   ///< the first of them
    Vec3 axes;  ///< 1 on these axes, else 0
    double last_t_s;
  };
  /// A triad and its channels.
  struct Chain {
    Triad triad;
    std::vector<Channel> channels;
  };

  void add_chain(Sensor sensor, const TriadConfig& triad, std::uint64_t seed);
  [[nodiscard]] std::uint32_t frames_of(Sensor sensor, int axis, double t_s) const noexcept;
  [[nodiscard]] MotionState motion_at(double t_s) noexcept;
  [[nodiscard]] Vec3 driver_at(std::string_view name, double t_s) noexcept;
  void fill_instant(double t_s, std::uint32_t frames) noexcept;
  const Vec3& at_place(Sensor sensor, double t_s, std::uint32_t frames) noexcept;
  [[nodiscard]] Vec3 signal_of(Sensor sensor, Channel& channel) noexcept;
  void read_triad(Sensor sensor, double row_t_s, RawSample& out) noexcept;
  void write_reference(double row_t_s, SimulatedSample& out) noexcept;
  void track_bias(double row_t_s, RawSample& out) noexcept;
  void transport(double row_t_s, RawSample& out) noexcept;
  [[nodiscard]] bool due(Sensor sensor) const noexcept;

  SimulationConfig config_;
  std::shared_ptr<const Motion> motion_;
  Environment environment_;
  Clock clock_;
  Reference reference_;
  std::array<std::optional<Chain>, 3> chains_;
  struct Duplicates : ActiveEffect {
    Stream random;
    Duplicates(const ActiveEffect& e, std::uint64_t seed) : ActiveEffect(e), random(seed, source) {}
  };
  std::vector<Duplicates> dup_;
  std::vector<ActiveEffect> tracker_, frame_;
  std::vector<Mat3> R_sensor_body_;  ///< one per entry of frame_
  Stream lost_random_, aux_random_;
  /// The motion at the last few times asked for: filters of two sensors step through the same ones.
  struct Remembered {
    double t_s;
    MotionState motion;
  };
  std::array<Remembered, 8> remembered_;
  std::size_t oldest_ = 0;
  bool filters_ = false;  ///< else no time is asked for twice but the row's own, which now_ holds
  Instant now_;
  std::array<bool, 3> placed_{};  ///< which of now_'s force, rate and field carry the laws of their place
  double now_t_s_;
  std::uint32_t now_frames_ = 0;  ///< bit k: now_ is seen through frame_[k]
  bool outside_table_ = false;
  std::uint64_t row_ = 0, rows_ = 0;
  RawSample last_sent_;
  // sys_tracker: short means of rate and force tell rest, the bias follows the rate at rest
  Vec3 tracked_bias_ = Vec3::Zero(), rate_mean_ = Vec3::Zero();
  double rate_spread_ = 1.0;
};

/// All rows at once.
[[nodiscard]] std::vector<SimulatedSample> simulate(const SimulationConfig& config,
                                                    std::shared_ptr<const Motion> motion, std::uint64_t seed,
                                                    RecordedEnvironment recorded = {});
/// The same with the motion of the configuration. Pre: config.motion.
[[nodiscard]] std::vector<SimulatedSample> simulate(const SimulationConfig& config, std::uint64_t seed);

}  // namespace stillpoint::sim
