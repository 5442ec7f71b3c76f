"""Leaves each entry out of each list of the state's fields (HAPTICS_FIELDS), one after the other: none of it compiles.

usage: fields_left_out.py COMPILER STATE_H SOURCE_FOLDER [FLAG ...]
"""
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

COMPILER, STATE, SOURCES, *FLAGS = sys.argv[1:]
SOURCES = Path(SOURCES)
LIST = re.compile(r"HAPTICS_FIELDS\(([^)]*)\)")


def compiles(*includes):
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(f'#include "{STATE}"\n')
        source.flush()
        done = subprocess.run([COMPILER, "-std=c++20", "-fsyntax-only", *includes, f"-I{SOURCES}", *FLAGS, source.name],
                              capture_output=True, text=True)
        return done.returncode == 0, done.stderr


def headers_of_the_state():
    with tempfile.NamedTemporaryFile("w", suffix=".cpp") as source:
        source.write(f'#include "{STATE}"\n')
        source.flush()
        said = subprocess.run([COMPILER, "-std=c++20", "-MM", f"-I{SOURCES}", *FLAGS, source.name], capture_output=True,
                              text=True, check=True).stdout
    return [Path(word).relative_to(SOURCES) for word in said.split() if word.startswith(f"{SOURCES}/")]


def left_out():
    """(header, entry, header's text without it)."""
    for header in headers_of_the_state():
        text = (SOURCES / header).read_text()
        for found in LIST.finditer(text):
            entries = re.split(r",\s*", found[1])
            if not entries[0].startswith("self.") or header.name in ("fields.h", "surface_properties.h"):
                continue  # the macro's own text; numbers of the scene, not of the state
            for entry in entries:
                rest = ", ".join(other for other in entries if other != entry)
                yield header, entry, text[:found.start()] + f"HAPTICS_FIELDS({rest})" + text[found.end():]


def is_caught(case):
    header, entry, text = case
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / header
        copy.parent.mkdir(parents=True)
        copy.write_text(text)
        compiled, said = compiles(f"-I{folder}")
    if compiled or "every member in the list" not in said:
        how = "compiles" if compiled else f"fails otherwise:\n{said[:2000]}"
        print(f"{header}: {entry} left out {how}", flush=True)
        return False
    return True


def main():
    compiled, said = compiles()
    if not compiled:
        sys.exit(said)
    with ThreadPoolExecutor(2) as pool:
        caught = list(pool.map(is_caught, left_out()))
    print(f"{len(caught)} entries, {caught.count(False)} compile where they are left out")
    sys.exit(not caught or not all(caught))


main()
