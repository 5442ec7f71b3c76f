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


def calls(archive):
    """Names of such functions that it calls, each with the object that does."""
    lines = subprocess.run(["nm", "--undefined-only", archive], capture_output=True, text=True, check=True).stdout
    found, member = [], "?"
    for line in lines.splitlines():
        if line.endswith(":"):
            member = line[:-1]
        name = line.split()[-1] if line.strip() else ""
        if ROUNDING.fullmatch(name.split("@")[0]):
            found.append(f"{archive}({member}): {name}")
    return found


def main():
    found = [call for archive in sys.argv[1:] for call in calls(archive)]
    print("\n".join(found) or "none")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
