// What the page computes with, within the limits of the programs: limits.json is theirs (Limits.OfThePageAreThoseOfTheWire). What
// they would refuse is not drawn; what else a scene holds is.
import limits from './limits.json';

const MAX_COORDINATE = 1000, MAX_DENTS = 12, MAX_BODIES = 32;  // kMaxCoordinate_m, kMaxDentsOfAll, kMaxMovingBodies

const isWithin = (value, [least, most]) => value >= least && value <= most;  // no number is within

/** The numbers of a path such as pose.position.x: none where a message on the way is absent; of a rotation its length. */
function numbersAt(message, [name, ...rest]) {
  const value = message[name];
  if (rest.length > 0) return value ? numbersAt(value, rest) : [];
  if (Array.isArray(value)) return value;
  if (name === 'rotation') return value ? [Math.hypot(value.w, value.x, value.y, value.z)] : [];
  const isOptional = message.$type.fields[name].options?.proto3_optional;
  return isOptional && !Object.hasOwn(message, name) ? [] : [value];
}

/** The path of the first number of an ObjectState, or of a message with some of its fields, that no program would take; null. */
export function badNumber(state, under = '') {
  for (const [path, range] of Object.entries(limits)) {
    if (path.startsWith(under) && !numbersAt(state, path.split('.')).every((value) => isWithin(value, range))) return path;
  }
  const lattice = state.deformation?.lattice;
  const count = lattice && 3 * lattice.points_x * lattice.points_y * lattice.points_z;
  return lattice && lattice.control_m.length !== count ? 'deformation.lattice.control_m' : null;
}

const isVector = (numbers) => numbers.length === 3 && numbers.every((value) => isWithin(value, [-MAX_COORDINATE, MAX_COORDINATE]));

/** A sample's dents and bodies that are some; more than a server has are left out. */
export const dentsOf = ({dent}) => dent.slice(0, MAX_DENTS).filter(({centre, displacement}) => isVector(centre) && isVector(displacement));
export const bodiesOf = ({body}) => body.slice(0, MAX_BODIES).filter((one) => one.pose && !badNumber(one, 'pose.'));
