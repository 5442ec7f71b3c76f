// Follows a session that haptic_relay publishes (audience.proto): joins, goes on with what comes, begins anew after any loss.
import {connect, createInbox} from 'nats.ws';

import {readAssetChunk, readLatestSnapshot, readLiveMessage, readPublishedCommit, readSnapshotPart} from './messages.js';
import {OutOfStep, Scene, hex, sha256} from './scene.js';

const SIGN_MS = 3000;            // without a sign of the relay for so long the session is over
const POOR_MS = 500;             // a sample that comes later than this says that the link is poor
const RETRY_MS = [500, 1500];    // between attempts, at random: an audience does not come back at once
const LONGEST_RETRY = 6;         // times that, as attempts fail one after the other
const ANSWER_MS = 5000;
const ASSET_RETRY_MS = [500, 8000];  // an asset that is not right is asked for again; twice as late each time
const MAX_WAITING = 4096;        // messages that came and are not looked at; with more a page begins anew
const READ_AHEAD = 32;           // stored messages that are asked for at once
const CHUNK = 131072;
const MAX_ASSETS = 640 << 20;    // of one scene: kMaxHeldAssets_bytes
const MAX_HEARTBEATS_AHEAD = 3;

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** A chunk of this asset, with the place and the length that its index gives it. */
function readChunk(bytes, name, index) {
  const chunk = readAssetChunk(bytes), begin = index * CHUNK, total = Number(chunk.total_size);
  if (hex(chunk.hash) !== name || Number(chunk.offset) !== begin || total <= begin ||
      chunk.data.length !== Math.min(CHUNK, total - begin)) {
    throw new Error('a chunk is not what its subject says');
  }
  return chunk;
}

export class WatchedSession {
  /**
   * @param show  Called for each change: scene(scene, welcome), asset(hash in hexadecimal, bytes), drop(hash of an asset that
   *              no object names any more), telemetry(message), state(word, sentence) with a word of connecting, live, poor, lost, over.
   */
  constructor({nats, session, user, pass}, show) {
    Object.assign(this, {nats, session, user, pass, show});
    this.saw = {roots: 0, samples: 0, joins: 0, resyncs: 0};
    this.assets = new Map();  // by the hash of what is held or asked for: {bytes}, 0 until that is known
    this.failures = 0;        // attempts one after the other that led to no scene
    this.word = null;
  }

  /** For ever. */
  async run() {
    for (;;) {
      try {
        await this.watch();
      } catch (error) {
        if (error instanceof OutOfStep) this.saw.resyncs++;
        this.tell(error.isOver ? 'over' : this.saw.joins > 0 ? 'lost' : 'connecting', error.message);
      }
      await this.connection?.close().catch(() => {});
      const times = Math.min(LONGEST_RETRY, 1 + this.failures++);
      await pause(times * (RETRY_MS[0] + (RETRY_MS[1] - RETRY_MS[0]) * Math.random()));
    }
  }

  tell(word, sentence) {
    if (word === this.word && sentence === this.sentence) return;
    [this.word, this.sentence] = [word, sentence];
    this.show.state(word, sentence);
  }

  async watch() {
    if (!this.word) this.tell('connecting', `connecting to ${this.nats}`);
    this.connection = await connect({servers: this.nats, ignoreClusterUpdates: true, reconnect: false, timeout: 5000, user: this.user,
      pass: this.pass}).catch(() => { throw new Error(`no NATS server answers at ${this.nats}`); });
    this.early = [];  // what comes while the stored part is read
    this.scene = null;
    this.aheads = 0;
    this.lastSample = 0;
    this.ended = null;
    this.lastSign = performance.now();
    const signed = new Promise((done) => { this.signed = done; });
    this.inbox = createInbox();
    this.asked = 0;
    this.answers = new Map();  // who waits for one, by its number
    this.connection.subscribe(`${this.inbox}.>`, {callback: (error, message) => this.takeAnswer(error, message)});
    // A server permits one of them (deploy/nats.conf).
    const live = `haptics.${this.session}.live.*`, taking = [live, `_R_.${live}`].map((subject) =>
      this.takeAll(this.connection.subscribe(subject)).catch((error) => {
        if (error.code !== 'PERMISSIONS_VIOLATION') throw error;
        return new Promise(() => {});
      }));
    const closed = this.connection.closed().then(() => { throw new Error('the connection to the NATS server is lost'); });
    const looking = this.lookAfter();
    const joining = signed.then(() => this.join()).then(() => new Promise(() => {}));
    const all = [...taking, closed, looking, joining];
    for (const one of all) one.catch(() => {});  // of two that fail the second is of no more interest
    await Promise.race(all);
  }

  /** Ends, with an exception, once nothing comes any more. */
  async lookAfter() {
    const {connection} = this;
    while (connection === this.connection) {
      await pause(100);
      const silent_ms = performance.now() - this.lastSign;
      if (silent_ms > SIGN_MS) {
        throw Object.assign(new Error(`session ${this.session} is not published now`), {isOver: true});
      }
      if (!this.scene) continue;
      if (performance.now() - this.lastSample > POOR_MS) this.tell('poor', 'the link is poor: what is shown is late');
      else this.tell('live', `watching ${this.session}`);
    }
  }

  async takeAll(subscription) {
    for await (const message of subscription) {
      const isCommit = message.subject.endsWith('.commit');
      let read;
      try {
        read = (isCommit ? readPublishedCommit : readLiveMessage)(message.data);
      } catch {
        continue;  // nobody's but a forger's
      }
      if (subscription.getPending() + (this.early?.length || 0) > MAX_WAITING) throw new OutOfStep('too many messages');
      if (!isCommit) {
        this.lastSign = performance.now();
        this.signed();
      }
      if (this.early && read.telemetry) continue;
      if (this.early) this.early.push(read);
      else await this.take(read);
    }
  }

  async join() {
    const stream = `$JS.API.DIRECT.GET.haptics-${this.session}`;
    const last = await this.stored(`${stream}.haptics.${this.session}.latest`);
    if (!last) throw new Error(`session ${this.session} has no snapshot yet`);
    const latest = readLatestSnapshot(last.data);
    this.welcome = latest.welcome;
    const epoch = String(latest.welcome.epoch);
    let scene = null, begun = null;
    for await (const message of this.storedFrom(stream, Number(latest.sequence))) {
      const subject = message.headers.get('Nats-Subject');
      if (subject.endsWith('.snapshot')) {
        const part = readSnapshotPart(message.data);
        if (part.begin) begun = {epoch: String(part.epoch), ...part.begin, objects: []};
        if (part.objects) begun?.objects.push(...part.objects.object);
        if (part.end && begun) {
          if (begun.objects.length !== Number(begun.object_count)) throw new OutOfStep('a snapshot is not whole');
          scene = await Scene.of(begun.epoch, Number(part.end.revision), begun.objects, part.end.root);
          this.saw.roots++;
        }
      } else if (subject.endsWith('.commit')) {
        const published = readPublishedCommit(message.data);
        if (!scene || String(published.epoch) !== scene.epoch) throw new OutOfStep('commits without their snapshot');
        if (Number(published.commit.revision) <= scene.revision) continue;
        scene = await scene.after(published.commit);
        this.saw.roots++;
      }
    }
    if (!scene || scene.epoch !== epoch) throw new OutOfStep('the session has changed while it was read');
    this.saw.joins++;
    this.failures = 0;
    this.adopt(scene);
    // Commits go on being taken one after the other, also while these are.
    while (this.early.length > 0) await this.take(this.early.shift());
    this.early = null;
  }

  async take(message) {
    const epoch = String(message.epoch);
    if (message.telemetry) {
      if (epoch === this.scene.epoch) this.takeSample(message.telemetry);
      return;
    }
    if (epoch !== this.scene.epoch) throw new OutOfStep('the server was started anew');
    if (message.heartbeat) return this.takeHeartbeat(message.heartbeat);
    if (!message.commit || Number(message.commit.revision) <= this.scene.revision) return;
    const next = await this.scene.after(message.commit);
    this.saw.roots++;
    this.aheads = 0;
    this.adopt(next);
  }

  takeHeartbeat({revision, root}) {
    if (Number(revision) > this.scene.revision && ++this.aheads > MAX_HEARTBEATS_AHEAD) throw new OutOfStep('commits were missed');
    if (Number(revision) === this.scene.revision && hex(root) !== hex(this.scene.root)) throw new OutOfStep('another root');
  }

  takeSample(sample) {
    this.lastSample = performance.now();
    this.saw.samples++;
    this.show.telemetry(sample);
  }

  adopt(scene) {
    this.scene = scene;
    this.show.scene(scene, this.welcome);
    const named = new Set(), surfaces = new Set();
    for (const {state, surface} of scene.objects.values()) {
      for (const hash of [state.mesh, state.deformation?.residue?.asset]) if (hash?.length) named.add(hex(hash));
      if (surface) surfaces.add(surface);
    }
    this.wanted = new Set([...named, ...surfaces]);
    for (const name of this.assets.keys()) {
      if (!this.wanted.has(name)) this.drop(name);
    }
    for (const name of this.wanted) {
      if (!this.assets.has(name)) this.get(name, named.has(name));
    }
  }

  drop(name) {
    this.assets.delete(name);
    this.show.drop(name);
  }

  /** Shows an asset once it is here, and right; as long as it is wanted. */
  async get(name, isHash) {
    const mine = {bytes: 0};
    this.assets.set(name, mine);
    const isWanted = () => this.assets.get(name) === mine;
    for (let wait = ASSET_RETRY_MS[0]; isWanted(); wait = Math.min(ASSET_RETRY_MS[1], 2 * wait)) {
      try {
        const bytes = await this.fetch(name, isHash, isWanted, mine);
        if (isWanted()) this.show.asset(name, bytes);
        return;
      } catch {
        await pause(wait);
      }
    }
  }

  /** All bytes of an asset, checked against its name where that is their hash; asked for as long as it is wanted and not stored. */
  async fetch(name, isHash, isWanted, mine) {
    const subject = `haptics.${this.session}.asset.${name}`;
    const chunk = async (index) => {
      while (isWanted()) {
        const message = await this.stored(`$JS.API.DIRECT.GET.haptics-${this.session}-assets.${subject}.${index}`);
        if (message) return readChunk(message.data, name, index);
        await pause(500);
      }
      throw new Error('not wanted any more');
    };
    const first = await chunk(0), total = Number(first.total_size);
    mine.bytes = total;
    const held = [...this.assets.values()].reduce((sum, {bytes}) => sum + bytes, 0);
    if (held > MAX_ASSETS) {
      mine.bytes = 0;
      throw new Error('too large');
    }
    const bytes = new Uint8Array(total);
    const put = ({offset, data, total_size}) => {
      if (Number(total_size) !== total) throw new Error('a chunk of another asset');
      bytes.set(data, Number(offset));
    };
    put(first);
    const count = Math.ceil(total / CHUNK);
    for (let index = 1; index < count; index += READ_AHEAD) {
      const wanted = Array.from({length: Math.min(READ_AHEAD, count - index)}, (_, i) => chunk(index + i));
      (await Promise.all(wanted)).forEach(put);
    }
    if (isHash && hex(await sha256(bytes)) !== name) throw new Error(`asset ${name} has another hash`);
    return bytes;
  }

  /** A message that JetStream keeps, or null. */
  async stored(subject, query) {
    const number = String(++this.asked), {answers} = this;
    const answer = new Promise((take, refuse) => {
      const late = setTimeout(() => refuse(new Error('JetStream does not answer')), ANSWER_MS);
      answers.set(number, (message) => {
        clearTimeout(late);
        take(message);
      });
    });
    // r: others may not hear it (deploy/nats.conf).
    this.connection.publish(subject, query ? JSON.stringify(query) : '', {reply: `${this.inbox}.${number}.r`});
    const message = await answer.finally(() => answers.delete(number));
    return message.headers?.code === 0 ? message : null;
  }

  takeAnswer(error, message) {
    if (error) return;
    const number = message.subject.slice(this.inbox.length + 1).split('.')[0];
    this.answers.get(number)?.(message);
  }

  async* storedFrom(stream, sequence) {
    for (;; sequence += READ_AHEAD) {
      const asked = Array.from({length: READ_AHEAD}, (_, i) => this.stored(stream, {seq: sequence + i}));
      for (const message of await Promise.all(asked)) {
        if (!message) return;
        yield message;
      }
    }
  }
}
