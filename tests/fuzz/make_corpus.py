"""Writes the fuzzers' seeds: real messages, a file for each kind and some in a row. Run it after a change of the protocol:

  out=$(mktemp -d); protoc -Iproto --python_out=$out proto/haptics/v1/*.proto
  PYTHONPATH=$out /usr/bin/python3 -B tests/fuzz/make_corpus.py
"""
import base64
import hashlib
import json
import struct
import zlib
from pathlib import Path

from google.protobuf import text_format
from haptics.v1 import audience_pb2, envelope_pb2, recording_pb2, scene_pb2, state_pb2

CORPUS = Path(__file__).parent / "corpus"
SCENES = {
    "add": 'operations { add { name: "new" mesh { box { size_m { x: 0.1 y: 0.2 z: 0.3 } segments: 2 } } '
           'pose { position { x: 1 } rotation { w: 1 } } material { stiffness_N_per_m: 400 damping_Ns_per_m: 1 '
           'color { red: 1 green: 0.5 } } } }',
    "shapes": 'operations { add { name: "s" mesh { sphere { radius_m: 0.1 } } } } operations { add { name: "c" mesh { '
              'cylinder { radius_m: 0.1 height_m: 0.2 } } } } operations { add { name: "t" mesh { torus { '
              'major_radius_m: 0.2 minor_radius_m: 0.1 } } } }',
    "file": 'operations { add { name: "f" mesh { file: "../a.stl" unit_m: 0.001 } } }',
    "asset": 'operations { remesh { object { id: 1 } mesh { asset: "0123456789abcdef0123456789abcdef" '
             'largest_extent_m: 0.1 } } }',
    "pose": 'operations { set_pose { object { name: "a" } pose { position { x: -0.5 y: 1e-3 } } } }',
    "material": 'operations { set_material { object { id: 1 } material { stiffness_N_per_m: 1500 } } }',
    "shading": 'operations { set_material { object { id: 1 } material { shading { crease_rad: 0.5 creases { first: 1 second: 2 } '
               '} } } }',
    "friction": 'operations { set_material { object { id: 1 } material { friction { mu_static: 0.6 mu_dynamic: 0.3 variation: '
                '0.5 field { grain { grain_m: 1e-3 } } } } } }',
    "per_vertex": 'operations { set_material { object { name: "a" } material { friction { mu_static: 1 per_vertex { values { '
                  'value: [0, 1, 2, 1, 1, 1, 1, 0.5] } } } } } }',
    "fourier": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 law: TEXTURE_LAW_BUMP field '
               '{ fourier { terms { direction { x: 1 } wavelength_m: 2e-3 } terms { amplitude: -2 direction { z: 1 } '
               'wavelength_m: 3e-3 phase_rad: 1 } } } } } } }',
    "noise": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 gain_K: 1 field { noise { '
             'wavelength_m: 2e-3 octaves: 3 persistence: 0.6 seed: 4 } } } } } }',
    "cellular": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 literal: true field { '
                'cellular { cell_m: 2e-3 smoothness: 0.2 } } } } } }',
    "spots": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 field { mapped { spot_noise { '
             'cells: 3 resolution: 32 } mapping { shape: MAPPING_SHAPE_SPHERE tile_m: 0.01 } } } } } } }',
    "image": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 field { mapped { image: "a.png" '
             'mapping { shape: MAPPING_SHAPE_CUBE tile_m: 0.01 centre { x: 1 } size_m { x: 1 y: 1 z: 1 } rotation { w: 1 } } } } '
             '} } } }',
    "layers": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 field { layers { '
              'combination: LAYER_COMBINATION_PRODUCT layer { field { grain { grain_m: 1e-3 } } } layer { weight: -2 field { '
              'mapped { spot_noise { cells: 3 resolution: 32 } mapping { shape: MAPPING_SHAPE_PLANE tile_m: 0.01 } } } } } } '
              '} } } }',
    "grown": 'operations { set_material { object { name: "a" } material { texture { amplitude_m: 1e-3 field { grown { '
             'reaction_diffusion { pattern: REACTION_DIFFUSION_PATTERN_STRIPES wavelength_m: 0.2 seed: 2 } } } } } } }',
    "grown_asset": 'operations { set_material { object { id: 1 } material { texture { amplitude_m: 1e-3 field { grown { asset: '
                   '"%s" } } } } } }' % ("7" * 32),
    "dynamic": 'operations { set_material { object { name: "a" } material { friction { mu_static: 0.6 mu_dynamic: 0.3 variation: '
               '0.5 field { grain { grain_m: 1e-3 } } dynamic_variation: -0.5 dynamic_field { layers { layer { weight: 2 field { '
               'noise { wavelength_m: 2e-3 } } } layer { field { cellular { cell_m: 2e-3 } } } } } } } } }',
    "stiffness": 'operations { set_material { object { name: "a" } material { stiffness_over { variation: 0.5 field { noise { '
                 'wavelength_m: 2e-3 } } } softness_over { per_vertex { values { value: [1, 0.5, 1, 2, 1, 1, 0, 1] } } } } } }',
    "take_away": 'operations { set_material { object { name: "a" } material { shading {} friction {} texture {} stiffness_over {} '
                 'softness_over {} } } }',
    "motion": 'operations { set_motion { object { id: 1 } motion { mass_kg: 0.3 inertia { centre_m { x: 0.1 } moments { x: 1e-3 '
              'y: 1e-3 z: 1e-3 } products { y: 1e-4 } } gravity_m_per_s2 { z: -1.6 } linear_damping_per_s: 1 spring { '
              'stiffness_N_per_m: 100 damping_Ns_per_m: 1 } planes { normal { z: 1 } offset_m: -1 friction: 0.4 } } } }',
    "hinge": 'operations { set_motion { object { name: "a" } motion { mass_kg: 1 hinge { anchor_m { x: 0.1 } axis { z: 1 } '
             'lowest: -1 highest: 0.5 } } } }',
    "slider": 'operations { add { name: "d" mesh { box { size_m { x: 0.1 y: 0.1 z: 0.1 } } } motion { mass_kg: 1 slider { axis { '
              'x: 1 } } } } }',
    "collision": 'operations { set_motion { object { id: 1 } motion { mass_kg: 0.3 collision { friction: 0.4 rolling_m: 1e-3 } } } } '
                 'operations { set_motion { object { name: "a" } motion { fixed: true collision {} } } }',
    "tool": 'operations { set_motion { object { name: "a" } motion { tool { spacing_m: 0.02 torsion_Nm_per_rad: 0.5 } } } }',
    "jaws": 'operations { set_motion { object { name: "a" } motion { tool { spacing_m: 0.02 jaws { hinge_m { x: -0.1 } axis { y: 1 } '
            'reach { x: 1 } grip_Nm_per_rad: 0.5 } } } } }',
    "stop": 'operations { set_motion { object { id: 1 } motion {} } }',
    "softness": 'operations { set_deformation { object { id: 1 } deformation { softness { stiffness_N_per_m: 200 radius_m: 0.01 '
                'degree: 3 return_s: 0.5 } } } }',
    "plastic": 'operations { set_deformation { object { id: 1 } deformation { softness { stiffness_N_per_m: 200 radius_m: 0.01 '
               'plastic: 0.5 } residue {} } } }',
    "residue": 'operations { set_deformation { object { id: 1 } deformation { residue { asset: "%s" } } } }' % ("7" * 32),
    "lattice": 'operations { set_deformation { object { name: "a" } deformation { lattice { points_x: 2 points_y: 2 points_z: 2 '
               'control_m: [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1.5] } } } }',
    "rigid": 'operations { set_deformation { object { id: 1 } deformation { softness {} lattice {} } } }',
    "effects": 'operations { set_effects { object { id: 1 } effects { kind: EFFECT_KIND_GUIDE path_m: [0, 0, 0, 1, 0, 0] '
               'stiffness_N_per_m: 100 reach_m: 0.01 release_m: 0.02 fade_m: 0.01 } effects { kind: EFFECT_KIND_VIBRATION '
               'direction { z: 1 } amplitude_N: 1 frequency_Hz: 50 region: EFFECT_REGION_BOX size_m { x: 1 y: 1 z: 1 } } '
               'effects { kind: EFFECT_KIND_INERTIA mass_kg: 1 stiffness_N_per_m: 9 region: EFFECT_REGION_INSIDE } effects { '
               'kind: EFFECT_KIND_SAMPLES direction { z: 1 } amplitude_N: 1 samples: [0, 1, -1] sample_rate_Hz: 800 } effects { '
               'kind: EFFECT_KIND_RECORDED_TEXTURE amplitude_N: 1 sample_rate_Hz: 1e4 speeds_m_per_s: 0.1 forces_N: [1, 2] '
               'models: [0.1, -0.9, 1, 0.5] } } }',
    "remove": 'operations { remove { object { name: "a" } } }',
    "condition": 'preconditions { object { name: "a" } expected_revision: 1 } operations { remove { object { id: 1 } } }',
    "remesh": 'operations { remesh { object { name: "a" } mesh { box { size_m { x: 0.3 y: 0.3 z: 0.3 } } } } }',
}


MOVED = b"HMOV" + struct.pack("<IQ2I6f", 1, 2, 1, 3, 0, 0, 0.5, 1, 0, 0.25)

# 8 x 8 grey pixels, with and without passes of growing detail; the standard library writes no JPEG.
JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAA0JCgsKCA0LCgsODg0PEyAVExISEyccHhcgLikxMC4pLSwzOko+MzZGNywtQFdBRkxOUlNSMj5aYV"
    "pQYEpRUk//wAALCAAIAAgBAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIh"
    "MUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhI"
    "WGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3+Pn6/9oACAEBAAA/AEt/"
    "AvT9z+lf/9k=")
PROGRESSIVE_JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAA0JCgsKCA0LCgsODg0PEyAVExISEyccHhcgLikxMC4pLSwzOko+MzZGNywtQFdBRkxOUlNSMj5aYV"
    "pQYEpRUk//wgALCAAIAAgBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAAf/aAAgBAQAAAAE//8QAFhAAAwAAAAAAAAAAAAAAAAAAAAIE/9oACAEB"
    "AAEFAlhP/8QAFRABAQAAAAAAAAAAAAAAAAAAADH/2gAIAQEABj8Cj//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAT8hP//aAAgBAQAAAB"
    "D/AP/EABYQAAMAAAAAAAAAAAAAAAAAAAAxwf/aAAgBAQABPxBEH//Z")


def png(side, colour_type, depth, pixel):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + pixel * side for _ in range(side))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, depth, colour_type, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def tetrahedron():
    vertices = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    triangles = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    return b"HMSH" + struct.pack("<IQQ12f12I", 1, 4, 4, *vertices, *triangles)


def mesh_files():
    """A tetrahedron in each format of mesh_file_fuzz.cpp, by its number there."""
    points = "0 0 0 1 0 0 0 1 0 0 0 1"
    faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    lines = [points[i:i + 5] for i in range(0, len(points), 6)]
    rows = "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    ply = "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n" \
          "property list uchar int vertex_indices\nend_header\n"
    corners = [tuple(map(float, lines[i].split())) for face in faces for i in face]
    buffer = struct.pack("<12f12H", *map(float, points.split()), *(i for face in faces for i in face))
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0, "skin": 0, "rotation": [0, 0, 0, 1]}, {"translation": [1, 0, 0]}], "skins": [{"joints": [1]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 2}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
                          {"bufferView": 0, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": True}],
            "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}]}
    packed = json.dumps({**gltf, "buffers": [{"byteLength": 72}]})
    packed += " " * (-len(packed) % 4)
    chunks = struct.pack("<I4s", len(packed), b"JSON") + packed.encode() + struct.pack("<I4s", 72, b"BIN\0") + buffer
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    x3d = f'<X3D version="3.3"><Scene><Transform DEF="a" rotation="0 0 1 1" scale="1 1 2"><Shape><IndexedFaceSet ccw="false" ' \
          f'coordIndex="0 2 1 -1 0 1 3 -1"><Coordinate point="{points}"/></IndexedFaceSet></Shape></Transform><Transform USE="a"/>' \
          '<Switch whichChoice="0"><Shape><Extrusion/></Shape></Switch></Scene></X3D>'
    model = '<model unit="inch"><resources><object id="1"><mesh><vertices>' + \
            "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*line.split()) for line in lines) + "</vertices><triangles>" + \
            "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces) + "</triangles></mesh></object></resources>" \
            '<build><item objectid="1" transform="1 0 0 0 1 0 0 0 1 9 9 9"/></build></model>'
    collada = '<COLLADA version="1.4.1"><asset><unit meter="0.01"/></asset><library_geometries><geometry id="g"><mesh><source id="p">' \
              f'<float_array id="a" count="12">{points}</float_array><technique_common><accessor source="#a" count="4" stride="3">' \
              '<param name="X"/><param name="Y"/><param name="Z"/></accessor></technique_common></source><vertices id="v">' \
              '<input semantic="POSITION" source="#p"/></vertices><polygons count="1"><input semantic="VERTEX" source="#v" ' \
              'offset="0"/><ph><p>0 2 1</p><h>0 1 3</h></ph></polygons><trifans count="1"><input semantic="VERTEX" source="#v" ' \
              'offset="0"/><p>0 1 2 3</p></trifans></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">' \
              '<node><skew>30 0 1 0 1 0 0</skew><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes><scene>' \
              '<instance_visual_scene url="#s"/></scene></COLLADA>'
    fbx = 'FBXHeaderExtension: {\n FBXVersion: 7400\n}\nObjects: {\n Geometry: 10, "Geometry::g", "Mesh" {\n  Vertices: *12 {\n   a: ' + \
          points.replace(" ", ",") + '\n  }\n  PolygonVertexIndex: *3 {\n   a: 0,2,-2\n  }\n }\n Model: 20, "Model::m", "Mesh" {\n' \
          '  Properties70: {\n   P: "Show", "bool", "", "",0\n  }\n }\n}\nConnections: {\n C: "OO",20,0\n C: "OO",10,20\n}\n'

    version = b"FBXVersionI" + struct.pack("<i", 7400)
    binary = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<4IB", 7400, 40 + len(version), 1, 5, 10) + version + bytes(13)

    def chunk(kind, data):
        return struct.pack("<HI", kind, 6 + len(data)) + data

    mesh = chunk(0x4110, struct.pack("<H12f", 4, *map(float, points.split())))
    studio = chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, b"part\0" + chunk(0x4010, b"") + chunk(0x4100, mesh))))
    stl = "solid\n" + "".join("facet normal 0 0 0\nouter loop\n" + "".join(
        f"vertex {lines[i]}\n" for i in face) + "endloop\nendfacet\n" for face in faces) + "endsolid\n"
    texts = {
        "obj": (0, "".join(f"v {line}\n" for line in lines) + "".join(
            f"f {a + 1}/1 {b + 1}//2 \\\n{c - 4}\n" for a, b, c in faces)),
        "ply": (1, ply.format("ascii") + "\n".join(lines) + "\n" + rows),
        "ply_binary": (1, ply.format("binary_big_endian").encode() + struct.pack(">12f", *map(float, points.split())) +
                       b"".join(struct.pack(">B3i", 3, *face) for face in faces)),
        "stl": (2, stl),
        "stl_binary": (2, bytes(80) + struct.pack("<I", 4) + b"".join(
            bytes(12) + struct.pack("<9f", *sum(corners[3 * i:3 * i + 3], ())) + bytes(2) for i in range(4))),
        "off": (3, "NOFF 4 4 0\n" + "".join(f"{line} 0 0 1\n" for line in lines) + rows),
        "gltf": (4, json.dumps({**gltf, "buffers": [{"byteLength": 72, "uri": uri}]})),
        "glb": (5, b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks),
        "fbx_braces": (9, "x {\n{ Objects: {\n Geometry: 10, \"g\", \"Mesh\" {\n"),
        "x3d": (6, x3d), "3mf": (7, model), "dae": (8, collada), "fbx": (9, fbx), "fbx_binary": (9, binary), "3ds": (10, studio)}
    return {name: bytes([number]) + (text if isinstance(text, bytes) else text.encode())
            for name, (number, text) in texts.items()}


def envelope(body, text="", **fields):
    message = envelope_pb2.Envelope(protocol_version=1, message_id=1)
    part = getattr(message, body)
    part.SetInParent()
    if text:
        text_format.Parse(text, part)
    for name, value in fields.items():
        if hasattr(value, "CopyFrom"):
            getattr(part, name).CopyFrom(value)
        else:
            setattr(part, name, value)
    return message


def transaction(name):
    return text_format.Parse(SCENES[name], scene_pb2.Transaction())


def pieces(messages):
    return b"".join(struct.pack("<H", len(data)) + data for data in messages)


RECORDED = {
    "plain": "",
    "texture": 'friction { mu_static: 1 mu_dynamic: 0.5 variation: 0.5 field { grain { grain_m: 1e-3 seed: 1 } } } shading { '
               'crease_rad: 1 } texture { law: TEXTURE_LAW_HO1999 amplitude_m: 1e-3 gain_K: 1 field { noise { wavelength_m: '
               '0.01 octaves: 2 persistence: 0.5 seed: 1 } } }',
    "motion": 'motion { mass_kg: 0.1 planes { normal { z: 1 } friction: 0.4 } }',
}


def recorded_tick(number, scene, position):
    return struct.pack("<3Q6B2x2I6d", number, 1000 * number, scene, 2, 0, 0, 1, 0, 0, 0, 0, *position, 0, 0, 0)


def recording(mesh, properties):
    """The parts of a short one: an object comes, is pressed, leaves and is gone."""
    part = recording_pb2.RecordingPart
    head = part(head=text_format.Parse('server: "s" device: "d" rate_hz: 1000 period_s: 1e-3 max_force_N: 3 '
                                       'stable_lateral_N_per_m: 500', recording_pb2.RecordingHead()))
    digest = hashlib.sha256(mesh).digest()
    scenes = [part(scene=recording_pb2.RecordedScene(number=number, revision=number)) for number in (1, 2, 3)]
    put = scenes[0].scene.put.add()
    text_format.Parse('state { id: 1 name: "a" revision: 1 stiffness_N_per_m: 800 damping_Ns_per_m: 0.5 pose { position { x: '
                      '1e-3 } rotation { w: 1 } } color { red: 1 } ' + properties + " } posed_at: 1", put)
    put.state.mesh = digest
    scenes[1].scene.leaving.append(1)
    scenes[2].scene.gone.append(1)
    parts = [head, part(asset=recording_pb2.RecordedAsset(kind=1, hash=digest, data=mesh)), scenes[0]]
    number = 0
    for scene in scenes:
        if scene.scene.number > 1:
            parts.append(scene)
        path = b""
        for i in range(12):
            path += recorded_tick(number, scene.scene.number if i == 0 else 0, (0.05, 0.05, 0.02 * (5 - i)))
            number += 1
        parts.append(part(ticks=recording_pb2.RecordedTicks(ticks=path)))
    return parts


def kept(text, mesh):
    """A record of the state folder's log, whose objects have this mesh."""
    record = text_format.Parse(text, state_pb2.LogRecord())
    for state in [*record.checkpoint.object, *record.checkpoint.lost, *record.edit.commit.put]:
        state.mesh = hashlib.sha256(mesh).digest()
    return record.SerializeToString()


def write(fuzzer, name, data):
    folder = CORPUS / fuzzer
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data)


def main():
    mesh = tetrahedron()
    digest = hashlib.sha256(mesh).digest()
    chunk = envelope_pb2.AssetChunk(hash=digest, kind=1, total_size=len(mesh), data=mesh)
    half = envelope_pb2.AssetChunk(hash=digest, kind=1, total_size=len(mesh), data=mesh[:60])
    rest = envelope_pb2.AssetChunk(hash=digest, kind=1, total_size=len(mesh), offset=60, data=mesh[60:])
    use = text_format.Parse('operations { add { name: "up" mesh { box { size_m { x: 1 y: 1 z: 1 } } } } }',
                            scene_pb2.Transaction())
    use.operations[0].add.mesh.asset = digest
    client = {
        "hello": envelope("hello", 'session: 5 client_name: "seed" token: "t" epoch: 5 revision: 1', root=bytes(32)),
        "asset_request": envelope("asset_request", hash=digest, offset=4),
        "subscribe": envelope("subscribe", "rate_hz: 60 datagrams: true"),
        "heartbeat": envelope("heartbeat", "epoch: 5 revision: 1", root=bytes(32)),
        "clock_probe": envelope("clock_probe", "client_send_ns: 12345"),
        "status_request": envelope("status_request"),
        "upload": envelope("asset_upload", chunk=chunk),
        "upload_half": envelope("asset_upload", chunk=half),
        "upload_rest": envelope("asset_upload", chunk=rest),
        "upload_cancel": envelope("asset_upload", cancel=digest),
        "lead_hand": envelope("lead_hand", lead=True),
        "hand_target": envelope("hand_target", "position { x: 0.1 } normal { z: 1 } press_N: 2 rotation { w: 0.6 x: 0.8 } gripper_rad: 0.4"),
        **{f"edit_{name}": envelope("edit_request", client_seq=1, transaction=transaction(name)) for name in SCENES},
    }
    objects = 'object { id: 1 name: "a" revision: 1 stiffness_N_per_m: 800 damping_Ns_per_m: 0.5 ' \
              'pose { position { x: 1 } rotation { w: 1 } } color { red: 1 } shading { crease_rad: 1 } ' \
              'friction { mu_static: 1 mu_dynamic: 0.5 variation: 1 field { noise { wavelength_m: 1 octaves: 1 } } } ' \
              'texture { law: TEXTURE_LAW_HO1999 amplitude_m: 1e-3 gain_K: 1 field { grain { grain_m: 1 seed: 1 } } } ' \
              'motion { mass_kg: 1 gravity_m_per_s2 { z: -9.81 } planes { normal { z: 1 } friction: 0.5 rolling_m: 1e-4 } } }'
    snapshot = envelope("snapshot_objects", objects)
    snapshot.snapshot_objects.object[0].mesh = digest
    server = {
        "welcome": envelope("welcome", 'epoch: 1001 revision: 1 server_name: "s" servo_rate_hz: 1000 device: "d" '
                            'max_force_N: 3 may_edit: true datagram_port: 7654 datagram_cookie: "0123456789abcdef"',
                            root=bytes(32)),
        "refusal": envelope("refusal", 'field: "f" reason: "r" supported_version: 1'),
        "snapshot_begin": envelope("snapshot_begin", "revision: 1 object_count: 1"),
        "snapshot_objects": snapshot,
        "snapshot_end": envelope("snapshot_end", "revision: 1", root=bytes(32)),
        "asset_chunk": envelope("asset_chunk", hash=digest, kind=1, total_size=len(mesh), data=mesh),
        "asset_unavailable": envelope("asset_unavailable", hash=digest),
        "telemetry": envelope("telemetry", 'tick: 7 time_ns: 99 scene_revision: 1 hip { x: 0.1 } ihip { y: 0.1 } object: 1 '
                              'primitive { kind: PRIMITIVE_KIND_LINE polygon: 3 local_index: 2 } force { written { z: 1 } '
                              'spring { z: 1 } } energy { object: 1 feature: FEATURE_CONTACT energy_J: 1 } '
                              'body { object: 1 pose { position { x: 1 } rotation { w: 1 } } condition: BODY_CONDITION_ASLEEP } '
                              'device_state: DEVICE_STATE_READY'),
        "accepted": envelope("edit_reply", 'client_seq: 1 accepted { revision: 2 report: "r" ' + objects + " }"),
        "conflict": envelope("edit_reply", 'client_seq: 1 conflict { reason: "r" current { id: 1 name: "a" } }'),
        "rejected": envelope("edit_reply", 'client_seq: 1 rejected { field: "f" reason: "r" }'),
        "edit_progress": envelope("edit_progress", "client_seq: 1 stage: STAGE_BUILDING share: 0.5"),
        "edit_live": envelope("edit_live", "client_seq: 1 revision: 2 tick: 9"),
        "commit": envelope("commit", 'revision: 2 removed: 1 put { id: 2 name: "b" revision: 2 }', prev_root=bytes(32),
                           root=bytes(32)),
        "heartbeat": envelope("heartbeat", "epoch: 1001 revision: 1", root=bytes(32)),
        "clock_reply": envelope("clock_reply", "client_send_ns: 1 server_receive_ns: 2 server_send_ns: 3"),
        "status": envelope("status", 'uptime_s: 1 ticks: 5 tick_ns { p50: 1 } device: "d"'),
        "hand_leader": envelope("hand_leader", 'client_name: "c" led: true you: true refused: "r"'),
        "upload_reply": envelope("asset_upload_reply", hash=digest, accepted=True),
    }
    for name, message in client.items():
        write("client_messages", name, b"\0" + pieces([message.SerializeToString()]))
    upload = [client["upload_half"], client["upload_rest"], envelope("edit_request", client_seq=2, transaction=use)]
    for flags, name in ((0, "editor"), (1, "viewer"), (4, "datagrams"), (2, "strangers")):
        row = [client["hello"]] * (flags == 2) + [client["subscribe"], *upload, client["upload_half"],
                                                  client["upload_cancel"], client["edit_pose"]]
        write("client_messages", f"row_of_{name}", bytes([flags]) + pieces(m.SerializeToString() for m in row))
    for name, message in server.items():
        write("server_messages", name, b"\0" + pieces([message.SerializeToString()]))
        write("server_messages", f"{name}_first", b"\2" + pieces([message.SerializeToString()]))
    join = ["welcome", "snapshot_begin", "snapshot_objects", "snapshot_end", "asset_chunk", "telemetry", "commit"]
    write("server_messages", "row", b"\3" + pieces(server[name].SerializeToString() for name in join))

    # What the server says in turn: client_session_fuzz.cpp, Action.
    (hello, resume, scene, new, change, again, assets, chunk, unavailable, beat, sample, bodies, accept, live, put_off, reject,
     clock, status, uploaded, restart, cut, wait, submit, upload, drop, twice, later, damage, other) = range(29)
    stories = {
        "join": [hello, scene, new, assets, new, assets, beat, sample, 1, 0, change, 0, 5, bodies, *range(1, 14), beat],
        "resume": [new, hello, scene, assets, cut, resume, change, 0, 9, assets, restart, cut, hello, scene, new, again, beat],
        "edits": [hello, scene, submit, 1, submit, 2, put_off, 1, 3, wait, 9, accept, 1, 1, live, 1, 1, 5, reject, 2, 1, beat,
                  upload, 9, uploaded, 0, 2, wait, 9, uploaded, 1, 0, status, clock, *range(1, 6)],
        "distorted": [hello, scene, new, drop, new, later, change, 0, 4, twice, change, 0, 7, damage, beat, 1, 2, 3, again,
                      chunk, 0, 1, 9, 3, 0, 9, unavailable, 0, wait, 60, hello, scene, resume, other, 2, 8, 1, beat],
        "torn_asset": [hello, scene, new, 24, 3, 7, 4, 0, 4, 25, 0, 13, 6, 7, 27, 9, 1, 19, 6, 2, 14, 5, 1, 253, 3, 0, 9, 15,
                       0, 8, 0, 21, 60, 0, 2, 1, 9],
        "large_asset": [0, 2, 3, 24, 3, 7, 4, 0, 4, 25, 0, 231, 6, 7, 27, 9, 1, 19, 6, 2, 14, 5, 14, 6, 1, 253, 3, 0,
                        9, 15, 129, 8, 0, 21, 60, 0, 2, 1, 9, 0, 2, 5, 8, 2, 7, 3, 6, 3, 6, 165, 10, 1, 23, 5, 0, 4,
                        0, 5, 11, 1, 2, 3, 4, 5, 6, 7, 8, 9, 3, 11, 12, 13, 9, 0, 2, 22, 1, 22, 2, 21, 9, 12, 1, 1,
                        13, 1, 1, 5, 15, 2, 1, 7, 2, 9, 23, 9, 18, 0, 2, 21, 9, 18, 1, 0, 17, 16, 1, 2, 3, 4, 5],
    }
    for name, story in stories.items():
        write("client_session", name, bytes(story))

    def framed(messages):
        return b"".join(struct.pack("<I", m.ByteSize()) + m.SerializeToString() for m in messages)
    write("framer", "hello", b"\0" + framed([client["hello"]]))
    write("framer", "row", b"\6" + framed(client.values()))
    write("framer", "answers", b"\x1f" + framed(server.values()))
    write("framer", "too_long", b"\0" + struct.pack("<I", 1 << 24) + b"x")
    write("framer", "empty", b"\0" + struct.pack("<I", 0))

    zero, turn = dict(x=0, y=0, z=0), dict(w=1, x=0, y=0, z=0)
    inverse3 = {"device_id": "049D", "state": {"cursor_position": zero, "cursor_velocity": zero, "current_cursor_force": zero},
                "status": {"calibrated": True, "in_use": False, "power_supply": True}}
    write("haply", "state", json.dumps({"session_id": 7, "inverse3": [inverse3]}).encode())
    write("haply", "grips", json.dumps({"inverse3": [inverse3], "verse_grip": [
        {"device_id": "1", "state": {"orientation": turn, "button": True, "hall": 3}}], "wireless_verse_grip": [
        {"device_id": "2", "state": {"orientation": turn, "buttons": {"a": True, "b": False, "c": True}}}]}).encode())

    for name in SCENES:
        write("apply", name, pieces([transaction(name).SerializeToString()]))
        write("scene_text", name, SCENES[name].encode())
    row = ["add", "pose", "material", "per_vertex", "spots", "layers", "dynamic", "stiffness", "remesh", "noise", "take_away",
           "hinge", "motion", "collision", "stop", "softness", "plastic", "residue", "lattice", "rigid", "condition", "remove"]
    named_a = [text_format.Parse(SCENES["add"].replace('"new"', '"a"'), scene_pb2.Transaction()), *map(transaction, row)]
    write("apply", "row", pieces(t.SerializeToString() for t in named_a))
    write("scene_text", "comment", b"# a comment\noperations { remove { object { id: 7 } } }\n")

    cookie = envelope_pb2.Datagram(cookie=b"0123456789abcdef")
    sample = envelope_pb2.Datagram(cookie=cookie.cookie, telemetry=server["telemetry"].telemetry)
    for flags in range(0, 32, 5):
        row = [bytes([flags]) + cookie.SerializeToString(), bytes([1]) + cookie.SerializeToString(),
               bytes([flags | 1]) + sample.SerializeToString()]
        write("datagram", f"row_{flags}", pieces(row))

    # What is published, of the epoch that the fuzzer's server has: audience_fuzz.cpp, Action.
    def published(kind, **fields):
        return kind(protocol_version=1, epoch=1001, **fields).SerializeToString()
    (store_snapshot, store_commit, damage_stored, live_commit, live_sample, honest, asset_chunk) = (bytes([a]) for a in range(7))
    parts = [published(audience_pb2.SnapshotPart, begin=server["snapshot_begin"].snapshot_begin),
             published(audience_pb2.SnapshotPart, objects=server["snapshot_objects"].snapshot_objects),
             published(audience_pb2.SnapshotPart, end=server["snapshot_end"].snapshot_end)]
    commit = published(audience_pb2.PublishedCommit, commit=server["commit"].commit)
    samples = [published(audience_pb2.LiveMessage, telemetry=server["telemetry"].telemetry),
               published(audience_pb2.LiveMessage, heartbeat=envelope_pb2.Heartbeat(epoch=1001, revision=3, root=bytes(32)))]
    live = [honest, *(live_sample + sample for sample in samples), honest, live_commit + commit]
    write("audience", "live", pieces(live))
    write("audience", "stored", pieces([*(store_snapshot + part for part in parts), store_commit + commit, *live]))
    write("audience", "damaged", pieces([damage_stored + bytes(where) for where in ((0, 9, 1), (1, 40, 255), (2, 3, 4))] + live))
    write("audience", "chunk", pieces([asset_chunk + server["asset_chunk"].asset_chunk.SerializeToString()]))

    write("mesh_bytes", "tetrahedron", mesh)
    write("mesh_bytes", "empty", b"HMSH" + struct.pack("<IQQ", 1, 0, 0))
    write("mesh_bytes", "moved", MOVED)
    write("mesh_bytes", "claims_much_moved", b"HMOV" + struct.pack("<IQ", 1, 1 << 60))
    write("mesh_bytes", "claims_much", b"HMSH" + struct.pack("<IQQ", 1, 1 << 60, 1 << 60))
    for name, data in mesh_files().items():
        write("mesh_file", name, data)

    for name, properties in RECORDED.items():
        write("recording", name, pieces([part.SerializeToString() for part in recording(mesh, properties)]))
    with_state = recording(mesh, "")
    with_state.insert(3, recording_pb2.RecordingPart(state=recording_pb2.RecordedState(scene=1, image=bytes(2000))))
    write("recording", "state", pieces([part.SerializeToString() for part in with_state]))

    (a_log, a_copy, a_log_record, a_copy_record, an_asset, unfinished) = (bytes([kind]) for kind in range(6))
    state = ('id: %d name: "%s" revision: %d stiffness_N_per_m: 800 damping_Ns_per_m: 0.5 pose { position {} rotation { w: 1 } } '
             'color { red: 1 }')
    first = a_log_record + kept('checkpoint { epoch: 5 revision: 3 next_object_id: 3 object { %s } session { session: 7 '
                                'forgotten_up_to: 1 result { client_seq: 2 revision: 3 root: "%s" } } }'
                                % (state % (1, "a", 2), "0" * 32), mesh)
    edits = [a_log_record + kept(f"edit {{ session: 7 client_seq: {seq} next_object_id: {seq} commit {{ {what} }} }}", mesh)
             for seq, what in ((3, "put { %s }" % (state % (2, "b", 4))), (4, "removed: 1"))]
    asset = an_asset + mesh
    write("state_folder", "log", pieces([first, *edits, asset]))
    write("state_folder", "copy_only", pieces([a_copy_record + first[1:], asset]))
    write("state_folder", "damaged_head", pieces([a_copy_record + first[1:], a_log + b"haptics state 2", asset]))
    write("state_folder", "torn", pieces([unfinished + b"haptics", a_copy + b"", first, asset]))
    write("state_folder", "lost_asset", pieces([first, *edits]))
    write("state_folder", "had_lost", pieces([a_log_record + kept(
        'checkpoint { epoch: 5 revision: 3 next_object_id: 3 object { %s } lost { %s } }'
        % (state % (1, "a", 2), state % (1, "a", 2)), mesh), asset]))

    write("field_bytes", "ramp", b"HSFD" + struct.pack("<III6f", 1, 2, 3, 0, 0.25, 0.5, -1, 2, 3.5))
    write("field_bytes", "square", b"HSFD" + struct.pack("<III16f", 1, 4, 4, *(i * i % 7 / 7 for i in range(16))))
    write("field_bytes", "claims_much", b"HSFD" + struct.pack("<III", 1, 4096, 4096))

    write("field_bytes", "points", b"HPTF" + struct.pack("<IIf12f", 1, 3, 0.5, 0, 0, 0, 1, 0.25, 0, 0, -1, 0, 0.5, 0, 0.5))
    write("field_bytes", "claims_much_points", b"HPTF" + struct.pack("<IIf", 1, 60000, 1))

    write("image_bytes", "gray_png", png(4, 0, 8, b"\x80"))
    write("image_bytes", "deep_png", png(4, 0, 16, b"\x80\x01"))
    write("image_bytes", "colour_png", png(4, 2, 8, b"\x10\x20\x30"))
    write("image_bytes", "transparent_png", png(4, 6, 8, b"\x10\x20\x30\x40"))
    write("image_bytes", "jpeg", JPEG)
    write("image_bytes", "progressive_jpeg", PROGRESSIVE_JPEG)


if __name__ == "__main__":
    main()
