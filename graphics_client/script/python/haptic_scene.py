"""The scene's records as a client mirrors them, and their hashes (common/scene/scene.h), computed independently."""
import hashlib
import struct
from collections import namedtuple

from haptics.v1 import scene_pb2

# A server of this version holds at most 256 objects, of some 2.5 MB.
MAX_OBJECTS = 1024
MAX_SCENE_BYTES = 8 << 20
# Numbers of the material that came after the maps, in order of their fields.
SCALARS = [field.name for number, field in sorted(scene_pb2.ObjectState.DESCRIPTOR.fields_by_number.items())
           if number > 15 and field.type == field.TYPE_DOUBLE]


class OutOfStep(Exception):
    """What the server sent does not lead to the root that it names."""


class LimitExceeded(Exception):
    """The server sends more than this client holds."""


class Scene:
    """An object that holds what this version does not know (of a newer server) is kept, without a hash. While there is
    one, the root is the server's word."""

    def __init__(self, epoch=0, revision=0, records=(), root=None):
        """`root`: the server's."""
        self.epoch, self.revision = epoch, revision
        self._records = {record.state.id: record for record in records}
        check_limits(len(self._records), sum(record.size for record in self._records.values()))
        own = self._own_root()
        if own and root and own != root:
            raise OutOfStep(f"root at revision {revision}")
        self.root = own or root

    @staticmethod
    def from_snapshot(epoch, end, records):
        check_hash(end.root)
        scene = Scene(epoch, end.revision, records, end.root)
        if len(scene._records) != len(records):
            raise OutOfStep("the snapshot holds an object twice")
        return scene

    def states(self):
        """In order of id."""
        return [record.state for _, record in sorted(self._records.items())]

    def unknown(self):
        """Names of the objects that hold what this version does not know."""
        return [state.name for state in self.states() if not self._records[state.id].hash]

    def moves(self, number):
        """Whether there is such an object, with a motion."""
        return number in self._records and self._records[number].state.HasField("motion")

    def changed_at(self, number):
        """The revision that last changed the object; None where there is none."""
        return self._records[number].state.revision if number in self._records else None

    def after(self, commit):
        """The scene that the commit leads to."""
        check_hash(commit.root)
        if commit.revision != self.revision + 1 or commit.prev_root != self.root:
            raise OutOfStep(f"commit {commit.revision} does not follow revision {self.revision}")
        records = dict(self._records)
        for number in commit.removed:
            records.pop(number, None)
        records.update((state.id, Record.of(state)) for state in commit.put)
        return Scene(self.epoch, commit.revision, records.values(), commit.root)

    def _own_root(self):
        """SHA-256 over the revision and, for each object in order of id, (id, revision, hash)."""
        digest = hashlib.sha256(struct.pack("<Q", self.revision))
        for number, record in sorted(self._records.items()):
            if not record.hash:
                return None
            digest.update(struct.pack("<QQ", number, record.state.revision) + record.hash)
        return digest.digest()


class Record(namedtuple("Record", "state hash size")):
    """An object's state, its hash (None: it holds what this version does not know) and its bytes on the wire."""

    @staticmethod
    def of(state):
        own = scene_pb2.ObjectState()  # what is part of a message keeps all of it in memory
        own.CopyFrom(state)
        own.DiscardUnknownFields()
        if own.ByteSize() != state.ByteSize():
            own.CopyFrom(state)
            return Record(own, None, own.ByteSize())
        try:
            return Record(own, object_hash(own), own.ByteSize())
        except (ValueError, struct.error) as error:
            raise OutOfStep(f'object "{state.name}" is not whole: {error}') from error


def check_limits(objects, size):
    if objects > MAX_OBJECTS:
        raise LimitExceeded(f"the scene has more than {MAX_OBJECTS} objects, the most that this client holds")
    if size > MAX_SCENE_BYTES:
        raise LimitExceeded(f"the scene's records take more than {MAX_SCENE_BYTES >> 20} MiB, the most that this client holds")


def check_hash(data):
    if len(data) != hashlib.sha256().digest_size:
        raise OutOfStep(f"a root of {len(data)} bytes; SHA-256 has 32")


def object_hash(state):
    """SHA-256 over all fields: little-endian, text after its length, -0 as +0."""
    name = state.name.encode()
    rotation, position, color = state.pose.rotation, state.pose.position, state.color
    return hashlib.sha256(numbers(state.id, len(name)) + name + numbers(state.revision) + state.mesh +
                          doubles(*turn(rotation), *vector(position), state.stiffness_N_per_m, state.damping_Ns_per_m) +
                          struct.pack("<3f", *(value + 0.0 for value in (color.red, color.green, color.blue))) +
                          surface_bytes(state) + motion_bytes(state) + deformation_bytes(state) +
                          effect_bytes(state)).digest()


def surface_bytes(state):
    """Each property after its number: none, no bytes (common/scene/surface_properties.cpp)."""
    data = b""
    if state.HasField("shading"):
        data += numbers(1) + doubles(state.shading.crease_rad) + numbers(len(state.shading.creases))
        data += b"".join(numbers(crease.first, crease.second) for crease in state.shading.creases)
    if state.HasField("friction"):
        friction = state.friction
        data += numbers(2) + doubles(friction.mu_static, friction.mu_dynamic, friction.variation)
        data += map_bytes(friction, "over", "")
        if friction.WhichOneof("dynamic_over"):
            data += numbers(9) + doubles(friction.dynamic_variation) + map_bytes(friction, "dynamic_over", "dynamic_")
    if state.HasField("texture"):
        texture = state.texture
        data += numbers(3, texture.law) + field_bytes(texture.field) + doubles(texture.amplitude_m)
        data += numbers(texture.literal) + doubles(texture.gain_K)
    for number, name in ((10, "stiffness_over"), (11, "softness_over")):
        if state.HasField(name):
            surface_map = getattr(state, name)
            data += numbers(number) + doubles(surface_map.variation) + map_bytes(surface_map, "over", "")
    return data + b"".join(
        numbers(13, len(name)) + name.encode() + doubles(value)
        for name, value in ((name, getattr(state, name)) for name in SCALARS) if value)


def map_bytes(given, over, prefix):
    chosen = given.WhichOneof(over)
    data = numbers((None, prefix + "field", prefix + "per_vertex").index(chosen))
    if not chosen:
        return data
    one = getattr(given, chosen)
    return data + (field_bytes(one) if chosen == prefix + "field" else one.asset)


def motion_bytes(state):
    """After its number, as the surface's properties (common/scene/motion_properties.cpp)."""
    if not state.HasField("motion"):
        return b""
    motion, spring = state.motion, state.motion.spring
    data = numbers(4) + doubles(motion.mass_kg) + numbers(motion.HasField("inertia"))
    if motion.HasField("inertia"):
        inertia = motion.inertia
        data += doubles(*vector(inertia.centre_m), *vector(inertia.moments), *vector(inertia.products))
    data += doubles(*vector(motion.gravity_m_per_s2), motion.linear_damping_per_s, motion.angular_damping_per_s,
                    spring.stiffness_N_per_m, spring.damping_Ns_per_m, spring.stiffness_Nm_per_rad,
                    spring.damping_Nms_per_rad)
    kind = next((kind for kind in ("hinge", "slider") if motion.HasField(kind)), None)
    data += numbers((None, "hinge", "slider").index(kind))
    if kind:
        joint = getattr(motion, kind)
        data += doubles(*vector(joint.anchor_m), *vector(joint.axis), joint.lowest, joint.highest)
    data += numbers(len(motion.planes))
    for plane in motion.planes:
        data += doubles(*vector(plane.normal), plane.offset_m, plane.friction, plane.rolling_m)
    if motion.HasField("collision"):
        data += numbers(10) + doubles(motion.collision.friction, motion.collision.rolling_m)
    if motion.fixed:
        data += numbers(11)
    if motion.HasField("tool"):
        data += numbers(12) + doubles(motion.tool.spacing_m, motion.tool.torsion_Nm_per_rad)
        if motion.tool.HasField("jaws"):
            jaws = motion.tool.jaws
            data += numbers(17) + doubles(*vector(jaws.hinge_m), *vector(jaws.axis), *vector(jaws.reach),
                                          jaws.grip_Nm_per_rad)
    return data


def deformation_bytes(state):
    """Each property after its number likewise (common/scene/deformation_properties.cpp)."""
    data, given = b"", state.deformation
    if given.HasField("softness"):
        softness = given.softness
        data += numbers(5) + doubles(softness.stiffness_N_per_m, softness.radius_m) + numbers(softness.degree)
        data += doubles(softness.return_s)
        data += numbers(8) + doubles(softness.plastic) if softness.plastic else b""
    if given.HasField("lattice"):
        lattice = given.lattice
        data += numbers(6) + doubles(*vector(lattice.low_m), *vector(lattice.size_m))
        data += numbers(lattice.points_x, lattice.points_y, lattice.points_z)
        data += struct.pack(f"<{len(lattice.control_m)}f", *(value + 0.0 for value in lattice.control_m))
    if given.HasField("residue"):
        data += numbers(7) + given.residue.asset
    return data


def effect_bytes(state):
    """All fields of each up to size_m in order of their numbers, those that are absent as 0; the triggers of all where one has to
    be waited for; each later field that is there (common/scene/effect_properties.cpp)."""
    if not state.effects:
        return b""
    trigger = scene_pb2.Effect.TRIGGER_FIELD_NUMBER
    fields = sorted(scene_pb2.Effect.DESCRIPTOR.fields_by_number.items())
    data = numbers(14, len(state.effects)) + b"".join(value_bytes(field, getattr(effect, field.name))
                                                      for effect in state.effects for number, field in fields if number < trigger)
    triggers = [effect.trigger or scene_pb2.EFFECT_TRIGGER_ALWAYS for effect in state.effects]
    if set(triggers) != {scene_pb2.EFFECT_TRIGGER_ALWAYS}:
        data += numbers(15, *triggers)
    return data + b"".join(numbers(16, i, number) + value_bytes(field, getattr(effect, field.name))
                           for i, effect in enumerate(state.effects) for number, field in fields
                           if number > trigger and getattr(effect, field.name))


def value_bytes(field, value):
    if field.message_type:
        return doubles(*vector(value))
    if field.label == field.LABEL_REPEATED:
        return numbers(len(value)) + doubles(*value)
    return numbers(value) if field.enum_type else doubles(value)


def field_bytes(field):
    family = field.WhichOneof("family")
    if not family:
        raise ValueError("a field of no family")
    data = numbers(("fourier", "noise", "cellular", "grain", "mapped", "layers", "grown").index(family))
    one = getattr(field, family)
    if family == "fourier":
        return data + numbers(len(one.terms)) + b"".join(
            doubles(term.amplitude, *vector(term.direction), term.wavelength_m, term.phase_rad) for term in one.terms)
    if family == "noise":
        return data + doubles(one.wavelength_m) + numbers(one.octaves) + doubles(one.persistence) + numbers(one.seed)
    if family == "cellular":
        return data + doubles(one.cell_m, one.smoothness) + numbers(one.seed)
    if family == "grain":
        return data + doubles(one.grain_m) + numbers(one.seed)
    if family == "grown":
        return data + one.asset
    if family == "layers":
        return data + numbers(one.combination, len(one.layer)) + b"".join(
            doubles(layer.weight) + field_bytes(layer.field) for layer in one.layer)
    mapping = one.mapping
    return data + one.asset + numbers(mapping.shape) + doubles(*vector(mapping.centre), *turn(mapping.rotation),
                                                               *vector(mapping.size_m), mapping.tile_m)


def numbers(*values):
    return struct.pack(f"<{len(values)}Q", *values)


def doubles(*values):
    return struct.pack(f"<{len(values)}d", *(value + 0.0 for value in values))


def vector(message):
    return message.x, message.y, message.z


def turn(quaternion):
    return quaternion.w, quaternion.x, quaternion.y, quaternion.z
