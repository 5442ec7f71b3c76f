// A client written from proto/README.md and the .proto files alone. It joins, fetches assets, edits, is cut again and again,
// resumes, and computes the root of every revision itself. A breach of the protocol ends it; else it prints what it saw.
//
//   node stranger.js HOST:PORT [CREDENTIALS]
'use strict';
const [crypto, dgram, fs, net, path, tls, protobuf] =
  ['crypto', 'dgram', 'fs', 'net', 'path', 'tls', 'protobufjs'].map((name) => require(name));
const {big, objectBytes, rootBytes} = require('../../graphics_client/web/scene_hash.js');

const MAX_FRAME = 1 << 20, CHUNK = 32768, SILENCE_MS = 3000, HEARTBEAT_MS = 1000, KNOCK_MS = 250;
const messages = new protobuf.Root();
// Options say nothing that is on the wire, and import a file that protobufjs does not have.
messages.resolvePath = (_, file) => file.endsWith('/options.proto') ? null : path.join(__dirname, '../../proto', file);
messages.loadSync('haptics/v1/envelope.proto', {keepCase: true});
const [Envelope, Datagram] = ['Envelope', 'Datagram'].map((name) => messages.lookupType(`haptics.v1.${name}`));

const check = (holds, what) => { if (!holds) throw new Error(what); };
const sha256 = (bytes) => crypto.createHash('sha256').update(bytes).digest();
const hex = (bytes) => Buffer.from(bytes).toString('hex');
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

function rootOf({revision, objects}) {
  return sha256(rootBytes(revision, [...objects.values()].map((o) => [o, sha256(objectBytes(o))])));
}

// ---- The client ----
class Client {
  constructor(address, credentials) {
    const colon = address.lastIndexOf(':');
    [this.host, this.port] = [address.slice(0, colon).replace(/[[\]]/g, ''), Number(address.slice(colon + 1))];
    this.credentials = credentials && fs.readFileSync(credentials, 'ascii');
    this.session = protobuf.util.Long.fromBytesLE([...crypto.randomBytes(7), 1], true);
    this.scene = null;  // {epoch, revision, root, objects by id}
    this.assets = new Map();  // by hash: what has come so far
    this.edits = [];  // not answered, oldest first
    this.accepted = new Map();  // revision by client_seq
    this.lastSeq = this.live = 0;  // live: revision that the servo feels
    this.saw = {roots: 0, snapshots: 0, resumed: 0, commits: 0, resent: 0, continued: 0, samples: 0, datagrams: 0};
  }

  connect() {
    this.input = Buffer.alloc(0);
    this.welcome = this.losesReplies = this.cut = null;
    this.sent = this.tick = 0;
    this.heard = Date.now();
    const at = {host: this.host, port: this.port};
    this.socket = this.credentials ?
      tls.connect({...at, ca: this.credentials, servername: 'haptic_server', minVersion: 'TLSv1.3'}) : net.connect(at);
    this.socket.setNoDelay(true);
    this.socket.on('data', (data) => this.cut || this.receive(data));
    this.socket.on('close', () => clearInterval(this.heartbeat) || check(this.cut, 'the server closed the connection'));
    const token = this.credentials && Buffer.from(/^token: ([0-9a-f]{64})$/m.exec(this.credentials)[1], 'hex');
    const {epoch, revision, root} = this.scene || {};
    this.send({hello: {session: this.session, client_name: 'stranger', token, epoch, revision, root}});
    return this.until(() => this.welcome && this.scene && big(this.scene.revision) >= big(this.welcome.revision));
  }

  async reconnect() {
    this.destroy();
    await pause(50 + 550 * Math.random());
    await this.connect();
  }

  destroy() {
    this.cut = true;
    this.socket.destroy();
  }

  async until(condition) {
    const deadline = Date.now() + 60000;
    for (; !condition(); await pause(2)) check(Date.now() < deadline, `waits in vain: ${condition}`);
  }

  frame(body) {
    const bytes = Envelope.encode(Envelope.fromObject({protocol_version: 1, message_id: ++this.sent, ...body})).finish();
    return Buffer.concat([Buffer.from(Uint32Array.of(bytes.length).buffer), bytes]);
  }
  send(body) { this.socket.write(this.frame(body)); }
  receive(data) {
    this.heard = Date.now();
    this.input = Buffer.concat([this.input, data]);
    while (this.input.length >= 4 && !this.cut) {
      const length = this.input.readUInt32LE();
      check(length > 0 && length <= MAX_FRAME, `a frame of ${length} bytes`);
      if (this.input.length < 4 + length) return;
      const envelope = Envelope.decode(this.input.subarray(4, 4 + length));
      this.input = this.input.subarray(4 + length);
      check(envelope.protocol_version === 1, `version ${envelope.protocol_version}`);
      const take = this[`take_${envelope.body}`];
      if (take) take.call(this, envelope[envelope.body]);
    }
  }

  verify(said) {
    this.scene.root = rootOf(this.scene);
    check(hex(this.scene.root) === hex(said), `own root of revision ${this.scene.revision} is not the server's`);
    this.saw.roots++;
  }

  // What the server says, by the names of its messages.
  take_refusal(refusal) { throw new Error(`refused: ${refusal.field} ${refusal.reason}`); }
  take_welcome(welcome) {
    this.welcome = welcome;
    this.saw.resumed += welcome.resumed;
    this.heartbeat = setInterval(() => {
      check(Date.now() - this.heard < SILENCE_MS, 'the server is silent');
      const {epoch, revision, root} = this.scene || {};
      this.send({heartbeat: {epoch, revision, root}});
    }, HEARTBEAT_MS);
    for (const edit of this.edits) this.send({edit_request: edit});
    this.saw.resent += this.edits.length;
  }
  take_snapshot_begin(begin) { this.snapshot = {begin, objects: []}; }
  take_snapshot_objects(objects) { this.snapshot.objects.push(...objects.object); }
  take_snapshot_end({revision, root}) {
    const {begin, objects} = this.snapshot;
    check(begin.object_count.equals(objects.length) && begin.revision.equals(revision), 'the snapshot is not whole');
    this.scene = {epoch: this.welcome.epoch, revision, objects: new Map(objects.map((o) => [String(o.id), o]))};
    this.verify(root);
    this.saw.snapshots++;
  }
  take_commit({revision, prev_root, put, removed, root}) {
    check(revision.equals(this.scene.revision.add(1)) && hex(prev_root) === hex(this.scene.root), 'a gap between commits');
    this.scene.revision = revision;
    for (const id of removed) this.scene.objects.delete(String(id));
    for (const o of put) this.scene.objects.set(String(o.id), o);
    this.verify(root);
    this.saw.commits++;
  }
  take_heartbeat({revision, root, adopted_revision}) {
    check(revision.equals(this.scene.revision) && hex(root) === hex(this.scene.root), 'out of step');
    this.live = Math.max(this.live, Number(adopted_revision));
  }
  take_edit_reply(reply) {
    if (this.losesReplies) return;
    const seq = Number(reply.client_seq);
    check(reply.accepted && !this.accepted.has(seq), `edit ${seq}: ${JSON.stringify(reply)}`);
    this.accepted.set(seq, Number(reply.accepted.revision));
    this.edits = this.edits.filter((edit) => edit.client_seq !== seq);
  }
  take_telemetry({tick}) {
    if (this.saw.datagrams && big(tick) <= this.tick) return;  // a datagram has overtaken the stream
    check(big(tick) > this.tick, 'telemetry goes back');
    this.tick = big(tick);
    this.saw.samples++;
  }
  take_asset_chunk(chunk) {
    const asset = this.assets.get(hex(chunk.hash));
    if (Number(chunk.offset) !== asset.bytes.length) return;
    check(chunk.data.length <= CHUNK, `a chunk of ${chunk.data.length} bytes`);
    asset.bytes = Buffer.concat([asset.bytes, chunk.data]);
    asset.isWhole = asset.bytes.length === Number(chunk.total_size);
    check(!asset.isWhole || hex(sha256(asset.bytes)) === hex(chunk.hash), 'an asset with another hash');
    if (!asset.isWhole && asset.bytes.length === CHUNK) this.destroy();  // to go on behind the cut
  }

  edit(operations, preconditions = []) {
    this.edits.push({client_seq: ++this.lastSeq, epoch: this.scene.epoch, transaction: {preconditions, operations}});
    this.send({edit_request: this.edits[this.edits.length - 1]});
  }

  async fetch(hash) {
    const asset = {bytes: Buffer.alloc(0), isWhole: false};
    this.assets.set(hex(hash), asset);
    this.send({asset_request: {hash}});
    await this.until(() => asset.isWhole || this.cut);
    if (this.cut) {
      this.saw.continued++;
      await this.reconnect();
      this.send({asset_request: {hash, offset: asset.bytes.length}});
    }
    await this.until(() => asset.isWhole);
  }

  async hearDatagrams(count) {
    const {datagram_port: port, datagram_cookie: cookie} = this.welcome;
    const socket = dgram.createSocket(net.isIPv6(this.host) ? 'udp6' : 'udp4');
    let isOpen = false;
    socket.on('message', (bytes) => {
      const datagram = Datagram.decode(bytes);
      isOpen = isOpen || hex(datagram.cookie) === hex(cookie);
      if (!isOpen || !datagram.telemetry || big(datagram.telemetry.tick) <= this.tick) return;
      this.take_telemetry(datagram.telemetry);
      this.saw.datagrams++;
    });
    const knocking = setInterval(() => socket.send(Datagram.encode({cookie}).finish(), port, this.host), KNOCK_MS);
    await this.until(() => isOpen);
    this.send({subscribe: {rate_hz: 100, datagrams: true}});
    await this.until(() => this.saw.datagrams >= count);
    clearInterval(knocking);
    socket.close();
  }
}

// ---- What this one does ----
const addBox = (name) => ({add: {name, mesh: {box: {size_m: {x: 0.01, y: 0.01, z: 0.01}}}, pose: {position: {z: 0.3}}}});

/** Four edits, a cut at a place that depends on the round, and on. */
async function editThroughACut(client, round) {
  const commits = client.saw.commits;
  client.losesReplies = true;
  for (let i = 0; i < 4; ++i) client.edit([addBox(`round_${round}_${i}`)]);
  const places = [
    () => {},  // at once
    () => client.until(() => client.saw.commits > commits),  // the server has decided, and its reply is lost
    () => client.socket.write(client.frame({heartbeat: {}}).subarray(0, 5)),  // in the middle of a frame
  ];
  await places[round % places.length]();
  await client.reconnect();
  await client.until(() => client.edits.length === 0);
}

async function main([address, credentials]) {
  const client = new Client(address, credentials);
  await client.connect();
  const objects = [...client.scene.objects.values()], first = Number(client.scene.revision);
  for (const o of objects) await client.fetch(o.mesh);

  const [one] = objects, ref = {id: one.id};
  const material = {stiffness_N_per_m: 700, friction: {mu_static: 0.5, mu_dynamic: 0.4}};
  client.edit([{set_material: {object: ref, material}}],
    [{object: ref, expected_revision: one.revision, expected_hash: sha256(objectBytes(one))}]);
  await client.until(() => client.live === first + 1 && client.edits.length === 0);

  for (let round = 0; round < 10; ++round) await editThroughACut(client, round);
  const revisions = [...client.accepted.keys()].sort((a, b) => a - b).map((seq) => client.accepted.get(seq));
  check(revisions.every((revision, i) => revision === first + 1 + i), `edits became the revisions ${revisions}`);
  check(Number(client.scene.revision) === first + client.lastSeq, 'an edit was lost or doubled');
  check(client.scene.objects.size === objects.length + 40, 'an object was lost or doubled');
  client.send({subscribe: {rate_hz: 100}});
  await client.until(() => client.saw.samples >= 10);
  if (client.welcome.datagram_port) await client.hearDatagrams(10);
  client.destroy();
  console.log(JSON.stringify({...client.saw, edits: client.lastSeq, revision: Number(client.scene.revision),
    root: hex(client.scene.root)}));
}

main(process.argv.slice(2)).catch((error) => {
  console.error(error.message);
  process.exit(1);
});
