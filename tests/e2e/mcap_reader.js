// Reads a session that hapticctl exported as MCAP with libraries of others: how many messages each topic has, and of each
// tick its number and the force's bits.
//
//   node mcap_reader.js SESSION.mcap > ticks.json
"use strict";
const fs = require("fs");
const protobuf = require("protobufjs");
const descriptor = require("protobufjs/ext/descriptor");
const { McapIndexedReader } = require("@mcap/core");

function bits(number) {
  const bytes = Buffer.alloc(8);
  bytes.writeDoubleLE(number);
  return bytes.toString("hex");
}

async function main() {
  const file = fs.openSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(fs.fstatSync(file).size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      fs.readSync(file, bytes, 0, bytes.length, Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  const types = new Map();
  const topics = {};
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    const root = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data));
    types.set(channel.topic, root.lookupType(schema.name));
    topics[channel.topic] = Number(reader.statistics.channelMessageCounts.get(channel.id) ?? 0n);
  }
  const ticks = [];
  for await (const message of reader.readMessages({ topics: ["/telemetry"] })) {
    const sample = types.get("/telemetry").decode(message.data);
    const force = sample.force.written;
    ticks.push([Number(sample.tick), bits(force.x) + bits(force.y) + bits(force.z)]);
  }
  for (const topic of Object.keys(topics)) {  // the others can be decoded
    for await (const message of reader.readMessages({ topics: [topic] })) types.get(topic).decode(message.data);
  }
  console.log(JSON.stringify({ topics, ticks }));
}

main();
