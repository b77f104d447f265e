/// What one line or one frame of a stream held, in SI units (uT, degC).
#pragma once
#include "pipeline/stage.h"

namespace stillpoint::sources {

struct Reading {
  RawSample sample;  ///< its time only when `has_time`
  bool has_time = false;
  double time_unit_ns = 1.0;  ///< of the sender's counter: tells at what value it wraps
  double refused_time = 0.0;  ///< as it came, in that unit: of a row whose time is none
  pipeline::StatedNoise noise;
  SamplePart refused_part = kAcc;  ///< whose variance is none, if one was refused
  double refused_variance = 0.0;   ///< as it came; 0: none was
};

/// What a piece of a stream turned out to be.
enum class Piece : std::uint8_t {
  kNone,         ///< more bytes are needed
  kReading,      ///< a reading was filled
  kHeader,       ///< column names
  kIgnored,      ///< a comment, a blank line, a text that is no reading
  kMalformed,    ///< meant as a reading, but damaged
  kTimeRefused,  ///< a reading at a time that is none: a sender that stamps is trusted or told, never stamped by us
};

}  // namespace stillpoint::sources
