"""What programs print of others' words, in messages, files and errors, goes through printable(), which escapes what a terminal
would obey.

usage: printed_words_test.py [-v]
"""
import re
import subprocess
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
FOLDERS = ["haptic_server", "graphics_client", "common", "tests/eval"]
EXAMPLES = "/examples/"  # programs of others, who have only the library
PRINTS = re.compile(r"(?:std::cout\s*<<|std::cerr\s*<<|std::f?printf\()(?:\"(?:[^\"\\]|\\.)*\"|[^;\"])*;")
OTHERS = re.compile(r"error\(\)\.(?:text\(\)|reason)|refusal->text\(\)|(?:error|failure|e)\.what\(\)|linkText"
                    r"|\binfo\.name|facts\.(?:server|device|why)|\breport\.text\(\)|\.(?:hand_leader|device|file)\(\)")


def raw(text):
    """[(line number, statement)]"""
    return [(text.count("\n", 0, found.start()) + 1, " ".join(found.group().split())) for found in PRINTS.finditer(text)
            if len(OTHERS.findall(found.group())) > found.group().count("printable(")]


class PrintedWords(unittest.TestCase):
    def test_what_is_raw_is_found(self):
        for text in ('std::printf("%s; %s", facts.why.c_str(), x);', "std::cerr << \"a: \" << attached.error().text();",
                     "std::fprintf(stderr, \"%s\", error.what());"):
            self.assertEqual(len(raw(text)), 1, text)
        self.assertEqual(raw("std::cout << printable(mesh.error().text()) << object.name;"), [])

    def test_nothing_is_printed_raw(self):
        sources = subprocess.run(["git", "ls-files", *(f"{folder}/*.cpp" for folder in FOLDERS), *(f"{folder}/*.h" for folder in FOLDERS)],
                                 cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split()
        self.assertGreater(len(sources), 100)
        found = [f"{source}:{line}: {statement}" for source in sources if EXAMPLES not in source
                 for line, statement in raw((PROJECT / source).read_text())]
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
