// Assets as they are stored, and the shape of an object as mesh, lattice, residue and dents have it (proto/README.md: Canonical
// bytes, Shapes).

const MAX_VERTICES = 50e6;

function header(bytes, magic, each) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 16 || String.fromCharCode(...bytes.subarray(0, 4)) !== magic || view.getUint32(4, true) !== 1) {
    throw new Error(`not ${magic}`);
  }
  const count = Number(view.getBigUint64(8, true));
  if (count > MAX_VERTICES || bytes.length < 16 + each * count) throw new Error(`${magic} is cut off`);
  return {count, view};
}

function checkPoints(points) {
  if (!points.every(Number.isFinite)) throw new Error('a point is nowhere');
}

/** {vertices: Float32Array of x y z, triangles: Uint32Array of three indices}. */
function decodeMesh(bytes) {
  const {count, view} = header(bytes, 'HMSH', 12);
  const triangles = Number(view.getBigUint64(16, true));
  if (bytes.length !== 24 + 12 * count + 12 * triangles) throw new Error('a mesh is cut off');
  const at = 24 + 12 * count;
  const mesh = {
    vertices: new Float32Array(bytes.slice(24, at).buffer),
    triangles: new Uint32Array(bytes.slice(at).buffer),
  };
  checkPoints(mesh.vertices);
  if (mesh.triangles.some((vertex) => vertex >= count)) throw new Error('a triangle names no vertex');
  return mesh;
}

/** {vertices, triangles, heights: Uint8Array} of a textured surface (audience.proto). */
function decodeSurface(bytes) {
  const {count, view} = header(bytes, 'HSRF', 13);
  const triangles = Number(view.getBigUint64(16, true)), at = 24 + 12 * count, end = at + 12 * triangles;
  if (bytes.length !== end + count) throw new Error('a surface is cut off');
  const surface = {
    vertices: new Float32Array(bytes.slice(24, at).buffer),
    triangles: new Uint32Array(bytes.slice(at, end).buffer),
    heights: bytes.slice(end),
  };
  checkPoints(surface.vertices);
  if (surface.triangles.some((vertex) => vertex >= count)) throw new Error('a triangle names no vertex');
  return surface;
}

/** What the bytes hold, by how they begin. */
export function decodeAsset(bytes) {
  const decoders = {HMSH: decodeMesh, HMOV: decodeMoved, HSRF: decodeSurface};
  const decode = decoders[String.fromCharCode(...bytes.subarray(0, 4))];
  if (!decode) throw new Error('an asset of a kind that this page does not know');
  return decode(bytes);
}

/** {vertex: Uint32Array, places: Float32Array}. */
function decodeMoved(bytes) {
  const {count} = header(bytes, 'HMOV', 16);
  const at = 16 + 4 * count;
  if (bytes.length !== at + 12 * count) throw new Error('moved vertices are cut off');
  const moved = {vertex: new Uint32Array(bytes.slice(16, at).buffer), places: new Float32Array(bytes.slice(at).buffer)};
  checkPoints(moved.places);
  return moved;
}

function weights(n, t) {
  const w = [1];
  for (let d = 1; d < n; d++) {
    let carry = 0;
    for (let i = 0; i <= d; i++) {
      const own = i === d ? 0 : w[i];
      w[i] = own * (1 - t) + carry;
      carry = own * t;
    }
  }
  return w;
}

function shapeByLattice({low_m, size_m, points_x, points_y, points_z, control_m}, points) {
  for (let v = 0; v < points.length; v += 3) {
    const wx = weights(points_x, (points[v] - low_m.x) / size_m.x);
    const wy = weights(points_y, (points[v + 1] - low_m.y) / size_m.y);
    const wz = weights(points_z, (points[v + 2] - low_m.z) / size_m.z);
    const sum = [0, 0, 0];
    let at = 0;
    for (let z = 0; z < points_z; z++) {
      for (let y = 0; y < points_y; y++) {
        for (let x = 0; x < points_x; x++, at += 3) {
          const w = wx[x] * (wy[y] * wz[z]);
          for (let k = 0; k < 3; k++) sum[k] += control_m[at + k] * w;
        }
      }
    }
    points.set(sum, v);
  }
}

/** The points of an object without its dents; a new array. `moved`: its residue, or nothing. */
export function restShape(mesh, deformation, moved) {
  const points = mesh.vertices.slice();
  if (moved?.vertex.some((vertex) => 3 * vertex >= points.length)) throw new Error('a moved vertex is none of the mesh');
  if (deformation?.lattice) shapeByLattice(deformation.lattice, points);
  moved?.vertex.forEach((vertex, i) => points.set(moved.places.subarray(3 * i, 3 * i + 3), 3 * vertex));
  return points;
}

/** Displaces the points by the dents, in their order. */
export function dent(points, dents, {radius_m, degree}) {
  const inverse = 1 / (radius_m * radius_m);
  for (const {centre: [cx, cy, cz], displacement: [dx, dy, dz]} of dents) {
    for (let v = 0; v < points.length; v += 3) {
      const x = points[v] - cx, y = points[v + 1] - cy, z = points[v + 2] - cz;
      const u = 1 - (x * x + y * y + z * z) * inverse;
      if (u <= 0) continue;
      let p = u;
      for (let d = 1; d < (degree || 2); d++) p *= u;
      points[v] += dx * p;
      points[v + 1] += dy * p;
      points[v + 2] += dz * p;
    }
  }
}

/** A tool's jaws, closed in `rest`, open so far; a new array (proto/haptics/v1/scene.proto, Jaws). */
export function openJaws(rest, {hinge_m, axis, reach}, opening_rad) {
  const at = (v) => [v?.x || 0, v?.y || 0, v?.z || 0];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const h = at(hinge_m), k = at(axis), up = cross(k, at(reach)), points = rest.slice();
  for (let v = 0; v < points.length; v += 3) {
    const r = [rest[v] - h[0], rest[v + 1] - h[1], rest[v + 2] - h[2]];
    const angle = (dot(up, r) > 0 ? 0.5 : -0.5) * opening_rad, turned = cross(k, r), along = dot(k, r);
    for (let d = 0; d < 3; d++)
      points[v + d] = h[d] + r[d] * Math.cos(angle) + turned[d] * Math.sin(angle) + k[d] * along * (1 - Math.cos(angle));
  }
  return points;
}

/** Vertex normals, weighted by area. */
export function normalsOf(points, triangles) {
  const normals = new Float32Array(points.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i] += nx;
      normals[i + 1] += ny;
      normals[i + 2] += nz;
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
    for (let k = 0; k < 3; k++) normals[v + k] /= length;
  }
  return normals;
}
