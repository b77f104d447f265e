#!/usr/bin/env python3
"""Writes the binary inputs of tests/fuzz/corpus, valid ones of each kind: make_inputs.py. The others are written by hand,
caught on the wire (rtps/announcement) or what harnesses have found."""
import binascii
import gzip
import io
import math
import pathlib
import struct
import zipfile

CORPUS = pathlib.Path(__file__).parent / "corpus"


def write(name, data):
    (CORPUS / name).parent.mkdir(exist_ok=True)
    (CORPUS / name).write_bytes(data)


def ulog(topics, rows):
    message = lambda kind, body: struct.pack("<H", len(body)) + kind + body
    out = b"ULog\x01\x12\x35\x01" + bytes(8)
    out += message(b"B", bytes(40)) + message(b"I", b"\x0eint32_t ver_hw\x01\x00\x00\x00")
    for number, (topic, fields, _) in enumerate(topics):
        out += message(b"F", f"{topic}:{fields}".encode())
        out += message(b"A", struct.pack("<BH", 0, number) + topic.encode())
    for k in range(rows):
        for number, (_, _, row) in enumerate(topics):
            out += message(b"D", struct.pack("<H", number) + row(k))
    return out + message(b"O", struct.pack("<H", 5)) + message(b"L", b"6" + bytes(8) + b"landed")


SINGLE = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;uint8_t[4] _padding0;"
single = lambda k: struct.pack("<QQI4f4x", 5000100 + 5000 * k, 5000000 + 5000 * k, 17, 0.1 * k, -0.2, 9.8, 31.5)
COMBINED = "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;"
combined = lambda k: struct.pack("<Q3fIi3f", 5000 * k, 0.1, 0.2, 0.3 * k, 5000, 0, 0.1, 0.2, 9.8)
write("ulog/sensors", ulog([(t, SINGLE, single) for t in ("sensor_accel", "sensor_gyro", "sensor_mag")], 4))
write("ulog/combined", ulog([("sensor_combined", COMBINED, combined)], 5))


class Cdr:
    """CDR in either byte order, numbers aligned behind the four bytes of its header."""

    def __init__(self, order="<"):
        self.order, self.bytes = order, b"\0\1\0\0" if order == "<" else b"\0\0\0\0"

    def put(self, kinds, *values):
        for kind, value in zip(kinds, values):
            size = struct.calcsize(kind)
            self.bytes += bytes(-(len(self.bytes) - 4) % size) + struct.pack(self.order + kind, value)
        return self

    def text(self, text):
        self.put("I", len(text) + 1).bytes += text.encode() + b"\0"
        return self

    def doubles(self, *values):
        return self.put("d" * len(values), *values)


def imu(k, order="<", measured=True):
    flag = 0.0 if measured else -1.0
    c = Cdr(order).put("iI", 1700000000, 5000000 * k).text("imu_link").doubles(0, 0, 0, 1, -1, *[0] * 8)
    return c.doubles(0.1, 0.2, 0.3 * k, flag, *[0] * 8).doubles(0.1, 0.2, 9.8, flag, *[0] * 8).bytes


def field(k):
    return Cdr().put("iI", 1700000000, 5000000 * k).text("imu_link").doubles(2e-5, 0, -4e-5, *[0] * 9).bytes


temperature = lambda k: Cdr().put("iI", 1700000000, 5000000 * k).text("imu_link").doubles(25.5, 0).bytes
listed = lambda messages: b"".join(bytes([kind, (len(m) + 1) // 2]) + m + bytes(len(m) % 2) for kind, m in messages)
write("ros2_messages/imu_and_field", listed([(0, imu(0)), (1, field(0)), (0, imu(1)), (2, imu(2)), (1, field(3))]))
write("ros2_messages/big_endian_and_unmeasured", listed([(0, imu(0, ">")), (4, imu(1, "<", False)), (240, imu(0)), (0, imu(5))]))

record = lambda opcode, body: struct.pack("<BQ", opcode, len(body)) + body
prefixed = lambda data: struct.pack("<I", len(data)) + data
KINDS = [(b"Imu", imu), (b"MagneticField", field), (b"Temperature", temperature)]


def mcap_content():
    out = b""
    for number, (kind, message) in enumerate(KINDS, 1):
        out += record(3, struct.pack("<H", number) + prefixed(b"sensor_msgs/msg/" + kind) + prefixed(b"ros2msg") + prefixed(b""))
        out += record(4, struct.pack("<HH", number, number) + prefixed(b"/imu") + prefixed(b"cdr") + prefixed(b""))
        for k in range(3):
            out += record(5, struct.pack("<HIQQ", number, k, k, k) + message(k))
    return out


def lz4(data):
    """A frame of one stored block; the header's checksum is the second byte of XXH32("\\x60\\x40", seed 0)."""
    descriptor = b"\x60\x40"
    hashed = (374761393 + len(descriptor)) & 0xFFFFFFFF
    for byte in descriptor:
        hashed = (hashed + byte * 374761393) & 0xFFFFFFFF
        hashed = ((hashed << 11 | hashed >> 21) * 2654435761) & 0xFFFFFFFF
    hashed = ((hashed ^ hashed >> 15) * 2246822519) & 0xFFFFFFFF
    hashed = ((hashed ^ hashed >> 13) * 3266489917) & 0xFFFFFFFF
    hashed ^= hashed >> 16
    block = struct.pack("<I", len(data) | 1 << 31) + data
    return b"\x04\x22\x4d\x18" + descriptor + bytes([hashed >> 8 & 0xFF]) + block + bytes(4)


def zstd(data):
    """A frame of one raw block, its size in the header."""
    return b"\x28\xb5\x2f\xfd\xa0" + struct.pack("<I", len(data)) + struct.pack("<I", len(data) << 3 | 1)[:3] + data


def mcap(how, packed):
    data = mcap_content()
    body = struct.pack("<QQQI", 0, 2, len(data), 0) + prefixed(how) + struct.pack("<Q", len(packed(data))) + packed(data)
    return b"\x89MCAP0\r\n" + record(1, prefixed(b"ros2") + prefixed(b"")) + record(6, body) + record(15, bytes(4)) + record(2, bytes(20)) + b"\x89MCAP0\r\n"


write("mcap/plain", b"\x89MCAP0\r\n" + mcap_content() + record(15, bytes(4)))
write("mcap/chunk", mcap(b"", lambda d: d))
write("mcap/lz4", mcap(b"lz4", lz4))
write("mcap/zstd", mcap(b"zstd", zstd))


def table(header, sensor):
    return (header + "\n" + "".join(f"{0.01 * k:.2f}," + ",".join(f"{x:.3f}" for x in sensor(k)) + "\n" for k in range(12))).encode()


def zipped(members, method):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), data, method)
    return out.getvalue()


phyphox = [("Accelerometer.csv", table('"Time (s)","X (m/s^2)","Y (m/s^2)","Z (m/s^2)"', lambda k: (math.sin(k), 0.2, 9.8))),
           ("Gyroscope.csv", table('"Time (s)","X (rad/s)","Y (rad/s)","Z (rad/s)"', lambda k: (0.1, 0.2, 0.1 * k))),
           ("meta/device.csv", b"property,value\nversion,1\n"), ("__MACOSX/._x", b"x")]
write("packed_import/phyphox.zip", zipped(phyphox, zipfile.ZIP_DEFLATED))
write("packed_import/stored.zip", zipped(phyphox[:2], zipfile.ZIP_STORED))
write("packed_import/table.gz", gzip.compress(table("time_s,ax_g,ay_g,az_g,wx_dps,wy_dps,wz_dps", lambda k: (0, 0, 1, k, 2, 3)), mtime=0))
write("packed_import/bag.zip", zipped([("bag.mcap", mcap(b"", lambda d: d))], zipfile.ZIP_DEFLATED))


def frame(counter, flags, time_us, values):
    payload = struct.pack("<B", flags) + (struct.pack("<I", time_us) if flags & 16 else b"") + struct.pack(f"<{len(values)}f", *values)
    body = struct.pack("<BB", len(payload), counter) + payload
    return b"\xa5\x5a" + body + struct.pack("<H", binascii.crc_hqx(body, 0xFFFF))


frames = [frame(k, 0x1F, 10000 * k, (0, 0, 9.8, 0.1, 0.2, 0.3, 20, 0, -40, 25)) for k in range(6)]
write("stream_frames/whole", b"0\x10\x00\x00\x0a" + b"".join(frames))
write("stream_frames/cut_wrapped_and_sparse", b"1\x03\x0b\x00\x0a" + b"boot\n" + frames[0][:20] + b"".join(
    [frame(255, 0x11, 4294960000, (0, 0, 9.8)), frame(0, 0x11, 2704, (0, 0, 9.8)), frame(0, 0x02, 0, (0.1, 0.2, math.nan)), frame(7, 0x08, 0, (25,))]))

own = lambda kind, message: bytes([kind]) + struct.pack("<H", len(message)) + message


def attitude(k):
    c = Cdr().put("qqqQQQQ", 10**7 * k, 10**9 + 10**7 * k, 10**9, k, 3, 0, 0).doubles(0, 0, 0, 1, *[0.1] * 6)
    return c.doubles(*[1e-4, 0, 0] * 3, *[0.01] * 3, 25.5).put("B" * 8, 1, 1, 1, 0, 1, 0, 3, 0).bytes


def calibration():
    c = Cdr().put("qQ", 5, 7).text("bmi270:42")
    for sensor in range(3):
        c.put("BBI", sensor, 1 + sensor, 12).doubles(*[0.1] * 9, 1, 0, 0, 0, 1, 0, 0, 0, 1, *[1e-6] * 9, 0.01, 25, 20, 30).text("why\x1b[2J")
    return c.bytes


def diagnostics():
    c = Cdr().put("qddd", 10**9, 12.5, 199.5, 200).put("QQ", 2500, 1).doubles(0.2).put("Q" * 8, *range(8)).doubles(*[100] * 5, 25.5).put("BB", 1, 1)
    for _ in range(4):
        c.put("BBqd", 0, 0, 0, 0.5)
    for text in ("bmi270:42", "stream /dev/ttyUSB0", "running", "", "turning at 0.6 deg/s"):
        c.text(text)
    return c.put("Q" * 640, *[3 if k == 200 else 0 for k in range(640)]).bytes


raw = Cdr().put("qqQ", 5, 6, 7).doubles(0, 0, 9.8, 0.1, 0.2, 0.3, 20, 0, -40, 25).put("B" * 8, 15, *[0] * 7).bytes
write("own_messages/all", own(1, calibration()) + own(2, diagnostics()) + own(0, attitude(1)) + own(0, attitude(2)) + own(3, raw))
write("own_messages/attitudes", own(0, attitude(5)) + own(0, attitude(2)) + own(0, attitude(9)) + own(1, calibration()))

ENTITIES = b"\0\1\0\xc7\0\1\0\xc2"
number = lambda n: struct.pack("<II", n >> 32, n & 0xFFFFFFFF)
submessage = lambda kind, flags, body: struct.pack("<BBH", kind, flags, len(body)) + body
parameter = lambda kind, value: struct.pack("<HH", kind, len(value)) + value
announced = parameter(0x50, b"senders guid\0\0\1\xc1") + parameter(0x62, struct.pack("<I", 4) + b"abc\0") + parameter(
    0x59, struct.pack("<I", 1) + 2 * (struct.pack("<I", 2) + b"a\0\0\0")) + parameter(0x75, b"type") + parameter(0x2C, struct.pack("<I", 4) + b"user") + parameter(1, b"")
PARTS = {
    "announcement_by_hand": submessage(9, 1, bytes(8)) + submessage(0x15, 5, struct.pack("<HH", 0, 16) + ENTITIES + number(1) + b"\0\3\0\0" + announced),
    "reliable": submessage(0x0E, 1, b"receivers id") + submessage(6, 1, ENTITIES + number(1) + struct.pack("<III", 40, 1, 2) + bytes(4)) + submessage(
        7, 1, ENTITIES + number(1) + number(9) + struct.pack("<I", 1)) + submessage(8, 1, ENTITIES + number(1) + number(5) + struct.pack("<III", 40, 1, 2)),
    "fragment": submessage(0x16, 1, struct.pack("<HH", 0, 28) + ENTITIES + number(1) + struct.pack("<IHHI", 1, 1, 100, 250) + bytes(100)) + submessage(
        0x12, 1, ENTITIES + number(1) + struct.pack("<III", 1, 32, 7) + bytes(4)) + submessage(0x13, 1, ENTITIES + number(1) + bytes(8)),
    "inline_qos": submessage(0x15, 7, struct.pack("<HH", 0, 16) + b"\0\0\1\4\0\0\1\3" + number(1) + parameter(0x70, bytes(16)) + parameter(0x71, b"\0\0\0\1") + parameter(
        1, b"") + b"\0\1\0\0data"),
    "statistics": b"\x80\x01\x38\x00" + bytes(60),
    "sources_and_replies": submessage(0x0C, 1, bytes(20)) + submessage(0x0D, 3, bytes(16)) + submessage(0x0F, 3, struct.pack("<I", 1) + bytes(24) + struct.pack("<I", 1) + bytes(24)),
    "liveliness_big_endian": struct.pack(">BBH", 0x15, 4, 48) + struct.pack(">HH", 0, 16) + b"\0\2\0\xc7\0\2\0\xc2" + struct.pack(">II", 0, 1) + b"\0\0\0\0" + b"senders guid\0\0\0\1" + struct.pack(">I", 0),
}
for name, parts in PARTS.items():
    write("rtps/" + name, b"RTPS\x02\x03\x01\x0f" + b"senders guid" + parts)
