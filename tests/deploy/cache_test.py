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

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "all.hxx").write_text('#include "one.h"\n#include "two.h"\n')
        (self.folder / "all.cxx").write_text("")

    def precompile(self, comment="", **numbers):
        for name, number in numbers.items():
            (self.folder / f"{name}.h").write_text(f"#pragma once\nconstexpr int {name} = {number};  // {comment}\n")
        self.compile("-MD", "-MF", "all.d", "-x", "c++-header", "-include", "all.hxx", "-o", "all.hxx.gch", "-c", "all.cxx")

    def use(self, text):
        (self.folder / "uses.cpp").write_text(text)
        self.compile("-include", "all.hxx", "-Winvalid-pch", "-fsyntax-only", "uses.cpp")

    def test_an_edit_is_seen_where_another_one_was_compiled_before(self):
        self.precompile(one=1, two=1)
        self.precompile(two=2)
        (self.folder / "all.hxx.gch").unlink()
        self.precompile(two=1)
        self.precompile(one=2)
        self.use("static_assert(one == 2 && two == 1);\n")

    def test_a_header_with_another_comment_is_the_same_header_to_what_includes_it_again(self):
        self.precompile("first", one=1, two=1)
        (self.folder / "all.hxx.gch").unlink()
        self.precompile("other", one=1)
        self.use('#include "one.h"\nstatic_assert(one == 1);\n')


if __name__ == "__main__":
    unittest.main(verbosity=2)
