"""deploy/merge_summaries.py calls scenes equal only when both processes say the same of the same revision."""
import contextlib
import io
import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "deploy"))
import merge_summaries

LATENCY = {"p50": 1, "p99": 2, "p999": 3, "max": 4}
SERVER = {"ticks": 20000, "missed_ticks": 1, "rate_hz": 1000, "tick_ns": LATENCY, "wake_latency_ns": LATENCY,
          "contact_ticks": 9000, "max_force_N": 2.1, "allocations_in_servo": 0, "scene_revision": 3, "scene_hash": "ab",
          "realtime": {"fifo": True, "memory_locked": True, "pinned": False}}
VIEWER = {"viewer_frames": 900, "client_scene_hash": "ab", "scene_revision": 3, "hashes_equal": True,
          "telemetry_age_ms": {"p50": 2, "p99": 5}}


class MergeSummaries(unittest.TestCase):
    def test_equal_hashes_at_one_revision_are_equal(self):
        merged = merge_summaries.merge(SERVER, VIEWER)
        self.assertTrue(merged["hashes_equal"])
        self.assertEqual((merged["scene_hash"], merged["client_scene_hash"]), ("ab", "ab"))

    def test_the_viewers_own_word_does_not_count(self):
        self.assertFalse(merge_summaries.merge(SERVER, {**VIEWER, "client_scene_hash": "cd"})["hashes_equal"])

    def test_hashes_of_two_revisions_are_not_equal(self):
        self.assertFalse(merge_summaries.merge(SERVER, {**VIEWER, "scene_revision": 2})["hashes_equal"])

    def run_on(self, server, viewer):
        """(what it exits with, summary or None)."""
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder) / name for name in ("server.json", "viewer.json", "summary.json")]
            for file, summary in zip(files, (server, viewer)):
                if summary is not None:
                    file.write_text(json.dumps(summary))
            sys.argv = ["merge_summaries.py", *map(str, files)]
            code = None
            with contextlib.redirect_stdout(io.StringIO()):
                try:
                    merge_summaries.main()
                except SystemExit as end:
                    code = end.code
            return code, json.loads(files[2].read_text()) if files[2].exists() else None

    def test_a_viewer_that_ended_too_early_is_the_reason(self):
        code, merged = self.run_on(SERVER, {**VIEWER, "client_scene_hash": ""})
        self.assertEqual(code, "the viewer ended before it held the whole scene")
        self.assertFalse(merged["hashes_equal"])

    def test_it_writes_every_agreed_key(self):
        code, merged = self.run_on(SERVER, VIEWER)
        self.assertIsNone(code)
        self.assertLessEqual({*SERVER, *VIEWER}, set(merged))

    def test_different_scenes_fail_but_are_written(self):
        code, merged = self.run_on(SERVER, {**VIEWER, "client_scene_hash": "cd"})
        self.assertIn("do not hold the same scene", code)
        self.assertFalse(merged["hashes_equal"])

    def test_a_process_that_left_no_summary_is_named(self):
        code, merged = self.run_on(SERVER, None)
        self.assertIn("the viewer", code)
        self.assertIsNone(merged)

    def test_a_missing_key_is_named(self):
        code, _ = self.run_on({key: SERVER[key] for key in SERVER if key != "contact_ticks"}, VIEWER)
        self.assertIn("contact_ticks", code)


if __name__ == "__main__":
    unittest.main()
