/// The stories of docs/calibration_figures.md, "Ordinary use".
#include <numbers>

#include "bench/ordinary_use.h"

namespace stillpoint::bench {
namespace {

using Judge = std::function<void()>;

void large_gyro_offset(OrdinaryUse& life, double dps, const Judge& judge) {
  life.sensor().b_gyr_radps = dps * kRadPerDeg * life.random().direction();
  life.handle(3);
  judge();
  life.handle(17);
  judge();
}

void offset_step(OrdinaryUse& life, double dps, const Judge& judge) {
  life.handle(20);
  life.rest(20.0);
  life.sensor().b_gyr_radps += dps * kRadPerDeg * life.random().direction();
  life.rest(30.0);
  judge();
  life.handle(4);
  judge();
  life.handle(16);
  judge();
}

void ordinary(OrdinaryUse& life, const Judge& judge) {
  life.handle(10);
  judge();
  life.handle(40);
  judge();
}

/// From one station to the next: every stretch of it looks like rest.
void ride(OrdinaryUse& life, double heading, double size_mps2, double stretch_s, const Judge& after_each) {
  for (const double along : {size_mps2, 0.0, -size_mps2, 0.0}) {
    const Vec3 force = along * Vec3(std::cos(heading), std::sin(heading), 0.0);
    life.surroundings().force_mps2 = [force](double) { return force; };
    life.rest(stretch_s);
    after_each();
  }
}

/// Eighteen seconds of steady acceleration, coasting, and the same to a stop.
void train(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  for (int station = 0; station < 4; ++station) {
    ride(life, life.random().uniform(0.0, 6.28), 1.0, 18.0, judge);
    life.turn();
  }
  life.surroundings() = {};
  life.handle(5);
  judge();
}

/// 0.1 m/s^2 at 0.08 Hz, up and down, with the sensor laid down anew now and then.
void swell(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  life.surroundings().force_mps2 = [](double t) {
    return Vec3(0.0, 0.0, 0.1 * std::sin(2.0 * std::numbers::pi * 0.08 * t));
  };
  for (int k = 0; k < 8; ++k) {
    life.turn();
    life.rest(60.0);
    judge();
  }
}

/// A coordinated turn: the specific force keeps its direction in the body and grows by 1 / cos(bank).
void banked_aircraft(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  const double bank = 20.0 * kRadPerDeg, speed_mps = 100.0;
  for (int k = 0; k < 3; ++k) {
    life.rest(40.0);
    life.tilt(Vec3::UnitX(), bank, 4.0);
    const double across = kStandardGravity_mps2 * std::tan(bank), rate = across / speed_mps;
    double turned = 0.0;
    // Tilted about x by the right hand, the body's up leans to -y: there the centre of the circle lies.
    life.surroundings().force_mps2 = [=](double) mutable {
      const Vec3 force(across * std::sin(turned), -across * std::cos(turned), 0.0);
      turned += rate / 50.0;
      return force;
    };
    life.surroundings().vertical_rate_radps = rate;
    life.rest(2.0 * std::numbers::pi / rate);  // once around
    judge();
    life.surroundings() = {};
    life.tilt(Vec3::UnitX(), -bank, 4.0);
  }
  life.handle(5);
  judge();
}

void turntable_from_the_start(OrdinaryUse& life, const Judge& judge) {
  life.surroundings().vertical_rate_radps = life.random().uniform(0.3, 3.0) * kRadPerDeg;
  life.rest(60.0);
  judge();
  life.rest(1200.0);
  judge();
  life.surroundings() = {};
  life.handle(12);
  judge();
}

void drop(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  life.sensor().b_acc_mps2 += 0.6 * life.random().direction();
  life.sensor().b_gyr_radps += 0.5 * kRadPerDeg * life.random().direction();
  life.handle(15);
  judge();
  life.handle(25);
  judge();
}

void swap(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  life.sensor() = UsedSensor(life.random());
  life.handle(15);
  judge();
  life.handle(35);
  judge();
}

void wrong_range(OrdinaryUse& life, const Judge& judge) {
  life.sensor().H_acc /= 1.31;
  life.handle(20);
  judge();
  life.handle(40);
  judge();
}

void idling_engine(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  life.surroundings().shaking_mps2 = 0.4;
  for (int k = 0; k < 5; ++k) {
    life.turn();
    life.rest(40.0);
    judge();
  }
}

void elevator(OrdinaryUse& life, const Judge& judge) {
  life.handle(25);
  for (int ride = 0; ride < 10; ++ride) {
    const double up = life.random().uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    for (const auto& [force, seconds] : {std::pair{up, 3.0}, {0.0, 9.0}, {-up, 3.0}, {0.0, 6.0}}) {
      life.surroundings().force_mps2 = [force = force](double) { return Vec3(0.0, 0.0, force); };
      life.rest(seconds);
    }
    judge();
    life.turn();
  }
  judge();
}

/// Nothing is known yet, and every stretch that looks like rest may be steady acceleration.
void tram_from_the_start(OrdinaryUse& life, const Judge& judge) {
  for (int station = 0; station < 12; ++station) {
    const double heading = life.random().uniform(0.0, 6.28), size = life.random().uniform(0.5, 1.2);
    ride(life, heading, size, 10.0, [] {});
    judge();
    life.turn();
  }
  life.surroundings() = {};
  life.handle(25);
  judge();
}

void coarse_gyroscope(OrdinaryUse& life, const Judge& judge) {
  life.sensor().gyr_lattice_radps = 0.25 * kRadPerDeg;
  ordinary(life, judge);
}

/// Warmer by 30 K within a quarter of an hour, handled all the while, and no thermometer tells.
void warms_unseen(OrdinaryUse& life, const Judge& judge) {
  life.sensor().b_acc_mps2_per_K = life.random().normal3(0.005);
  life.sensor().b_gyr_radps_per_K = life.random().normal3(0.02 * kRadPerDeg);
  life.handle(20);
  const double start_s = life.now_s();
  life.surroundings().temp_degC = [start_s](double t_s) {
    return Surroundings::kTold_degC + 30.0 * (1.0 - std::exp((start_s - t_s) / 300.0));
  };
  for (int k = 0; k < 12; ++k) {
    life.handle(10);
    judge();
  }
}

void clips_unsaid(OrdinaryUse& life, const Judge& judge) {
  life.sensor().acc_limit_mps2 = 8.0;
  ordinary(life, judge);
}

}  // namespace

const std::vector<UseCase>& use_cases() {
  static const std::vector<UseCase> kCases{
      {"ordinary", false, ordinary},
      {"ordinary, magnetometer", true, ordinary},
      {"gyro offset 7 deg/s", false, [](auto& life, const auto& judge) { large_gyro_offset(life, 7.0, judge); }},
      {"gyro offset 20 deg/s", false, [](auto& life, const auto& judge) { large_gyro_offset(life, 20.0, judge); }},
      {"train", false, train},
      {"swell", false, swell},
      {"banked aircraft", false, banked_aircraft},
      {"turntable from the start", false, turntable_from_the_start},
      {"offset step 0.2 deg/s", false, [](auto& life, const auto& judge) { offset_step(life, 0.2, judge); }},
      {"offset step 1 deg/s", false, [](auto& life, const auto& judge) { offset_step(life, 1.0, judge); }},
      {"offset step, magnetometer", true, [](auto& life, const auto& judge) { offset_step(life, 1.0, judge); }},
      {"drop", false, drop},
      {"swap", false, swap},
      {"scale error 31 %", false, wrong_range},
      {"idling engine", false, idling_engine},
      {"elevator", false, elevator},
      {"tram from the start", false, tram_from_the_start},
      {"coarse gyroscope", false, coarse_gyroscope},
      {"warms unseen", false, warms_unseen},
      {"clips unsaid", false, clips_unsaid},
  };
  return kCases;
}

}  // namespace stillpoint::bench
