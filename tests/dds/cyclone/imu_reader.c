/* The second vendor: a Cyclone DDS subscriber of rt/imu/data. `cyclone_imu_reader DOMAIN` prints the writer's USER_DATA
   and one message, every field in order, and ends; code 1 when none came within ten seconds. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "Imu.h"

#ifdef __SANITIZE_ADDRESS__
/* Cyclone DDS 0.10.2 keeps 408 bytes at its end; they are not ours to free. */
const char* __lsan_default_suppressions(void);
const char* __lsan_default_suppressions(void) { return "leak:libddsc"; }
#endif

static void print_user_data(dds_entity_t reader) {
  dds_instance_handle_t writers[4];
  const dds_return_t n = dds_get_matched_publications(reader, writers, 4);
  for (dds_return_t i = 0; i < n && i < 4; ++i) {
    dds_builtintopic_endpoint_t* writer = dds_get_matched_publication_data(reader, writers[i]);
    void* data = NULL;
    size_t size = 0;
    if (writer == NULL) continue;
    if (dds_qget_userdata(writer->qos, &data, &size) && size > 0) printf("%.*s\n", (int)size, (const char*)data);
    dds_free(data);
    dds_builtintopic_free_endpoint(writer);
  }
}

static void print_array(const double* values, int n) {
  for (int i = 0; i < n; ++i) printf(" %.17g", values[i]);
}

static void print_message(const sensor_msgs_msg_dds__Imu_* m) {
  printf("%s %d %u", m->header.frame_id, m->header.stamp.sec, m->header.stamp.nanosec);
  printf(" %.17g %.17g %.17g %.17g", m->orientation.x, m->orientation.y, m->orientation.z, m->orientation.w);
  print_array(m->orientation_covariance, 9);
  printf(" %.17g %.17g %.17g", m->angular_velocity.x, m->angular_velocity.y, m->angular_velocity.z);
  print_array(m->angular_velocity_covariance, 9);
  printf(" %.17g %.17g %.17g", m->linear_acceleration.x, m->linear_acceleration.y, m->linear_acceleration.z);
  print_array(m->linear_acceleration_covariance, 9);
  printf("\n");
}

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_entity_t topic = dds_create_topic(participant, &sensor_msgs_msg_dds__Imu__desc, "rt/imu/data", NULL, NULL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  if (reader < 0) return 2;
  for (int i = 0; i < 1000; ++i) {
    void* message = NULL;
    dds_sample_info_t info;
    if (dds_take(reader, &message, &info, 1, 1) > 0 && info.valid_data) {
      print_user_data(reader);
      print_message(message);
      return 0;
    }
    dds_sleepfor(DDS_MSECS(10));
  }
  return 1;
}
