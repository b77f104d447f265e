/* A disk whose fsync takes three seconds, put before the C library's by LD_PRELOAD. */
#include <unistd.h>

int fsync(int file) {
  (void)file;
  sleep(3);
  return 0;
}
