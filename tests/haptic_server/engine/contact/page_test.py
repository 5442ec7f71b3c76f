"""haptic_server/engine/contact/README.md says what the code does: links lead somewhere, every correction is on the page with its
switch, ablation and picture, and its figures are those of the code.

usage: page_test.py [-v]
"""

import re
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[4]
FOLDER = PROJECT / "haptic_server/engine/contact"
PICTURES = PROJECT / "deploy/pictures/contact"
PAGE = (FOLDER / "README.md").read_text()
EVAL = PROJECT / "tests/eval"
LARGEST_PICTURE = 60_000
# Of the force that a texture makes, not of the contact.
NOT_OF_CONTACT = {"ours_without_gain_clamp", "ours_without_closed_gaps"}  # of the second the page has no picture


def text(path):
    return (PROJECT / path).read_text()


def anchor(heading):
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def rows():
    """number -> (correction, switches, ablation, scenes) of the table of corrections."""
    found = re.findall(r"^\| (\d+) \| ([^|]+) \| ([^|]+) \| `(ours\w+)` \| ([^|]+) \|$", PAGE, re.M)
    return {int(n): (name, re.findall(r"`(\w+)`", switches), ablation, scenes) for n, name, switches, ablation, scenes in found}


def sections():
    """number -> text of the section of that correction."""
    parts = re.split(r"^### 2\.(\d+) .*$", PAGE.split("\n## 3.")[0], flags=re.M)
    return {int(n): body for n, body in zip(parts[1::2], parts[2::2])}


def constants():
    """name -> text of the value, of all constants of the contact core."""
    code = "".join(path.read_text() for path in sorted(FOLDER.rglob("*.h")))
    return dict(re.findall(r"constexpr (?:int|double|std::size_t) (k\w+) = ([^;]+);", code))


class Page(unittest.TestCase):
    def test_links_lead_somewhere(self):
        anchors = {anchor(heading) for heading in re.findall(r"^#+ (.*)$", PAGE, re.M)}
        links = re.findall(r"\]\(([^)]+)\)", PAGE)
        self.assertGreater(len(links), 50)
        for link in links:
            if link.startswith("#"):
                self.assertIn(link[1:], anchors)
            else:
                self.assertTrue((FOLDER / link).is_file(), link)

    def test_every_switch_is_on_the_page_and_every_one_there_is_a_switch(self):
        header = text("haptic_server/engine/contact/corrections.h").split("struct Corrections", 1)[1]
        switches = set(re.findall(r"^  bool (\w+) = true;|^  \w+ (\w+) = nullptr;", header, re.M))
        switches = {on or instead for on, instead in switches}
        self.assertGreater(len(switches), 10)
        named = [switch for _, on_row, _, _ in rows().values() for switch in on_row]
        self.assertEqual(sorted(named), sorted(switches))

    def test_every_ablation_is_on_the_page_and_every_one_there_is_an_ablation(self):
        off = set(re.findall(r"^inline constexpr Corrections (k\w+)\{", text("tests/eval/corrections_off.h"), re.M))
        entries = re.findall(r'Method\{(?:\.name = )?"(\w+)",\s*(?:\.about = )?"[^"]*",\s*(?:\.make = )?oursUnder<(\w+)>', text("tests/eval/methods.cpp"))
        ablations = {name for name, _ in entries} - NOT_OF_CONTACT
        self.assertEqual({corrections for _, corrections in entries}, off)
        self.assertEqual({ablation for _, _, ablation, _ in rows().values()}, ablations)
        drawn = re.findall(r'Illustration\{\s*"(\w+)"', text("tests/eval/correction_figures/correction_figures.cpp"))
        self.assertEqual(set(drawn), ablations)
        named = set(re.findall(r"\b(ours_\w*[a-z])\b", PAGE)) - NOT_OF_CONTACT
        self.assertEqual(named, ablations)

    def test_each_correction_has_its_code_scene_ablation_and_picture(self):
        self.assertEqual(list(rows()), list(range(1, len(rows()) + 1)))
        self.assertEqual(list(sections()), list(rows()))
        for number, (name, _, ablation, scenes) in rows().items():
            with self.subTest(f"{number}: {name}"):
                body = sections()[number]
                for part in ("**Breaks.**", "**Correction.**", "**Code.**", "**Scene.**", "**Ablation.**"):
                    self.assertIn(part, body)
                flat = " ".join(body.split())
                self.assertIn(f"haptic_eval failures --method {ablation}`", flat)
                self.assertRegex(flat.split("**Code.**")[1].split("**Scene.**")[0], r"\]\(")
                scene = re.match(r" (S\d+)", flat.split("**Scene.**")[1])[1]
                self.assertIn(scene, scenes.replace(",", " ").split())
                picture = ablation.removeprefix("ours_without_").removeprefix("ours_")
                self.assertIn(f"](../../../deploy/pictures/contact/{picture}.png)", body)

    def test_pictures_are_small_and_all_on_the_page(self):
        pictures = sorted(PICTURES.iterdir())
        self.assertTrue(pictures)
        for picture in pictures:
            self.assertIn(f"(../../../deploy/pictures/contact/{picture.name})", PAGE)
            self.assertLessEqual(picture.stat().st_size, LARGEST_PICTURE, picture.name)

    def test_each_ablation_fails_where_the_page_says(self):
        expected = re.findall(r'Expectation\{"(\w+)", "([^"]*)", "([^"]*)"\}', text("tests/eval/expected_failures.h"))
        expected = {name: (fails.split(), either.split()) for name, fails, either in expected}
        for name, _, ablation, scenes in rows().values():
            named = re.findall(r"[SP]\d+", scenes)
            fails, either = expected[ablation]
            self.assertLessEqual(set(fails), set(named), name)
            self.assertLessEqual(set(named), set(fails) | set(either), name)

    def test_names_of_the_code_are_in_the_code(self):
        code = "".join(path.read_text() for folder in ("contact", "geometry")
                       for path in sorted((PROJECT / "haptic_server/engine" / folder).rglob("*")) if path.suffix in (".h", ".cpp"))
        known = set(re.findall(r"\w+", code)) | {"kHz"}
        named = re.findall(r"\bk[A-Z]\w+", PAGE) + re.findall(r"`(?:\w+::)?(\w+)\(\)", PAGE)
        self.assertEqual([name for name in named if name not in known], [])

    def test_tests_that_are_named_are_tests(self):
        tests = "".join(path.read_text() for path in sorted((PROJECT / "tests/haptic_server").rglob("*.cpp")))
        for name in re.findall(r"`([A-Z][a-z]+(?:[A-Z][a-z]*){3,})`", PAGE):
            self.assertIn(f", {name})", tests)

    def test_tolerances_are_those_of_the_code(self):
        values = {name: float.fromhex(value) if value.startswith("0x") else value for name, value in constants().items()}
        skin = values["kSkin"]
        table = re.findall(r"^    2\^(-\d+) +\S+ +\S+ +\|[-=].*?\b(k[A-Z]\w+)", PAGE, re.M)
        self.assertEqual(len(table), 9)
        for exponent, name in table:
            value = float(values[name])
            inSkins = name not in ("kSkin", "kStartOffset", "kPathOffset")
            self.assertEqual(value * skin if inSkins else value, 2.0 ** int(exponent), name)

    def test_bounds_are_those_of_the_code(self):
        bounds = re.findall(r"\| ([\d,]+), `(?:\w+::)?(k\w+)` \|", PAGE)
        self.assertGreater(len(bounds), 5)
        for number, name in bounds:
            self.assertEqual(int(number.replace(",", "")), int(constants()[name]), name)


if __name__ == "__main__":
    unittest.main()
