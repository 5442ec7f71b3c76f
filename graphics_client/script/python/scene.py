"""Scenes without text format.

    from haptics.scene import Material, MeshSource, Scene, Sphere

    scene = Scene()
    scene.add(name="ball", mesh=MeshSource(sphere=Sphere(radius_m=0.02)), material=Material(stiffness_N_per_m=600))
    scene.set_pose(object={"name": "ball"}, pose={"position": {"z": 0.05}})
    scene.save("ball.scene")             # for haptic_server --scene, deploy/run --scene, hapticctl apply, the viewer
    haptics.SceneWorld(scene)            # in this process
    client.apply(scene)                  # on a server

An effect is a call of its kind, of which only the fields that it uses matter; paths and vectors are sequences of x, y, z:

    from haptics.scene import TAPS, guide, samples, spline, viscosity, wav

    scene.set_material(object={"name": "ball"}, material=Material(**TAPS["wood"]))
    scene.set_effects(object={"name": "ball"}, effects=[
        guide(path_m=spline([(0, 0, 0.03), (0.02, 0.01, 0.03), (0.04, 0, 0.03)]), stiffness_N_per_m=200, reach_m=0.01),
        viscosity(damping_Ns_per_m=2, region=EFFECT_REGION_SPHERE, size_m=(0.08, 0, 0)),
        samples(**wav("click.wav"), amplitude_N=1, direction=(0, 0, 1), trigger=EFFECT_TRIGGER_BUTTON)])

This module has every message of scene.proto, which says fields, units, ranges and defaults; editors complete them. A dict
stands for a message in any place. What a file may not hold is said by who opens it, by its field.
"""
import filecmp
import math
import os
import shutil
import wave
from inspect import Parameter, Signature
from pathlib import Path
from typing import BinaryIO, Callable, Generic, Iterator, NamedTuple, ParamSpec, TypeVar

from google.protobuf import text_format
from google.protobuf.message import Message

from haptics.v1.scene_pb2 import *  # noqa: F401,F403
from haptics.v1.scene_pb2 import (ASSET_KIND_MESH, ASSET_KIND_MOVED_VERTICES, ASSET_KIND_POINT_FIELD, ASSET_KIND_SCALAR_FIELD,
                                  ASSET_KIND_VERTEX_VALUES, AddObject, Effect, EffectKind, Operation, RemeshObject, RemoveObject,
                                  SetDeformation, SetEffects, SetMaterial, SetMotion, SetPose, Transaction)

_P = ParamSpec("_P")
_M = TypeVar("_M", bound=Message)


class _Appending(Generic[_P, _M]):
    """An operation as a method of Scene, with the fields that its message has."""

    def __init__(self, kind: Callable[_P, _M]):
        self._kind = kind

    def __get__(self, scene: "Scene", owner: "type | None" = None) -> Callable[_P, _M]:
        def append(*args, **fields):
            message = self._kind(*args, **fields)
            scene.append(message)
            return message
        append.__doc__ = f"Appends {self._kind.__name__} with these fields."
        append.__signature__ = Signature([Parameter(field.name, Parameter.KEYWORD_ONLY, default=None)
                                          for field in self._kind.DESCRIPTOR.fields])
        return append


class Scene:
    """Operations in their order, one transaction: all of it becomes a scene, or none."""

    def __init__(self, transaction: Transaction | None = None, folder: "str | os.PathLike[str]" = "."):
        """`folder`: below which lie the files that the operations name."""
        self.transaction = Transaction()
        if transaction is not None:
            self.transaction.CopyFrom(transaction)
        self.folder = Path(folder)

    add = _Appending(AddObject)
    remove = _Appending(RemoveObject)
    remesh = _Appending(RemeshObject)
    set_pose = _Appending(SetPose)
    set_material = _Appending(SetMaterial)
    set_motion = _Appending(SetMotion)
    set_deformation = _Appending(SetDeformation)
    set_effects = _Appending(SetEffects)

    def append(self, message: Message) -> None:
        """Any of the messages that an Operation may be."""
        for field in Operation.DESCRIPTOR.oneofs_by_name["op"].fields:
            if field.message_type is message.DESCRIPTOR:
                getattr(self.transaction.operations.add(), field.name).CopyFrom(message)
                return
        raise TypeError(f"{message.DESCRIPTOR.name} is no operation")

    def __str__(self) -> str:
        """As a scene file has it."""
        return text_format.MessageToString(self.transaction)

    @classmethod
    def load(cls, file: "str | os.PathLike[str]") -> "Scene":
        """Raises OSError; ValueError, which names file, line and column."""
        try:
            text = Path(file).read_text(encoding="utf-8-sig")
            return cls(text_format.Parse(text, Transaction()), Path(file).parent)
        except (UnicodeDecodeError, text_format.ParseError) as error:
            raise ValueError(f"{file}: {error}") from None

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes a scene file, and beside it copies of the files that the scene names and that lie below its folder; others are
        the reader's to find. Replaces the scene file, but none of the others: raises FileExistsError where one holds
        something else. ValueError: a name that leaves the folder; OSError."""
        file = Path(file)
        for reference in self.references():
            found = reference.below(self.folder)
            if found is None:
                continue
            copy = file.parent / reference.file
            if not copy.exists():
                copy.parent.mkdir(parents=True, exist_ok=True)
                with open(found, "rb") as source:
                    _write(copy, lambda part: shutil.copyfileobj(source, part))
            elif not filecmp.cmp(found, copy, shallow=False):
                raise FileExistsError(f"{reference.field}: {copy} is there already and holds something else")
        _write(file, lambda part: part.write(str(self).encode()))

    def references(self) -> "Iterator[Reference]":
        """Each place that names a file."""
        return _references(self.transaction, "")


def _write(file: Path, fill: "Callable[[BinaryIO], object]") -> None:
    """At the file's name there is what was there before, or all of what `fill` writes, which outlasts a loss of power."""
    part = file.with_name(file.name + ".part")
    try:
        with open(part, "wb") as stream:
            fill(stream)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(file)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    folder = os.open(file.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _effect(kind):
    def make(**fields):
        for name in ("point_m", "direction", "size_m"):
            if isinstance(fields.get(name), (tuple, list)):
                fields[name] = dict(zip("xyz", fields[name], strict=True))
        if "path_m" in fields:  # points, or their numbers in turn
            fields["path_m"] = [number for point in fields["path_m"]
                                for number in (point if hasattr(point, "__len__") else (point,))]
        return Effect(kind=kind, **fields)
    make.__doc__ = f"An Effect of the kind {EffectKind.Name(kind)} with these fields."
    make.__signature__ = Signature([Parameter(field.name, Parameter.KEYWORD_ONLY, default=None)
                                    for field in Effect.DESCRIPTOR.fields if field.name != "kind"])
    return make


constant = _effect(EffectKind.EFFECT_KIND_CONSTANT)
spring_to_point = _effect(EffectKind.EFFECT_KIND_SPRING_TO_POINT)
spring_to_line = _effect(EffectKind.EFFECT_KIND_SPRING_TO_LINE)
spring_to_plane = _effect(EffectKind.EFFECT_KIND_SPRING_TO_PLANE)
spring_to_path = _effect(EffectKind.EFFECT_KIND_SPRING_TO_PATH)
guide = _effect(EffectKind.EFFECT_KIND_GUIDE)
forbidden_side = _effect(EffectKind.EFFECT_KIND_FORBIDDEN_SIDE)
viscosity = _effect(EffectKind.EFFECT_KIND_VISCOSITY)
vibration = _effect(EffectKind.EFFECT_KIND_VIBRATION)
tube = _effect(EffectKind.EFFECT_KIND_TUBE)
inertia = _effect(EffectKind.EFFECT_KIND_INERTIA)
magnet = _effect(EffectKind.EFFECT_KIND_MAGNET)
spring_to_vertex = _effect(EffectKind.EFFECT_KIND_SPRING_TO_VERTEX)
spring_to_edge = _effect(EffectKind.EFFECT_KIND_SPRING_TO_EDGE)
samples = _effect(EffectKind.EFFECT_KIND_SAMPLES)
recorded_texture = _effect(EffectKind.EFFECT_KIND_RECORDED_TEXTURE)

MAX_SAMPLES = 65536  # of an effect
MAX_PATH_POINTS = 4096


def spline(points, *, closed: bool = False, tolerance_m: float = 1e-5) -> list:
    """The path_m of a curve through points (m): a polyline that is nowhere farther than tolerance_m from their centripetal
    Catmull-Rom spline, which has no cusps or loops between two of them (Yuksel, Schaefer and Keyser 2011).

    ValueError: fewer than two points, two in a row at one place, or a path of more than MAX_PATH_POINTS."""
    points = [tuple(map(float, point)) for point in points]
    if closed:
        points = points[-1:] + points + points[:2]
    elif len(points) > 1:  # straight on at the ends
        points = [tuple(2 * a - b for a, b in zip(*points[:2]))] + points + [tuple(2 * a - b for a, b in zip(*points[:-3:-1]))]
    if len(points) < 4:
        raise ValueError(f"a curve leads through two points or more, a closed one through three; these are {len(points)}")
    path = [points[1]]
    for i, four in enumerate(zip(points, points[1:], points[2:], points[3:])):
        a, b, c = (math.dist(p, q) ** 0.5 for p, q in zip(four, four[1:]))
        if not min(a, b, c) > 0:
            raise ValueError(f"points: two in a row are at one place, beside the one with number {i} from 0; leave one out")
        p, q, r, s = four
        handles = [tuple((d * d * ahead - b * b * behind + (2 * d * d + 3 * d * b + b * b) * own) / (3 * d * (d + b))
                         for ahead, own, behind in zip(*three)) for d, three in ((a, (r, q, p)), (c, (q, r, s)))]
        curve = (q, *handles, r)  # a cubic Bezier curve, whose second derivative is 6 of these differences at most
        bend = max(math.hypot(*(x - 2 * y + z for x, y, z in zip(*curve[k:k + 3]))) for k in (0, 1))
        count = max(1, math.ceil((6 * bend / 8 / tolerance_m) ** 0.5))
        if len(path) + count > MAX_PATH_POINTS:
            raise ValueError(f"tolerance_m: {tolerance_m:g} asks for more points than a path may have, {MAX_PATH_POINTS}: "
                             "make it larger, or give fewer points")
        for k in range(1, count + 1):
            t, u = k / count, 1 - k / count
            path.append(tuple(u * u * u * w + 3 * u * u * t * x + 3 * u * t * t * y + t * t * t * z
                              for w, x, y, z in zip(*curve)))
    return path


def wav(path: "str | os.PathLike") -> dict:
    """The fields of samples() that a WAV file of whole numbers has: samples (mean of the channels) and sample_rate_Hz.

    ValueError: it is longer than an effect may be. wave.Error, EOFError: it is no such file."""
    with wave.open(os.fspath(path), "rb") as file:
        channels, size, rate, count = file.getparams()[:4]
        if count > MAX_SAMPLES:
            raise ValueError(f"{path}: has {count / rate:.4g} s at {rate} Hz; an effect has at most {MAX_SAMPLES} samples, "
                             f"{MAX_SAMPLES / rate:.4g} s at this rate: cut it, or lower its rate")
        data = file.readframes(count)
    zero = 128 if size == 1 else 0  # of one byte they have no sign
    numbers = [int.from_bytes(data[i:i + size], "little", signed=size > 1) - zero
               for i in range(0, len(data) - size + 1, size)]
    full = channels << 8 * size - 1
    return {"samples": [sum(numbers[i:i + channels]) / full for i in range(0, len(numbers) - channels + 1, channels)],
            "sample_rate_Hz": rate}


# Fields of Material (haptic_server/engine/effects/README.md says where they are from).
TAPS = {"rubber": {"tap_Ns_per_m": 5.8, "tap_Hz": 18.0, "tap_decay_per_s": 60.0},
        "wood": {"tap_Ns_per_m": 7.5, "tap_Hz": 30.0, "tap_decay_per_s": 80.0},
        "metal": {"tap_Ns_per_m": 15.0, "tap_Hz": 100.0, "tap_decay_per_s": 90.0}}


_KINDS = {"MeshSource": ASSET_KIND_MESH, "MappedField": ASSET_KIND_SCALAR_FIELD,
          "GrownField": ASSET_KIND_POINT_FIELD, "PerVertex": ASSET_KIND_VERTEX_VALUES,
          "Residue": ASSET_KIND_MOVED_VERTICES}
_CANONICAL = (".mesh", ".field", ".points", ".values", ".moved")


class Reference(NamedTuple):
    """A message that names a file."""
    message: Message
    field: str  # "operations[0].add.mesh.file"
    file: str

    @property
    def kind(self) -> int:
        return _KINDS[self.message.DESCRIPTOR.name]

    def below(self, folder: Path) -> "Path | None":
        """The file; None where it is not there. Raises ValueError for a name that leaves the folder."""
        if Path(self.file).is_absolute() or ".." in Path(self.file).parts:
            raise ValueError(f'{self.field}: "{self.file}" leaves the scene\'s folder; give a path below it')
        path = folder / self.file
        return path if path.is_file() else None

    def asset_below(self, folder: Path) -> "bytes | None":
        """An asset's canonical bytes, which the file holds; None where it is not there, or holds something else."""
        path = self.below(folder)
        return path.read_bytes() if path is not None and path.suffix in _CANONICAL else None


def _references(message: Message, path: str) -> "Iterator[Reference]":
    name = "image" if message.DESCRIPTOR.name == "MappedField" else "file"
    if message.DESCRIPTOR.name in _KINDS and getattr(message, name):
        yield Reference(message, f"{path}.{name}", getattr(message, name))
    for field, value in message.ListFields():
        below = f"{path}.{field.name}" if path else field.name
        if isinstance(value, Message):
            yield from _references(value, below)
        elif field.type == field.TYPE_MESSAGE:
            for i, one in enumerate(value):
                yield from _references(one, f"{below}[{i}]")
