"""with_cache never takes a precompiled header that was made of other headers."""
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

WITH_CACHE = Path(__file__).resolve().parents[2] / "deploy/with_cache"


@unittest.skipUnless(shutil.which("ccache"), "no ccache")
class Cache(unittest.TestCase):
    def compile(self, *arguments, **options):
        return subprocess.run([WITH_CACHE, "ccache", "c++", *arguments], cwd=self.folder, check=True, **options,
                              env={**os.environ, "CCACHE_DIR": str(self.folder / "cache")})

    def precompile(self, **numbers):
        for name, number in numbers.items():
            (self.folder / f"{name}.h").write_text(f"constexpr int {name} = {number};\n")
        self.compile("-x", "c++-header", "-include", "all.hxx", "-o", "all.hxx.gch", "-c", "all.cxx")

    def test_an_edit_is_seen_where_another_one_was_compiled_before(self):
        with tempfile.TemporaryDirectory() as folder:
            self.folder = Path(folder)
            (self.folder / "all.hxx").write_text('#include "one.h"\n#include "two.h"\n')
            (self.folder / "all.cxx").write_text("")
            (self.folder / "uses.cpp").write_text("static_assert(one == 2 && two == 1);\n")
            self.precompile(one=1, two=1)
            self.precompile(two=2)
            (self.folder / "all.hxx.gch").unlink()
            self.precompile(two=1)
            self.precompile(one=2)
            self.compile("-include", "all.hxx", "-Winvalid-pch", "-fsyntax-only", "uses.cpp")


if __name__ == "__main__":
    unittest.main(verbosity=2)
