// The page's readers on damaged messages and assets: page_fuzz bundles and runs it. Arguments: seconds, first seed. Whatever comes
// is refused by an exception, or leads to a shape of finite numbers, in bounded time.
import protobuf from 'protobufjs';

import audience from '../../proto/haptics/v1/audience.proto';
import envelope from '../../proto/haptics/v1/envelope.proto';
import scene from '../../proto/haptics/v1/scene.proto';
import telemetry from '../../proto/haptics/v1/telemetry.proto';
import {badNumber, bodiesOf, dentsOf} from '../../graphics_client/web/limits.js';
import {readAssetChunk, readLatestSnapshot, readLiveMessage, readPublishedCommit, readSnapshotPart} from '../../graphics_client/web/messages.js';
import {Scene} from '../../graphics_client/web/scene.js';
import {decodeAsset, dent, normalsOf, restShape} from '../../graphics_client/web/shapes.js';

const MOST_MS = 2000;
const root = new protobuf.Root();
for (const text of [scene, telemetry, envelope, audience]) protobuf.parse(text, root, {keepCase: true});
const bytesOf = (name, value) => {
  const type = root.lookupType(`haptics.v1.${name}`);
  return type.encode(type.fromObject(value)).finish();
};

const vector = (x, y, z) => ({x, y, z});
const hash = new Uint8Array(32).fill(7);
const object = {id: 3, name: 'one', revision: 1, mesh: hash, pose: {position: vector(1, 2, 3), rotation: {w: 1}},
  stiffness_N_per_m: 100, color: {red: 0.5}, texture: {field: {noise: {wavelength_m: 1, octaves: 2}}}, shading: {crease_rad: 1},
  deformation: {softness: {stiffness_N_per_m: 1, radius_m: 0.1, degree: 3}, residue: {asset: hash},
    lattice: {low_m: vector(0, 0, 0), size_m: vector(1, 1, 1), points_x: 2, points_y: 3, points_z: 2, control_m: new Array(36).fill(0.5)}}};
const base = {protocol_version: 1, epoch: 5};
const sample = {tick: 4, body: [{object: 3, pose: object.pose}], dent: [{object: 3, centre: [0, 0, 0], displacement: [1, 0, 0]}]};

function listed(magic, counts, ...arrays) {
  const parts = [new TextEncoder().encode(magic), new Uint8Array(Uint32Array.of(1).buffer), new Uint8Array(BigUint64Array.from(counts, BigInt).buffer),
    ...arrays.map((array) => new Uint8Array(array.buffer))];
  return Uint8Array.from(parts.flatMap((part) => [...part]));
}
const corners = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1), faces = Uint32Array.of(0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3);
const assets = [listed('HMSH', [4, 4], corners, faces), listed('HMOV', [1], Uint32Array.of(2), Float32Array.of(1, 2, 3)),
  listed('HSRF', [4, 4], corners, faces, Uint8Array.of(1, 2, 3, 4))];
const messages = [
  [readSnapshotPart, bytesOf('SnapshotPart', {...base, objects: {object: [object, {...object, id: 4}]}})],
  [readPublishedCommit, bytesOf('PublishedCommit', {...base, commit: {revision: 2, prev_root: hash, root: hash, put: [object], removed: [1]}})],
  [readLiveMessage, bytesOf('LiveMessage', {...base, telemetry: sample})],
  [readLatestSnapshot, bytesOf('LatestSnapshot', {protocol_version: 1, sequence: 1, welcome: {epoch: 5, root: hash}})],
  [readAssetChunk, bytesOf('AssetChunk', {hash, kind: 1, total_size: 9, data: hash})]];

/** Numbers of 0 to 1 (mulberry32). */
function random(seed) {
  return () => {
    seed = seed + 0x6d2b79f5 | 0;
    let t = Math.imul(seed ^ seed >>> 15, 1 | seed);
    t = t + Math.imul(t ^ t >>> 7, 61 | t) ^ t;
    return ((t ^ t >>> 14) >>> 0) / 2 ** 32;
  };
}

const WORDS = [0, 1, 127, 128, 255];
function damaged(bytes, next) {
  let out = Uint8Array.from(bytes);
  for (let changes = Math.floor(5 * next()); changes >= 0; changes--) {
    const at = Math.floor(next() * out.length), kind = Math.floor(6 * next());
    if (kind === 0) out[at] ^= 1 << Math.floor(8 * next());
    if (kind === 1) out[at] = WORDS[Math.floor(WORDS.length * next())];
    if (kind === 2) out = out.slice(0, at);
    if (kind === 3) out = Uint8Array.from([...out.slice(0, at), ...out.slice(Math.floor(next() * out.length))]);
    if (kind === 4 && at + 8 <= out.length) new DataView(out.buffer).setFloat64(at, [NaN, Infinity, 1e300, 4e9][Math.floor(4 * next())], true);
    if (kind === 5 && at + 4 <= out.length) new DataView(out.buffer).setFloat32(at, [NaN, Infinity, 1e30][Math.floor(3 * next())], true);
    if (out.length === 0) break;
  }
  return out;
}

function require(holds, what) {
  if (!holds) throw Object.assign(new Error(what), {isFinding: true});
}

function shape(state, mesh, moved, dents) {
  if (badNumber(state) || !mesh.triangles) return false;
  const points = mesh.heights ? mesh.vertices.slice() : restShape(mesh, state.deformation, moved?.vertex ? moved : null);
  if (state.deformation?.softness) dent(points, dents, state.deformation.softness);
  const isFar = mesh.vertices.some((x) => Math.abs(x) > 1000);  // a lattice is a polynomial: far from it there is no bound
  require(isFar || points.every(Number.isFinite), 'a point is nowhere');
  require(normalsOf(points, mesh.triangles).length === points.length, 'normals');
  return true;
}

const attempt = async (work) => {
  try {
    return await work();
  } catch (error) {
    if (error.isFinding) throw error;
    return null;
  }
};

async function once(seed) {
  const next = random(seed), maybe = (bytes) => (next() < 0.5 ? damaged(bytes, next) : bytes);
  const [read, bytes] = messages[Math.floor(messages.length * next())];
  const message = await attempt(() => read(damaged(bytes, next)));
  const [mesh, moved, surface] = await Promise.all(assets.map((asset) => attempt(() => decodeAsset(maybe(asset)))));
  const dents = message?.telemetry ? dentsOf(message.telemetry) : [{centre: [0, 0, 0], displacement: [0.1, 0, 0]}];
  if (message?.telemetry) bodiesOf(message.telemetry);
  const states = message?.objects?.object || message?.commit?.put || [root.lookupType('haptics.v1.ObjectState').fromObject(object)];
  let drawn = 0;
  for (const state of states) for (const of of [mesh, surface]) if (of) drawn += await attempt(() => shape(state, of, moved, dents)) ? 1 : 0;
  await attempt(() => Scene.of('5', 1, states, hash));
  return drawn;
}

const [seconds, first] = process.argv.slice(2).map(Number), end = performance.now() + 1000 * seconds;
let seed = first, drawn = 0;
for (; performance.now() < end; seed++) {
  const begin = performance.now();
  try {
    drawn += await once(seed);
    require(performance.now() - begin < MOST_MS, 'takes too long');
  } catch (error) {
    console.log(`seed ${seed}: ${error.stack}`);
    process.exit(1);
  }
}
console.log(`${seed - first} cases, ${drawn} shapes drawn`);
if (drawn === 0) process.exit(1);
