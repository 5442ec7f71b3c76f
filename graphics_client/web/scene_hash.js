// The bytes that hashes are computed over (proto/README.md, Hashes), for node and for browsers: each part is a function from a
// message, as protobufjs decodes it, to bytes. Typed arrays are little-endian on every machine that runs a browser.
'use strict';

const encoder = new TextEncoder();
const big = (integer) => BigInt(integer.toString());  // 64 bits come as Long
const bytesIn = (array) => new Uint8Array(array.buffer);
const EMPTY = new Uint8Array(0);

function concat(parts) {
  const bytes = new Uint8Array(parts.reduce((size, part) => size + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

const whole = (value) => bytesIn(BigUint64Array.of(big(typeof value === 'boolean' ? +value : value)));
const double = (value) => bytesIn(Float64Array.of(value || 0));  // absent and -0 as +0
const float = (value) => bytesIn(Float32Array.of(value || 0));
const text = (value) => {
  const bytes = encoder.encode(value);
  return concat([whole(bytes.length), bytes]);
};
const all = (...parts) => (message) => concat(parts.map((part) => part(message || {})));
const each = (bytesOf) => (...names) => (message) => concat(names.map((name) => bytesOf(message[name])));
const [wholes, doubles, floats, texts, raw] = [whole, double, float, text, (bytes) => bytes].map(each);
const vectors = each(all(doubles('x', 'y', 'z')));
const quaternions = each(all(doubles('w', 'x', 'y', 'z')));
const within = (name, ...parts) => (message) => all(...parts)(message[name]);
const when = (holds, tag, ...parts) => (message) => holds(message) ? concat([whole(tag), all(...parts)(message)]) : EMPTY;
const tagged = (name, tag, ...parts) => when((message) => message[name], tag, within(name, ...parts));
const list = (name, ...parts) => (message) =>
  concat([whole(message[name].length), ...message[name].map(all(...parts))]);
/** The first of the alternatives [name, tag, ...parts] that is there; else a tag of 0. */
const oneOf = (...alternatives) => (message) => {
  const chosen = alternatives.find(([name]) => message[name]);
  return chosen ? tagged(...chosen)(message) : whole(0);
};

const field = (message) => family(message);
const family = oneOf(
  ['fourier', 0, list('terms', doubles('amplitude'), vectors('direction'), doubles('wavelength_m', 'phase_rad'))],
  ['noise', 1, doubles('wavelength_m'), wholes('octaves'), doubles('persistence'), wholes('seed')],
  ['cellular', 2, doubles('cell_m', 'smoothness'), wholes('seed')],
  ['grain', 3, doubles('grain_m'), wholes('seed')],
  ['mapped', 4, raw('asset'), within('mapping', wholes('shape'), vectors('centre'), quaternions('rotation'),
    vectors('size_m'), doubles('tile_m'))],
  ['layers', 5, wholes('combination'), list('layer', doubles('weight'), within('field', field))],
  ['grown', 6, raw('asset')]);
const map = (prefix = '') => oneOf([`${prefix}field`, 1, field], [`${prefix}per_vertex`, 2, raw('asset')]);
const dynamicFriction = when((friction) => friction.dynamic_over, 9, doubles('dynamic_variation'), map('dynamic_'));
const joint = [vectors('anchor_m', 'axis'), doubles('lowest', 'highest')];
const motion = all(
  doubles('mass_kg'), oneOf(['inertia', 1, vectors('centre_m', 'moments', 'products')]), vectors('gravity_m_per_s2'),
  doubles('linear_damping_per_s', 'angular_damping_per_s'),
  within('spring', doubles('stiffness_N_per_m', 'damping_Ns_per_m', 'stiffness_Nm_per_rad', 'damping_Nms_per_rad')),
  oneOf(['hinge', 1, ...joint], ['slider', 2, ...joint]),
  list('planes', vectors('normal'), doubles('offset_m', 'friction', 'rolling_m')),
  tagged('collision', 10, doubles('friction', 'rolling_m')), when((message) => message.fixed, 11),
  tagged('tool', 12, doubles('spacing_m', 'torsion_Nm_per_rad'),
    tagged('jaws', 17, vectors('hinge_m', 'axis', 'reach'), doubles('grip_Nm_per_rad'))));
const plastic = when((softness) => softness.plastic > 0, 8, doubles('plastic'));

/** Numbers of the material that came after the maps: as its type has them, in order. */
const scalars = (state) => concat((state.$type ? state.$type.fieldsArray : [])
  .filter((field) => field.type === 'double' && field.id > 15 && state[field.name])
  .sort((a, b) => a.id - b.id)
  .map(({name}) => concat([whole(13), text(name), double(state[name])])));

/** Of one value of an Effect: by what is there, or by what its field says where it is absent. */
const effectValue = (value, type, isRepeated) => {
  if (isRepeated) return concat([whole(value.length), ...value.map(double)]);
  if (type === 'double') return double(value);
  return type === 'Vector3' ? all(doubles('x', 'y', 'z'))(value) : whole(value);
};
const kTrigger = 17;
/** All fields before the trigger in order of their numbers, those that are absent as 0. */
const effect = (message) => concat(message.$type.fieldsArray.filter(({id}) => id < kTrigger)
  .sort((a, b) => a.id - b.id)
  .map(({name, type, repeated}) => effectValue(message[name], type, repeated)));
const effects = when(({effects: all}) => all && all.length, 14, list('effects', effect));
/** Of all effects, where one is not always felt (1). */
const triggers = when(({effects: all}) => all && all.some(({trigger}) => trigger > 1), 15,
  ({effects: all}) => concat(all.map(({trigger}) => whole(trigger || 1))));
/** Of all effects, each later field that is there. */
const laterFields = ({effects: all}) => concat((all || []).flatMap((message, i) => message.$type.fieldsArray
  .filter(({id, name, repeated}) => id > kTrigger && (repeated ? message[name].length : message[name]))
  .sort((a, b) => a.id - b.id)
  .map(({id, name, type, repeated}) => concat([whole(16), whole(i), whole(id), effectValue(message[name], type, repeated)]))));

/** Of an ObjectState. */
const objectBytes = all(
  wholes('id'), texts('name'), wholes('revision'), raw('mesh'), within('pose', quaternions('rotation'), vectors('position')),
  doubles('stiffness_N_per_m', 'damping_Ns_per_m'), within('color', floats('red', 'green', 'blue')),
  tagged('shading', 1, doubles('crease_rad'), list('creases', wholes('first', 'second'))),
  tagged('friction', 2, doubles('mu_static', 'mu_dynamic', 'variation'), map(), dynamicFriction),
  tagged('texture', 3, wholes('law'), within('field', field), doubles('amplitude_m'), wholes('literal'), doubles('gain_K')),
  tagged('stiffness_over', 10, doubles('variation'), map()),
  tagged('softness_over', 11, doubles('variation'), map()),
  scalars,
  tagged('motion', 4, motion),
  within('deformation',
    tagged('softness', 5, doubles('stiffness_N_per_m', 'radius_m'), wholes('degree'), doubles('return_s'), plastic),
    tagged('lattice', 6, vectors('low_m', 'size_m'), wholes('points_x', 'points_y', 'points_z'),
      (lattice) => concat(lattice.control_m.map(float))),
    tagged('residue', 7, raw('asset'))),
  effects, triggers, laterFields);

/** Of what an object's textured surface is drawn from: an ObjectState with nothing else in it (audience.proto, KEY). */
function surfaceBytes({mesh, shading, texture, deformation}) {
  return objectBytes({id: 0, name: '', revision: 0, mesh, pose: {rotation: {w: 1}}, shading, texture,
    deformation: deformation && {lattice: deformation.lattice, residue: deformation.residue}});
}

/** Of a scene. `hashed`: [ObjectState, its hash] of each object, in any order. */
function rootBytes(revision, hashed) {
  const inOrder = [...hashed].sort(([a], [b]) => (big(a.id) < big(b.id) ? -1 : 1));
  return concat([whole(revision), ...inOrder.flatMap(([o, hash]) => [whole(o.id), whole(o.revision), hash])]);
}

module.exports = {big, objectBytes, rootBytes, surfaceBytes};
