// node read_mcap.mjs FILE indexed|streamed: counts the messages, decodes each, and checks what is in them.
import { readFile } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";

const [file, way] = process.argv.slice(2);
const bytes = await readFile(file);
const decoders = new Map(), topics = new Map(), counts = {};
const take = (channel, schema, message) => {
  if (!decoders.has(channel.id)) {
    const text = new TextDecoder().decode(schema.data);
    decoders.set(channel.id, new MessageReader(parse(text, { ros2: true })));
  }
  const m = decoders.get(channel.id).readMessage(message.data);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  const stamp = BigInt(m.header.stamp.sec) * 1000000000n + BigInt(m.header.stamp.nanosec ?? m.header.stamp.nsec);
  if (stamp !== message.logTime) throw new Error(`stamp ${stamp} is not the log time ${message.logTime}`);
  if (channel.topic === "/imu/data_raw" && m.linear_acceleration_covariance[0] !== -1) {
    const { x, y, z } = m.linear_acceleration;
    const norm = Math.hypot(x, y, z);
    if (!(norm > 0.5 && norm < 50)) throw new Error(`an acceleration of ${norm}`);
  }
};
if (way === "indexed") {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(size)),
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  if (reader.header.profile !== "ros2") throw new Error("no ros2 profile");
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    take(channel, reader.schemasById.get(channel.schemaId), message);
  }
  const said = reader.statistics.messageCount, seen = BigInt(Object.values(counts).reduce((a, b) => a + b));
  if (said !== seen) throw new Error(`the statistics say ${said} messages, there are ${seen}`);
} else {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  const schemas = new Map();
  for (let r; (r = reader.nextRecord()); ) {
    if (r.type === "Schema") schemas.set(r.id, r);
    if (r.type === "Channel") topics.set(r.id, r);
    if (r.type === "Message") take(topics.get(r.channelId), schemas.get(topics.get(r.channelId).schemaId), r);
  }
}
if (!(counts["/imu/data_raw"] > 500)) throw new Error(`only ${counts["/imu/data_raw"]} Imu messages`);
console.log(`${file}, ${way}:`, JSON.stringify(counts));
