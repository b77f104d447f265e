/* Sends readings as frames of docs/sources.md to standard output:
 *   cc -O2 -o send_frames send_frames.c && ./send_frames 200 | stillpointd --config stream.yaml
 * Replace read_sensor() by your own. The frame is made for little-endian machines. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static uint16_t crc16(const uint8_t* p, size_t n) {
  unsigned crc = 0xFFFF;
  while (n--) {
    crc ^= (unsigned)*p++ << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000) ? (crc << 1 ^ 0x1021) & 0xFFFF : crc << 1 & 0xFFFF;
  }
  return (uint16_t)crc;
}

static void read_sensor(float v[6]) { memcpy(v, (float[]){0, 0, 9.80665f, 0, 0, 0}, 6 * sizeof(float)); }

int main(int argc, char** argv) {
  const long rate_hz = argc > 1 ? atol(argv[1]) : 100, count = argc > 2 ? atol(argv[2]) : -1;
  for (long k = 0; k != count; ++k) {
    struct timespec now, pause = {0, 1000000000L / rate_hz};
    clock_gettime(CLOCK_MONOTONIC, &now);
    const uint32_t t_us = (uint32_t)(now.tv_sec * 1000000LL + now.tv_nsec / 1000);
    float v[6];
    read_sensor(v);
    uint8_t frame[35] = {0xA5, 0x5A, 29, (uint8_t)k, 0x10 | 2 | 1}; /* time, gyroscope, accelerometer */
    memcpy(frame + 5, &t_us, 4);
    memcpy(frame + 9, v, 24); /* m/s^2, rad/s */
    const uint16_t crc = crc16(frame + 2, 31);
    memcpy(frame + 33, &crc, 2);
    if (fwrite(frame, 1, sizeof frame, stdout) != sizeof frame || fflush(stdout) != 0) return 1;
    nanosleep(&pause, NULL);
  }
  return 0;
}
