// The scene that a page holds: objects by id, with the root of every revision computed and compared.
import {objectBytes, rootBytes, surfaceBytes} from './scene_hash.js';

export const hex = (bytes) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
export const sha256 = async (bytes) => new Uint8Array(await crypto.subtle.digest('SHA-256', bytes));

const MAX_OBJECTS = 1024;

/** Thrown where the page is out of step: it begins anew. */
export class OutOfStep extends Error {}

export class Scene {
  /** The scene of a snapshot; throws OutOfStep unless its root is `root`. */
  static async of(epoch, revision, objects, root) {
    const scene = new Scene(epoch, revision, new Map());
    for (const object of objects) await scene.#put(object);
    await scene.#check(root);
    return scene;
  }

  constructor(epoch, revision, objects) {
    this.epoch = epoch;
    this.revision = revision;
    this.objects = objects;  // by id, as text: {state, hash, surface: its KEY in hexadecimal, null without texture}
    this.root = null;
  }

  /** The scene after a commit; throws OutOfStep unless it follows this one and leads to the root that it names. */
  async after({revision, prev_root, put, removed, root}) {
    if (Number(revision) !== this.revision + 1 || hex(prev_root) !== hex(this.root)) {
      throw new OutOfStep(`a commit of revision ${revision} does not follow revision ${this.revision}`);
    }
    const next = new Scene(this.epoch, Number(revision), new Map(this.objects));
    for (const id of removed) next.objects.delete(String(id));
    for (const object of put) await next.#put(object);
    await next.#check(root);
    return next;
  }

  async #put(state) {
    const surface = state.texture ? hex(await sha256(surfaceBytes(state))) : null;
    this.objects.set(String(state.id), {state, hash: await sha256(objectBytes(state)), surface});
    if (this.objects.size > MAX_OBJECTS) throw new OutOfStep(`more than ${MAX_OBJECTS} objects`);
  }

  async #check(root) {
    this.root = await sha256(rootBytes(this.revision, [...this.objects.values()].map(({state, hash}) => [state, hash])));
    if (hex(this.root) !== hex(root)) throw new OutOfStep(`own root of revision ${this.revision} is not the server's`);
  }
}
