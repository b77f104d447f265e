/* Attitude and self-calibration from C: readings "t_s ax ay az gx gy gz" (m/s^2, rad/s) on standard input.
 * cc attitude.c $(pkg-config --cflags --libs stillpoint_c) */
#include <stdio.h>
#include <stillpoint.h>

int main(void) {
  char why[200];
  const stillpoint_setting settings[] = {{"attitude.use_magnetometer", 0}};
  stillpoint_imu* imu = stillpoint_create(settings, 1, why, sizeof why);
  if (!imu) return fprintf(stderr, "%s\n", why), 1;
  stillpoint_reading r = {.has = STILLPOINT_ACC | STILLPOINT_GYR};
  for (double t; scanf("%lf %lf %lf %lf %lf %lf %lf", &t, r.acc_mps2, r.acc_mps2 + 1, r.acc_mps2 + 2, r.gyr_radps,
                       r.gyr_radps + 1, r.gyr_radps + 2) == 7;) {
    r.t_ns = (int64_t)(1e9 * t);
    stillpoint_push(imu, &r);
  }
  stillpoint_attitude a;
  stillpoint_calibration gyr;
  stillpoint_get_attitude(imu, r.t_ns, &a, sizeof a);
  stillpoint_get_calibration(imu, STILLPOINT_GYR, &gyr, sizeof gyr);
  printf("q %.4f %.4f %.4f %.4f, status %u, gyroscope bias %.4f %.4f %.4f rad/s\n", a.q_world_body_wxyz[0],
         a.q_world_body_wxyz[1], a.q_world_body_wxyz[2], a.q_world_body_wxyz[3], a.status, gyr.bias[0], gyr.bias[1],
         gyr.bias[2]);
  stillpoint_destroy(imu);
  return 0;
}
