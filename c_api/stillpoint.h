/* Attitude from an inertial and magnetic sensor that calibrates itself while it lies still: the C interface.
 *
 *   stillpoint_imu* s = stillpoint_create(NULL, 0, NULL, 0);
 *   stillpoint_push(s, &reading);
 *   stillpoint_get_attitude(s, reading.t_ns, &attitude, sizeof attitude);
 *   stillpoint_destroy(s);
 *
 * Stable: what stands here keeps its meaning and its place; structs only grow at their end, and every call that fills
 * or takes one is told the caller's size of it. One handle is one sensor; calls on one handle come from one thread at
 * a time. Only stillpoint_create and stillpoint_destroy use the heap; nothing here throws, locks or prints.
 * SI units and radians; temperature in degC, magnetic field in uT. World: east, north, up. Body: x forward, y left,
 * z up; at rest with z up an accelerometer reads +g. */
#ifndef STILLPOINT_H
#define STILLPOINT_H

#include <stddef.h>
#include <stdint.h>

#define STILLPOINT_API_VERSION 1

#if defined(__GNUC__)
#define STILLPOINT_PUBLIC __attribute__((visibility("default")))
#else
#define STILLPOINT_PUBLIC
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stillpoint_imu stillpoint_imu; /* one sensor and all that is learnt about it */

/* What a call returns. */
enum {
  STILLPOINT_DONE = 0,
  STILLPOINT_REFUSED = 1,  /* the reading was not used: not finite, repeated, or its time does not advance */
  STILLPOINT_BAD_CALL = -1 /* a null pointer, a size that does not fit, an unknown sensor, a value not finite */
};

/* Parts of a reading; also the number of a sensor where one is asked for. */
enum { STILLPOINT_ACC = 1, STILLPOINT_GYR = 2, STILLPOINT_MAG = 4, STILLPOINT_TEMP = 8 };

/* stillpoint_attitude.status */
enum {
  STILLPOINT_INITIALIZING = 0, /* no attitude yet: identity, covariance of ignorance */
  STILLPOINT_OK = 1,
  STILLPOINT_DEGRADED = 2, /* a sensor is clipped, disturbed, missing or late: the covariance says what that costs */
  STILLPOINT_STALE = 3     /* no reading for stale_after_s: the last attitude, growing older */
};

/* stillpoint_attitude.heading: what the heading is measured against */
enum {
  STILLPOINT_HEADING_RELATIVE = 0,
  STILLPOINT_HEADING_MAGNETIC = 1,
  STILLPOINT_HEADING_TRUE = 2,
  STILLPOINT_HEADING_DISTURBED = 3
};

/* One reading as the sensor gave it: bias and matrix not yet applied. */
typedef struct {
  int64_t t_ns; /* time of the measurement; must advance from reading to reading */
  double acc_mps2[3];
  double gyr_radps[3];
  double mag_uT[3];
  double temp_degC;
  uint32_t has; /* which of these were measured: STILLPOINT_ACC | ... */
} stillpoint_reading;

typedef struct {
  int64_t t_ns;                          /* of the reading behind it */
  double q_world_body_wxyz[4];           /* Hamilton, unit norm, always finite; turns body vectors into the world */
  double orientation_covariance_rad2[9]; /* row-major, of the rotation error about the fixed world axes */
  double sigma_rpy_rad[3];               /* standard deviations of roll, pitch and yaw */
  double rate_radps[3];                  /* body frame, calibrated */
  double gyro_bias_radps[3];             /* what the filter takes off beyond the calibration */
  uint64_t calibration_version;          /* 0: the calibration of the start */
  uint32_t at_rest;                      /* 1: the body lies still */
  uint32_t status;                       /* STILLPOINT_INITIALIZING ... STILLPOINT_STALE */
  uint32_t heading;                      /* STILLPOINT_HEADING_... */
} stillpoint_attitude;

/* stillpoint_calibration.status */
enum {
  STILLPOINT_CALIBRATION_FACTORY = 0, /* nothing learnt yet */
  STILLPOINT_CALIBRATION_OK = 1,
  STILLPOINT_CALIBRATION_TOO_FEW_WINDOWS = 2,
  STILLPOINT_CALIBRATION_NOT_OBSERVABLE = 3,
  STILLPOINT_CALIBRATION_NOT_POSITIVE_DEFINITE = 4,
  STILLPOINT_CALIBRATION_CLIPPED = 5,
  STILLPOINT_CALIBRATION_STUCK = 6,
  STILLPOINT_CALIBRATION_REPLACED = 7
};

/* Of one sensor: u = matrix * (reading - bias(T)), bias(T) = bias + bias_per_K tau + bias_per_K2 tau^2 with
 * tau = T - temp_ref_degC, T held inside temp_min_degC ... temp_max_degC. In the sensor's unit. */
typedef struct {
  double matrix[9]; /* row-major */
  double bias[3];
  double bias_per_K[3];
  double bias_per_K2[3];
  double temp_ref_degC, temp_min_degC, temp_max_degC;
  double bias_covariance[9]; /* of bias; zeros: not known */
  double norm_sd;            /* standard deviation of the calibrated norm over the sphere; 0: not known */
  uint32_t windows;          /* rest windows behind these numbers */
  uint32_t status;           /* STILLPOINT_CALIBRATION_... */
} stillpoint_calibration;

/* A setting by its name in the daemon's configuration, such as {"attitude.use_magnetometer", 0}: all numbers and flags
 * under sensor.limits, rest, calibration and attitude, output.initial_heading_rad, and stale_after_s. */
typedef struct {
  const char* name;
  double value;
} stillpoint_setting;

/* Null where a setting is unknown or out of range, or memory is short; `error`, when not null, then says why. */
STILLPOINT_PUBLIC stillpoint_imu* stillpoint_create(const stillpoint_setting* settings, size_t count, char* error,
                                                    size_t error_size);
STILLPOINT_PUBLIC void stillpoint_destroy(stillpoint_imu* s);

/* Takes one reading, of all sensors or of one at its own time; the gyroscope leads: a reading without it joins the next
 * one with it. Finds rest, calibrates, corrects, estimates. Some 1 us; solving at the end of a rest window some
 * 10 us more. */
STILLPOINT_PUBLIC int stillpoint_push(stillpoint_imu* s, const stillpoint_reading* reading);

/* The attitude after the last reading. `now_ns`, on the readings' clock, decides whether it is stale. */
STILLPOINT_PUBLIC int stillpoint_get_attitude(const stillpoint_imu* s, int64_t now_ns, stillpoint_attitude* out,
                                              size_t size);

/* The calibration in use of STILLPOINT_ACC, _GYR or _MAG. */
STILLPOINT_PUBLIC int stillpoint_get_calibration(const stillpoint_imu* s, int sensor, stillpoint_calibration* out,
                                                 size_t size);
/* Starts anew from this one, as from a factory calibration: what was learnt and the attitude are forgotten. */
STILLPOINT_PUBLIC int stillpoint_set_calibration(stillpoint_imu* s, int sensor,
                                                 const stillpoint_calibration* calibration, size_t size);

/* All that was learnt, with its uncertainty, to be kept over a restart: bytes for this version of the library on this
 * kind of machine. Restoring refuses any others (STILLPOINT_BAD_CALL) and starts the attitude anew. */
STILLPOINT_PUBLIC size_t stillpoint_state_size(void);
STILLPOINT_PUBLIC int stillpoint_save_state(const stillpoint_imu* s, void* out, size_t size);
STILLPOINT_PUBLIC int stillpoint_restore_state(stillpoint_imu* s, const void* state, size_t size);

/* STILLPOINT_API_VERSION of the library that is linked. */
STILLPOINT_PUBLIC int stillpoint_api_version(void);

#ifdef __cplusplus
}
#endif
#endif
