"""usage: haptic_bench_test.py HAPTIC_BENCH: a short run names its figures in JSON."""

import json
import subprocess
import sys
import unittest

BENCH = sys.argv.pop()


class HapticBench(unittest.TestCase):
    def figures(self, pattern):
        run = subprocess.run(
            [BENCH, "--benchmark_filter=" + pattern, "--benchmark_format=json", "--benchmark_min_time=0.001"],
            check=True, capture_output=True, text=True, timeout=100)
        return {figure["name"]: figure for figure in json.loads(run.stdout)["benchmarks"]}

    def test_times_a_tick_on_each_trajectory(self):
        figures = self.figures("contact_tick/hot/.*triangles:1728")
        self.assertEqual(len(figures), 5)
        for figure in figures.values():
            self.assertGreater(figure["real_time"], 0)
            self.assertLessEqual(figure["p50_ns"], figure["p99_ns"])
            self.assertLessEqual(figure["p99_ns"], figure["worst_ns"])

    def test_runs_on_the_trajectory_that_the_name_says(self):
        surfaces = {name.split("/")[2]: figure["surfaces"]
                    for name, figure in self.figures("contact_tick/hot/.*triangles:1728").items()}
        self.assertEqual(surfaces, {
            "rubbing_0.5mm_circle": 1, "slide_48mm_circle": 1, "free_space_52mm_circle": 0,
            "second_body_1mm_above_rubbing_0.5mm_circle": 1, "line_contact_of_two_28mm_circle": 2})

    def test_measures_a_build(self):
        figures = self.figures("build/threads:1/triangles:1728")
        (figure,) = figures.values()
        self.assertGreater(figure["s_per_million_triangles"], 0)
        self.assertGreater(figure["bytes_per_triangle"], 64)
        self.assertLess(figure["bytes_per_triangle"], 110)


if __name__ == "__main__":
    unittest.main()
