"""The pages: the front page is short, every link and picture leads somewhere, and so does every path of this repository that
a page names.

usage: pages_test.py [-v]
"""
import json
import re
import subprocess
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
FRONT_PAGE_LINES, FRONT_PAGE_BYTES = 150, 12_000
TOP_LEVEL = "proto|haptic_server|graphics_client|common|tests|deploy"
# Of programs that are not ours.
OTHERS_OPTIONS = {"--benchmark_out", "--array"}
# A build makes them.
GENERATED = ("build/", "out/")
EXPECTED = ["README.md", "haptic_server/README.md", "haptic_server/engine/contact/README.md", "haptic_server/engine/surface/README.md",
            "haptic_server/engine/motion/README.md", "haptic_server/engine/step/README.md", "haptic_server/world/README.md",
            "haptic_server/device/plugin/README.md",
            "graphics_client/README.md", "graphics_client/export/README.md", "graphics_client/ros2/README.md",
            "graphics_client/script/python/haptic_experiment/README.md", "proto/README.md",
            "tests/README.md", "deploy/README.md", "deploy/CHANGELOG.md", ".github/CONTRIBUTING.md"]


def listed(*patterns):
    done = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "--", *patterns], cwd=PROJECT,
                          capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def prose(text):
    """Without what stands in fences, in which neither heading nor link is one."""
    kept, fenced = [], False
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif not fenced:
            kept.append(line)
    return "\n".join(kept)


def links(text):
    """Targets of links and pictures, also where the text before a target goes over a line's end."""
    return re.findall(r"\]\(([^()\s]+)\)", prose(text))


def anchors(text):
    """Of the headings, as GitHub makes them."""
    found = []
    for heading in re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w -]", "", words).strip().replace(" ", "-")
        again = sum(1 for known in found if re.fullmatch(re.escape(anchor) + r"(-\d+)?", known))
        found.append(f"{anchor}-{again}" if again else anchor)
    return set(found)


def broken_links(page, text):
    """Of a page at this path of the repository."""
    broken = []
    for link in links(text):
        if re.match(r"https?://|mailto:", link):
            continue
        path, _, anchor = link.partition("#")
        target = PROJECT / page if not path else (PROJECT / page).parent / path
        if not target.exists() or not target.resolve().is_relative_to(PROJECT):
            broken.append(link)
        elif anchor and (target.suffix != ".md" or anchor not in anchors(text if not path else target.read_text())):
            broken.append(link)
    return broken


def named_paths(text):
    """Paths of this repository in code font: `common/maths/vec.h`, `haptic_server/net/`, `tests/eval/scenes/*.cpp`."""
    found = re.findall(rf"`((?:{TOP_LEVEL})/[\w./*{{}},-]*)", prose(text))
    return [path for path in found if not path.startswith(GENERATED)]


class Pages(unittest.TestCase):
    def pages(self):
        found = listed("*.md")
        self.assertLessEqual(set(EXPECTED), set(found))
        return {page: (PROJECT / page).read_text() for page in found}

    def test_the_front_page_is_short(self):
        front = (PROJECT / "README.md").read_bytes()
        self.assertLessEqual(front.count(b"\n"), FRONT_PAGE_LINES)
        self.assertLessEqual(len(front), FRONT_PAGE_BYTES)

    def test_links_and_pictures_lead_somewhere(self):
        for page, text in self.pages().items():
            with self.subTest(page):
                self.assertEqual(broken_links(page, text), [])

    def test_paths_that_are_named_are_there(self):
        for page, text in self.pages().items():
            with self.subTest(page):
                self.assertEqual([path for path in named_paths(text) if not self.is_there(path)], [])

    def is_there(self, path):
        if "{" in path:
            return True  # a shell's shorthand
        return any(PROJECT.glob(path)) if "*" in path else (PROJECT / path).exists()

    def test_tests_that_are_named_are_registered(self):
        registered = set(re.findall(r"[\w.]+", "".join((PROJECT / path).read_text() for path in listed("tests/*CMakeLists.txt"))))
        registered |= {name.rpartition(".")[2] for name in registered}
        for page, text in self.pages().items():
            with self.subTest(page):
                names = re.findall(r"`(?:EndToEnd|Evaluation|Bench|Tree|Deploy|Contact|Fuzz|Stress|sim)\.(\w+)`", prose(text))
                self.assertEqual([name for name in names if name not in registered], [])

    def test_options_that_are_named_are_taken_by_some_program(self):
        programs = "".join((PROJECT / path).read_text() for path in
                           listed("*.cpp", "*.py", "*.sh", "deploy/run", "deploy/test", "tests/*CMakeLists.txt"))
        known = set(re.findall(r"--[a-z][\w-]*", programs))
        for page, text in self.pages().items():
            with self.subTest(page):
                self.assertEqual(sorted(set(re.findall(r"(?<![\w<-])--[a-z][\w-]*\b(?!-)", text)) - known - OTHERS_OPTIONS), [])

    def test_instructions_are_those_of_the_gate(self):
        figures = json.loads((PROJECT / "tests/bench/instructions_per_tick.json").read_text())
        table = [row for text in self.pages().values() for row in re.findall(r"^\| `(\w+)`: .* \| ([\d,]+) \|$", text, re.MULTILINE)]
        self.assertGreater(len(table), 8)
        for trajectory, number in table:
            self.assertAlmostEqual(float(number.replace(",", "")) / figures[trajectory], 1, delta=0.05, msg=trajectory)

    def test_names_of_the_glossary_are_in_the_code(self):
        glossary = (PROJECT / "haptic_server/README.md").read_text().split("\n## Glossary\n", 1)[1].split("\n## ", 1)[0]
        spans = re.findall(r"`([^`]+)`", "".join(row.rstrip("| ").rpartition("|")[2] for row in glossary.splitlines()))
        named = {word for span in spans for word in re.findall(r"\w+", span)}
        self.assertGreater(len(named), 40)
        paths = listed("*.h", "*.cpp", "*.proto")
        known = set(re.findall(r"\w+", "\n".join([*paths, *((PROJECT / path).read_text() for path in paths)])))
        self.assertEqual(sorted(named - known), [])

    def test_every_page_is_reached_from_the_front_page(self):
        pages = self.pages()
        reached, waiting = set(), ["README.md"]
        while waiting:
            page = waiting.pop()
            if page in reached or page not in pages:
                continue
            reached.add(page)
            folder = (PROJECT / page).parent
            for link in links(pages[page]):
                target = (folder / link.partition("#")[0]).resolve()
                if target.is_relative_to(PROJECT):
                    waiting.append(str(target.relative_to(PROJECT)))
        self.assertEqual(set(pages) - reached, set())

    def test_every_picture_is_shown(self):
        shown = {str(((PROJECT / page).parent / link).resolve().relative_to(PROJECT))
                 for page, text in self.pages().items() for link in links(text) if link.endswith(".png")}
        self.assertEqual(set(listed("deploy/pictures/*.png")) - shown, set())


class Judgement(unittest.TestCase):
    def test_a_link_that_leads_nowhere_is_named(self):
        text = "# A page\n[a](LICENSE) [b](gone.md) ![c](deploy/run) [d](#a-page) [e](#gone) [f](../README.md)\n```\n[g](h)\n```\n"
        self.assertEqual(broken_links("README.md", text), ["gone.md", "#gone", "../README.md"])

    def test_anchors_are_those_of_the_headings(self):
        self.assertEqual(anchors("# The `x` of 1.2, [so](to)!\n## Twice\n## Twice\n```\n# not\n```\n"),
                         {"the-x-of-12-so", "twice", "twice-1"})


if __name__ == "__main__":
    unittest.main()
