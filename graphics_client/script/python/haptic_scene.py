"""The scene's records as a client mirrors them, and their hashes (common/scene/scene.h), computed independently."""
import hashlib
import struct


class OutOfStep(Exception):
    """What the server sent does not lead to the root that it names."""


class Scene:
    def __init__(self, epoch=0, revision=0, objects=()):
        self.epoch, self.revision = epoch, revision
        self._objects = {state.id: (state, object_hash(state)) for state in objects}
        self._update_root()

    @staticmethod
    def from_snapshot(epoch, end, objects):
        scene = Scene(epoch, end.revision, objects)
        if scene.root != end.root:
            raise OutOfStep(f"snapshot's root at revision {end.revision}")
        return scene

    def states(self):
        """In order of id."""
        return [state for _, (state, _) in sorted(self._objects.items())]

    def apply(self, commit):
        if commit.revision != self.revision + 1 or commit.prev_root != self.root:
            raise OutOfStep(f"commit {commit.revision} does not follow revision {self.revision}")
        for number in commit.removed:
            self._objects.pop(number, None)
        for state in commit.put:
            self._objects[state.id] = state, object_hash(state)
        self.revision = commit.revision
        self._update_root()
        if commit.root != self.root:
            raise OutOfStep(f"commit's root at revision {commit.revision}")

    def _update_root(self):
        """SHA-256 over the revision and, for each object in order of id, (id, revision, hash)."""
        digest = hashlib.sha256(struct.pack("<Q", self.revision))
        for number, (state, own_hash) in sorted(self._objects.items()):
            digest.update(struct.pack("<QQ", number, state.revision) + own_hash)
        self.root = digest.digest()


def object_hash(state):
    """SHA-256 over all fields: little-endian, text after its length, -0 as +0."""
    name = state.name.encode()
    rotation, position, color = state.pose.rotation, state.pose.position, state.color
    doubles = (rotation.w, rotation.x, rotation.y, rotation.z, position.x, position.y, position.z,
               state.stiffness_N_per_m, state.damping_Ns_per_m)
    return hashlib.sha256(struct.pack("<QQ", state.id, len(name)) + name + struct.pack("<Q", state.revision) + state.mesh +
                          struct.pack("<9d", *(value + 0.0 for value in doubles)) +
                          struct.pack("<3f", *(value + 0.0 for value in (color.red, color.green, color.blue)))).digest()
