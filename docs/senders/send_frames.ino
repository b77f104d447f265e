// Sends readings as frames of docs/sources.md over the serial line. Replace readSensor() by your sensor's library.
//   source: {kind: stream, from: /dev/ttyUSB0, baud: 115200}

static uint16_t crc16(const uint8_t* p, size_t n) {
  uint16_t crc = 0xFFFF;
  while (n--) {
    crc ^= (uint16_t)*p++ << 8;
    for (uint8_t bit = 0; bit < 8; ++bit) crc = crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1;
  }
  return crc;
}

// m/s^2, then rad/s.
static void readSensor(float v[6]) { v[0] = v[1] = v[3] = v[4] = v[5] = 0; v[2] = 9.80665f; }

void setup() { Serial.begin(115200); }

void loop() {
  static uint32_t next = micros();
  static uint8_t counter = 0;
  if ((int32_t)(micros() - next) < 0) return;
  next += 10000;  // 100 Hz; 115200 baud carries 300
  float v[6];
  const uint32_t t_us = micros();
  readSensor(v);
  uint8_t frame[35] = {0xA5, 0x5A, 29, counter++, 0x10 | 2 | 1};  // time, gyroscope, accelerometer
  memcpy(frame + 5, &t_us, 4);
  memcpy(frame + 9, v, 24);
  const uint16_t crc = crc16(frame + 2, 31);
  memcpy(frame + 33, &crc, 2);
  Serial.write(frame, sizeof frame);
}
