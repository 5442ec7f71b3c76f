"""No private word of tests/private_words.txt has come back.

usage: private_words_test.py [-v]
"""
import re
import subprocess
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
LIST = PROJECT / "tests/private_words.txt"
SOURCES = ["*.h", "*.cpp", "*.py", "*.proto", "*.js", "*.cmake", "CMakeLists.txt"]
PRODUCT = ["haptic_server", "graphics_client", "common", "proto", "deploy"]


def sections(text):
    """{section: {word: what to say instead}}"""
    found, current = {}, None
    for line in text.splitlines():
        if line.startswith("[") and line.endswith("]"):
            current = found[line[1:-1]] = {}
        elif line.strip() and not line.startswith("#"):
            word, bar, instead = line.partition("|")
            if not bar or not instead.strip() or current is None:
                raise ValueError(f"{line!r} should be: word | what to say instead")
            current[word.strip()] = instead.strip()
    return found


def expression(word):
    """A * stands for any letters, digits and underscores."""
    return re.escape(word).replace(r"\*", r"\w*")


def uses(words, text):
    """[(line number, word of the list)]"""
    if not words:
        return []
    any_of = re.compile(r"(?<!\w)(" + "|".join(map(expression, words)) + r")(?!\w)")
    return [(text.count("\n", 0, match.start()) + 1,
             match[1] if match[1] in words else next(w for w in words if re.fullmatch(expression(w), match[1])))
            for match in any_of.finditer(text)]


def listed():
    done = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=PROJECT, capture_output=True, text=True,
                          check=True)
    return [Path(name) for name in done.stdout.split("\0") if name and (PROJECT / name).is_file()]


def is_product(path):
    return path.parts[0] in PRODUCT and any(path.match(pattern) for pattern in SOURCES)


class PrivateWords(unittest.TestCase):
    def test_none_has_come_back(self):
        gone = sections(LIST.read_text())
        self.assertEqual(set(gone), {"sources and pages", "pages"})
        everywhere, on_pages = gone["sources and pages"], gone["sources and pages"] | gone["pages"]
        back, looked_at = [], 0
        for path in listed():
            page = path.suffix == ".md"
            if not page and not is_product(path):
                continue
            looked_at += 1
            text = (PROJECT / path).read_text()
            back += [f"{path}:{line}: {word}: say {on_pages[word]}"
                     for line, word in uses(on_pages if page else everywhere, text)]
        self.assertEqual(back, [])
        self.assertGreater(looked_at, 400)

    def test_a_word_is_found_whole_and_with_its_line(self):
        self.assertEqual(uses({"overFrom": "", "so many": ""}, "a\noverFrom(x), overFromHere\nso many."),
                         [(2, "overFrom"), (3, "so many")])

    def test_a_star_stands_for_the_rest_of_a_word(self):
        self.assertEqual(uses({"kMost*": ""}, "kMost, kMost_N\nkMostTriangles almost akMost"),
                         [(1, "kMost*"), (1, "kMost*"), (2, "kMost*")])

    def test_a_line_without_a_better_word_is_refused(self):
        for text in ("[a]\nword\n", "[a]\nword |\n", "word | better\n"):
            with self.assertRaises(ValueError):
                sections(text)


if __name__ == "__main__":
    unittest.main()
