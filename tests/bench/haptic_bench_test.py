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
        output = json.loads(run.stdout)
        self.context = output["context"]
        return {figure["name"]: figure for figure in output["benchmarks"]}

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

    def test_times_each_phase_of_a_tick(self):
        figures = self.figures("(phase/.*|search/hot/.*)triangles:1728")
        self.assertEqual(set(figures), {
            f"{phase}/{trajectory}/triangles:1728"
            for phase in ("phase/poses", "phase/gather", "search/hot", "phase/sign", "phase/force")
            for trajectory in ("rubbing_0.5mm_circle", "slide_48mm_circle")})
        for figure in figures.values():
            self.assertGreater(figure["real_time"], 0)

    def test_puts_the_same_questions_to_peers(self):
        figures = self.figures("peers/.*triangles:1728")
        self.assertEqual(len(figures), 4)
        peers = {"embree": {"embree_point_query", "embree_occluded", "embree_intersect"},
                 "cgal": {"cgal_closest_point"}}
        timed = {key[:-len("_ns")] for figure in figures.values() for key in figure if key.endswith("_ns")}
        for library, ways in peers.items():
            installed = "not installed" not in self.context[library]
            self.assertEqual(ways <= timed, installed, library)
        for figure in figures.values():
            self.assertNotIn("error_message", figure)  # they disagree on the answer
        (slide,) = (figure for name, figure in figures.items() if "slide" in name)
        self.assertGreater(slide["god_object_over_tick"], 1)

    def test_measures_a_build(self):
        figures = self.figures("build/threads:1/triangles:1728")
        (figure,) = figures.values()
        self.assertGreater(figure["s_per_million_triangles"], 0)
        self.assertGreater(figure["bytes_per_triangle"], 64)
        self.assertLessEqual(figure["bytes_per_triangle"], 95)

    def test_compares_threads_of_one_process_with_tcp(self):
        figures = self.figures("protocol/(encode|edit_accepted).*(10k_vertices|idle)")
        self.assertEqual(len(figures), 3)
        for figure in figures.values():
            self.assertGreater(figure["real_time"], 0)
        self.assertGreater(figures["protocol/encode_10k_vertices"]["bytes"], 120_000)

    def test_compares_one_process_with_two(self):
        figures = self.figures("structures/.*triangles:1002252")
        one, two = (figures[f"structures/figure_1{letter}_process{plural}/triangles:1002252/iterations:1/manual_time"]
                    for letter, plural in (("a_one", ""), ("b_two", "es")))
        for figure in (one, two):
            self.assertNotIn("error_message", figure)
            self.assertGreater(figure["ticks"], 4000)
            self.assertGreater(figure["bytes_per_triangle"], 64)
        # A triangle and its half of a vertex are 18 bytes.
        self.assertLess(one["bytes_per_triangle"] + 10, two["bytes_per_triangle"])


if __name__ == "__main__":
    unittest.main()
