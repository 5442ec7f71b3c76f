"""What becomes of the models that Debian's packages carry: of each folder and kind of file how many load, how many are refused
and why, and what an import costs of those with 10,000 triangles or more: seconds of a processor for 100,000 triangles, and the
importer's memory for each triangle. Prints a Markdown table; exits with 1 where a file is refused that REFUSED does not name,
or loads though it does, or one costs more than 2 s for 100,000 triangles; with 77 where none of the packages is installed.

With a FOLDER, which holds a folder for each package, as `dpkg -x PACKAGE.deb FOLDER/PACKAGE` makes it: what becomes of all
models in it. Refusals are printed, to be judged by who reads them, and are no fault, but where the importer ended without one.

usage: mesh_corpora.py MESH_REPORT [FOLDER]
"""

import json
import os
import resource
import subprocess
import sys
import threading
import time
from collections import defaultdict
from pathlib import Path

FOLDERS = {"assimp-testmodels": Path("/usr/share/assimp/models"), "inventor-data": Path("/usr/share/inventor/data")}
ENDINGS = "obj stl ply off iv wrl vrml gltf glb dae zae 3mf 3ds fbx x3d x3dv".split()
COSTLY_TRIANGLES, MOST_S_PER_100K = 10_000, 2

# Whose refusal is right, and a word of its reason.
REFUSED = {
    "OBJ/box_UTF16BE.obj": "UTF-16", "OBJ/number_formats.obj": "3.1+e2", "OBJ/point_cloud.obj": "no face",
    "OBJ/testline.obj": "no face", "OBJ/testpoints.obj": "no face", "OFF/invalid.off": "1 of 4 faces",
    "PLY/issue623.ply": "point cloud", "PLY/points.ply": "point cloud", "PLY/pond.0.ply": "point cloud",
    "invalid/OutOfMemory.off": "more than its length", "invalid/empty.obj": "empty", "invalid/empty.off": "empty",
    "invalid/empty.ply": "empty", "invalid/empty.3ds": "empty", "models/household/teapot.iv": "NURBS",
    "Collada/cameras.dae": "no mesh", "Collada/lights.dae": "no mesh",
    "FBX/transparentTest.fbx": "damaged",
    "glTF/BoxTextured-glTF-Binary/BoxTextured.glb": "version 1",
    "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb": "not finite",
    "glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf": "every triangle", "glTF2/MissingBin/BoxTextured.gltf": "BoxTextured0.bin",
    "glTF2/RecursiveNodes/RecursiveNodes.gltf": "no meshes", "glTF2/SchemaFailures/sceneWrongType.gltf": "scene",
    "glTF2/wrongTypes/badArray.gltf": "it is a list",
    "glTF2/TestNoRootNode/NoScene.gltf": "no meshes", "glTF2/TestNoRootNode/SceneWithoutNodes.gltf": "no meshes",
} | {f"glTF2/glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_{n:02}.gltf": "holds no face"
     for n in (0, 1, 2, 3, 7, 8, 9, 10)}


def imported(program, file):
    """Its record, seconds of a processor and the importer's largest memory in bytes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    report = subprocess.Popen([program, "--json", file], stdout=subprocess.PIPE)
    most = [0]

    def watch():
        while report.poll() is None:
            try:
                for child in Path(f"/proc/{report.pid}/task/{report.pid}/children").read_text().split():
                    for line in Path(f"/proc/{child}/status").read_text().splitlines():
                        if line.startswith("VmHWM"):
                            most[0] = max(most[0], 1024 * int(line.split()[1]))
            except OSError:
                pass
            time.sleep(0.005)

    watcher = threading.Thread(target=watch)
    watcher.start()
    record = json.loads(report.communicate()[0])[0]
    watcher.join()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return record, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, most[0]


def ending(file):
    return file.name.lower().removesuffix(".gz").rpartition(".")[2]


def files_below(folder):
    found = (Path(where) / name for where, _, names in os.walk(folder) for name in names)
    return sorted(f for f in found if ending(f) in ENDINGS and not f.name.startswith("aneurysm"))


def is_wrong(inside, record, is_listed):
    if not is_listed:
        return not record["loaded"] and "ends on it" in record["reason"]
    return record["loaded"] == (inside in REFUSED) or (not record["loaded"] and REFUSED[inside] not in record["reason"])


def main():
    is_listed = len(sys.argv) < 3
    packages = FOLDERS if is_listed else {folder.name: folder for folder in Path(sys.argv[2]).iterdir()}
    folders = {name: folder for name, folder in packages.items() if folder.is_dir()}
    if not folders:
        sys.exit(77)
    faults = []
    rows = defaultdict(lambda: {"files": 0, "refused": 0, "triangles": 0, "s": [], "bytes": []})
    for name, folder in folders.items():
        for file in files_below(folder):
            inside = str(file.relative_to(folder))
            record, cpu_s, memory = imported(sys.argv[1], str(file))
            row = rows[name, ending(file)]
            row["files"] += 1
            if is_wrong(inside, record, is_listed):
                faults.append(f"{inside}: {record.get('reason', 'loads')}")
            if not record["loaded"]:
                if not is_listed:
                    print(f"{name}/{inside}: {record['reason']}", file=sys.stderr)
                row["refused"] += 1
                continue
            triangles = record["triangles_in_file"]
            row["triangles"] += triangles
            if triangles >= COSTLY_TRIANGLES:
                row["s"].append(1e5 * cpu_s / triangles)
                row["bytes"].append(memory / triangles)
                if row["s"][-1] > MOST_S_PER_100K:
                    faults.append(f"{inside}: {row['s'][-1]:.2f} s for 100,000 triangles")
    print("| package | format | files | refused | triangles | most s per 100,000 | most bytes per triangle |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")
    for (name, kind), row in sorted(rows.items()):
        cost = f"{max(row['s']):.2f} | {max(row['bytes']):.0f}" if row["s"] else " | "
        print(f"| {name} | {kind} | {row['files']} | {row['refused']} | {row['triangles']} | {cost} |")
    for fault in faults:
        print(fault, file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
