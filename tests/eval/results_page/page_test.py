"""The results page is made of the committed figures: whole, small, without anything from elsewhere."""

import json
import re
import sys
import unittest
from html.parser import HTMLParser
from pathlib import Path

sys.dont_write_bytecode = True
HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import measure  # noqa: E402
import page  # noqa: E402

RESULTS = json.loads((HERE / "results.json").read_text())
QUOTED = json.loads((HERE / "quoted.json").read_text())


class Balance(HTMLParser):
    """Every tag that opens is closed, in order."""
    ALONE = {"meta"}

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attributes):
        if tag not in self.ALONE:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, tag


class Page(unittest.TestCase):
    def setUp(self):
        self.text = page.page(RESULTS, QUOTED)

    def test_is_small_whole_and_asks_for_nothing(self):
        self.assertLess(len(self.text.encode()), 2_000_000)
        self.assertIn('name="viewport"', self.text)
        self.assertIsNone(re.search(r"<script|src=|href=|url\(|@import", self.text))
        parser = Balance()
        parser.feed(self.text)
        self.assertEqual(parser.open, [])

    def test_has_every_method_scene_and_version(self):
        self.assertEqual(list(RESULTS["scenes"]), list(measure.scenes()))
        for method in RESULTS["methods"]:
            self.assertIn(f"<td>{method['name']}</td>", self.text)
            self.assertIn(method["version"], self.text)
        self.assertLessEqual({"ours", "bullet", "ode", "mujoco", "vtk_locator"}, {m["name"] for m in RESULTS["methods"]})

    def test_shows_where_ours_fails(self):
        worse = json.loads(json.dumps(RESULTS))
        ours = next(m for m in worse["methods"] if m["name"] == "ours")
        ours["failures"]["S1"] = {"pass": 1, "fail": 2, "fault": 0, "not_applicable": 0}
        self.assertIn('<td>ours</td><td class="fail">2/3</td>', page.page(worse, QUOTED))

    def test_draws_only_what_was_measured(self):
        some = {"scenes": {}, "methods": [
            {"name": "timed", "cold_ns": {"12": 5000}, "accuracy": [
                {"scene": "plane", "triangles": 12, "epsilon_p99_ratio": 2, "tick_p50_ns": 100, "tick_max_ns": 900}]},
            {"name": "untimed", "accuracy": [
                {"scene": "plane", "triangles": 12, "epsilon_p99_ratio": 3, "tick_p50_ns": 0, "tick_max_ns": 0}]}]}
        self.assertEqual(page.points(some["methods"][0]), {12: (2, (100, 5000, 900))})
        self.assertEqual(page.points(some["methods"][1]), {12: (3, (None, None, None))})
        self.assertEqual(page.chart(some).count("<circle"), 3)

    def test_words_of_others_are_escaped(self):
        strange = json.loads(json.dumps(RESULTS))
        strange["methods"][0].update(name="<b>", version="<script>")
        strange["methods"][0]["failures"]["S1"] = {"pass": 0, "fail": 0, "fault": 1, "not_applicable": 0, "why": '"><i>'}
        text = page.page(strange, QUOTED)
        for words in ("<b>", "<script>", "<i>"):
            self.assertNotIn(words, text)

    def test_counts_runs_by_what_became_of_them(self):
        records = [{"scene": "S1", "pass": True}, {"scene": "S1", "pass": False},
                   {"scene": "S1", "pass": False, "fault": "crashed"},
                   {"scene": "S2", "pass": None, "not_applicable": "bodies move"}]
        self.assertEqual(measure.failures(records), {
            "S1": {"pass": 1, "fail": 1, "fault": 1, "not_applicable": 0, "why": "crashed"},
            "S2": {"pass": 0, "fail": 0, "fault": 0, "not_applicable": 1, "why": "bodies move"}})

    def test_cold_ticks_are_those_that_were_measured(self):
        table = "method,triangles,cold_tick_p50_ns\nours,12,6872\nours,192,0\n"
        self.assertEqual(measure.cold_ticks(table), {"12": 6872})


if __name__ == "__main__":
    unittest.main()
