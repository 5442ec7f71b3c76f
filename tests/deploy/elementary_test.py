"""What forces are computed with is the same with every C library: the library of the step calls no mathematical function of it
whose last bit may be another one. common/maths/elementary.h has what is needed.

usage: elementary_test.py ARCHIVE...
"""
import re
import subprocess
import sys

# Those of <math.h> that round; fmod, floor and their like are exact everywhere, and so is sqrt.
ROUNDING = re.compile(
    r"(a?(sin|cos|tan)h?|sincos|atan2|exp|exp2|exp10|expm1|pow|pow10|log|log2|log10|log1p|hypot|cbrt|fma|erfc?|[lt]gamma"
    r"|j[01n]|y[01n])[fl]?")


# Inline functions of OpenMesh that are compiled with its class and that nobody calls.
NOT_OURS = re.compile(r"<_Z(NK?|Thn\d+_NK?)8OpenMesh")


def calls(archive):
    """Names of such functions that it calls, each with the function that does."""
    lines = subprocess.run(["objdump", "-dr", "--no-show-raw-insn", archive], capture_output=True, text=True, check=True).stdout
    found, member, function = set(), "?", "?"
    for line in lines.splitlines():
        words = line.split()
        if "file format" in line:
            member = line.split(":")[0]
        elif line.endswith(">:"):
            function = words[-1]
        elif len(words) == 3 and words[1].startswith("R_") and not NOT_OURS.match(function):
            name = re.split("[-+@]", words[2])[0]
            if ROUNDING.fullmatch(name):
                found.add(f"{archive}({member}): {name} in {function}")
    return sorted(found)


def main():
    found = [call for archive in sys.argv[1:] for call in calls(archive)]
    print("\n".join(found) or "none")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
