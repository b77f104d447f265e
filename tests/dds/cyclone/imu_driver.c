/* A driver of the second vendor: `cyclone_imu_driver reliable|best_effort SAMPLES RATE_HZ` publishes rt/imu/data_raw,
   and rt/imu/mag at a fifth of the rate, in domain 0 and with Cyclone DDS's own settings. It waits until both topics
   have a reader, at most 20 s (code 1); the k-th message of the Imu has k as x of its rate. */
#include <dds/dds.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "Imu.h"

#ifdef __SANITIZE_ADDRESS__
/* Cyclone DDS 0.10.2 keeps 408 bytes at its end; they are not ours to free. */
const char* __lsan_default_suppressions(void);
const char* __lsan_default_suppressions(void) { return "leak:libddsc"; }
#endif

static bool is_met(dds_entity_t writer) {
  dds_publication_matched_status_t met;
  return dds_get_publication_matched_status(writer, &met) == 0 && met.current_count > 0;
}

int main(int argc, char** argv) {
  if (argc != 4) return 64;
  const int samples = atoi(argv[2]), rate_hz = atoi(argv[3]);
  const dds_entity_t participant = dds_create_participant(0, NULL, NULL);
  dds_qos_t* qos = dds_create_qos(); /* as rmw_cyclonedds has a publisher: the last ten are kept */
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  const bool reliable = strcmp(argv[1], "reliable") == 0;
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
  const dds_entity_t imu_writer = dds_create_writer(
      participant, dds_create_topic(participant, &sensor_msgs_msg_dds__Imu__desc, "rt/imu/data_raw", NULL, NULL), qos,
      NULL);
  const dds_entity_t mag_writer = dds_create_writer(
      participant, dds_create_topic(participant, &sensor_msgs_msg_dds__MagneticField__desc, "rt/imu/mag", NULL, NULL),
      qos, NULL);
  if (imu_writer < 0 || mag_writer < 0) return 2;
  for (int i = 0; !(is_met(imu_writer) && is_met(mag_writer)); ++i) {
    if (i == 2000) return 1;
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_sleepfor(DDS_MSECS(1000)); /* until the readers have met their writers as well: what is volatile is not kept */
  const dds_time_t start = dds_time();
  for (int k = 0; k < samples; ++k) {
    const dds_time_t due = start + k * DDS_NSECS_IN_SEC / rate_hz;
    dds_sleepfor(due - dds_time());
    std_msgs_msg_dds__Header_ header = {{(int32_t)(due / DDS_NSECS_IN_SEC), (uint32_t)(due % DDS_NSECS_IN_SEC)},
                                        "imu_link"};
    sensor_msgs_msg_dds__Imu_ imu = {
        .header = header, .angular_velocity = {k, 0.0, 0.0}, .linear_acceleration = {0.0, 0.0, 9.8}};
    imu.orientation_covariance[0] = -1.0;
    if (dds_write(imu_writer, &imu) != 0) return 3;
    const sensor_msgs_msg_dds__MagneticField_ mag = {.header = header, .magnetic_field = {20e-6, 0.0, -43e-6}};
    if (k % 5 == 0 && dds_write(mag_writer, &mag) != 0) return 3;
  }
  dds_wait_for_acks(imu_writer, DDS_SECS(5));
  dds_wait_for_acks(mag_writer, DDS_SECS(5));
  dds_sleepfor(DDS_MSECS(500)); /* best effort: what is on its way */
  dds_delete(participant);      /* with a goodbye: it need not be missed first */
  return 0;
}
