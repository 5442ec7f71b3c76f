// The protocol's messages, from the .proto files that the programs are built of.
import Long from 'long';
import protobuf from 'protobufjs';

import scene from '../../proto/haptics/v1/scene.proto';
import telemetry from '../../proto/haptics/v1/telemetry.proto';
import envelope from '../../proto/haptics/v1/envelope.proto';
import audience from '../../proto/haptics/v1/audience.proto';

protobuf.util.Long = Long;  // 64 bits: epochs need all of them
protobuf.configure();

const root = new protobuf.Root();
for (const text of [scene, telemetry, envelope, audience]) protobuf.parse(text, root, {keepCase: true});
root.resolveAll();

const MAX_BYTES = 1 << 20, VERSION = 1;

/** A reader of untrusted bytes: the message, or an exception that says what is wrong with it. */
function reader(name, ...needed) {
  const type = root.lookupType(`haptics.v1.${name}`);
  return (bytes) => {
    if (bytes.length > MAX_BYTES) throw new Error(`${name} has ${bytes.length} bytes`);
    const message = type.decode(bytes);
    if (type.fields.protocol_version && message.protocol_version !== VERSION) {
      throw new Error(`${name} is of protocol version ${message.protocol_version}; this page reads version ${VERSION}`);
    }
    for (const field of needed) if (message[field] === null) throw new Error(`${name} has no ${field}`);
    return message;
  };
}

export const readLatestSnapshot = reader('LatestSnapshot', 'welcome');
export const readSnapshotPart = reader('SnapshotPart');
export const readPublishedCommit = reader('PublishedCommit', 'commit');
export const readLiveMessage = reader('LiveMessage');
export const readAssetChunk = reader('AssetChunk');
