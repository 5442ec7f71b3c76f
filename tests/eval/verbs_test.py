"""Runs verbs of haptic_eval, small, and checks what they wrote."""

import base64
import contextlib
import csv
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

PROGRAM = sys.argv.pop(1)
HERE = Path(__file__).parent


SCENES = [f"S{i}" for i in range(1, 41)] + [f"P{i}" for i in range(1, 10)]

# The program has to find a display itself.
WITHOUT_DISPLAY = {name: value for name, value in os.environ.items() if name != "DISPLAY"}


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, env=WITHOUT_DISPLAY)


class Verb(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = Path(folder.name) / "made"

    def run_well(self, *arguments):
        done = run(*arguments, "--out", str(self.out))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def records(self, verb):
        return json.loads((self.out / f"{verb}.json").read_text())

    def check_pictures(self, verb):
        self.assertEqual((self.out / f"{verb}.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater((self.out / f"{verb}.png").stat().st_size, 20_000)
        self.assertIn("</svg>", (self.out / f"{verb}.svg").read_text()[-20:])


class Sweeps(Verb):
    """A verb whose parts are run apart comes to the same, byte for byte."""
    SWEEP = "failures", "--method", "ours_without_guard", "--scene", "S7", "--seeds", "12"

    def start(self, *command, **options):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def start_nats(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.start("nats-server", "-a", "127.0.0.1", "-p", str(port), "-js", "-sd", str(self.out.parent / "nats"))
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
                return f"nats://127.0.0.1:{port}"
            time.sleep(0.05)
        self.fail("nats-server does not start")

    @staticmethod
    def catches_interrupts(process):
        caught = re.search(r"SigCgt:\s*(\w+)", Path(f"/proc/{process.pid}/status").read_text())
        return int(caught[1], 16) >> (signal.SIGINT - 1) & 1 or process.poll() is not None

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            done = run(*cls.SWEEP, "--out", folder)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)
            cls.whole = (Path(folder) / "failures.json").read_bytes()

    def test_shards_come_to_the_same(self):
        shards = [self.out / f"failures.shard-{i}-of-3.json" for i in (1, 2, 3)]
        for i in (3, 1, 2):
            self.run_well(*self.SWEEP, "--shard", f"{i}/3")
        merged = self.out / "merged"
        done = run("merge", *map(str, shards[::-1]), "--out", str(merged))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual((merged / "failures.json").read_bytes(), self.whole)
        other = self.out / "other"
        self.assertEqual(run(*self.SWEEP, "--seed", "2", "--shard", "2/3", "--out", str(other)).returncode, 0)
        damaged = self.out / "damaged.json"
        damaged.write_bytes(shards[0].read_bytes()[:-100])
        strange = self.out / "strange.json"
        strange.write_text(shards[0].read_text().replace('"build": "', '"build": "0'))
        for files, reason in ((shards[:2], "of 3 shards these are missing: 3"), ([shards[0]] * 2, "is there twice"),
                              ([shards[0], other / shards[1].name], "is of the sweep .*--seed 2"),
                              ([damaged], "damaged.json: is no shard"), ([strange], "is of build"),
                              ([self.out / "absent.json"], "absent.json: cannot be read")):
            refused = run("merge", *map(str, files), "--out", str(merged))
            self.assertEqual(refused.returncode, 1)
            self.assertRegex(refused.stderr, reason)
        for text in ("0/3", "4/3", "1", "a/b", "1/3x"):
            self.assertIn("the I-th of N", run(*self.SWEEP, "--shard", text).stderr)

    def test_workers_come_to_the_same_when_some_are_killed_and_one_comes_late(self):
        url = self.start_nats()
        out = self.out / "over_nats"
        sweep = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(out))
        workers = [self.start(PROGRAM, "worker", "--nats", url) for _ in range(3)]
        time.sleep(0.4)
        for worker in workers[:2]:
            worker.kill()
        self.assertEqual(sweep.wait(120), 0, sweep.stdout.read())
        self.assertEqual((out / "failures.json").read_bytes(), self.whole)
        workers[2].send_signal(signal.SIGINT)
        self.assertEqual(workers[2].wait(20), 0)
        self.assertRegex(workers[2].stdout.read(), r"[1-9]\d* parts done")

    def test_an_interrupted_sweep_goes_on_where_it_was(self):
        url = self.start_nats()
        first = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(self.out))
        worker = self.start(PROGRAM, "worker", "--nats", url)
        while not self.catches_interrupts(first):
            time.sleep(0.01)
        time.sleep(0.5)
        first.send_signal(signal.SIGINT)
        first.wait(20)
        said = first.stdout.read()
        if first.returncode != 0:
            self.assertIn("interrupted", said)
        again = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(self.out))
        self.assertEqual(again.wait(120), 0)
        self.assertEqual((self.out / "failures.json").read_bytes(), self.whole)
        worker.kill()

    def test_a_worker_ends_soon_also_within_a_part(self):
        url = self.start_nats()
        sweep = self.start(PROGRAM, "failures", "--seeds", "1000", "--nats", url, "--out", str(self.out))
        worker = self.start(PROGRAM, "worker", "--nats", url)
        while not any(of["num_ack_pending"] for of in self.ask(url, "$JS.API.CONSUMER.LIST.HAPTIC_EVAL_PARTS").get("consumers") or []):
            time.sleep(0.05)
        begin = time.monotonic()
        worker.send_signal(signal.SIGTERM)
        worker.wait(20)
        self.assertLess(time.monotonic() - begin, 2)
        sweep.kill()

    def test_a_result_waits_while_the_store_is_full(self):
        url = self.start_nats()
        sweep = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(self.out))
        while "config" not in (results := self.ask(url, "$JS.API.STREAM.INFO.HAPTIC_EVAL_RESULTS")):
            time.sleep(0.05)

        def allow(max_bytes):
            self.ask(url, "$JS.API.STREAM.UPDATE.HAPTIC_EVAL_RESULTS",
                     json.dumps({**results["config"], "discard": "new", "max_bytes": max_bytes}))
        allow(1)
        worker = self.start(PROGRAM, "worker", "--nats", url)
        while "a result was not stored" not in (line := worker.stdout.readline()):
            self.assertTrue(line, "the worker has ended")
        self.assertIsNone(sweep.poll())
        allow(-1)
        self.assertEqual(sweep.wait(60), 0)
        self.assertEqual((self.out / "failures.json").read_bytes(), self.whole)

    def test_a_part_that_cannot_be_run_is_named_after_three_tries(self):
        url = self.start_nats()
        model = self.out.parent / "models/libcgal-demo/data/meshes/armadillo.off"
        model.parent.mkdir(parents=True)
        model.write_text("OFF\n1 1 0\n0 0 0\n3 0 1 9\n")
        self.start(PROGRAM, "worker", "--nats", url)
        sweep = self.start(PROGRAM, "walk", "--models", str(self.out.parent / "models"), "--scene", "armadillo", "--ticks", "9",
                           "--nats", url, "--out", str(self.out))
        self.assertEqual(sweep.wait(60), 1)
        self.assertRegex(sweep.stdout.read(), "part 0 of 1 was tried 3 times: .*armadillo.off")

    def test_a_worker_of_another_build_is_refused(self):
        url = self.start_nats()
        other = self.out.parent / "haptic_eval"
        other.write_bytes(Path(PROGRAM).read_bytes() + b"another")
        other.chmod(0o755)
        sweep = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(self.out))
        worker = self.start(other, "worker", "--nats", url)
        self.assertEqual(worker.wait(30), 1)
        self.assertRegex(worker.stdout.read(), "refused, for this is build [0-9a-f]{16}: failures is run by build")
        sweep.send_signal(signal.SIGINT)
        self.assertEqual(sweep.wait(20), 1)
        self.assertIn("a worker of another build is refused", sweep.stdout.read())

    def test_what_no_program_of_the_build_has_sent_is_thrown_away(self):
        url = self.start_nats()
        sweep = self.start(PROGRAM, *self.SWEEP, "--nats", url, "--out", str(self.out))
        found = {}
        while not found:
            found = self.ask(url, "$JS.API.STREAM.MSG.GET.HAPTIC_EVAL_PARTS", '{"seq":1}').get("message", {})
            time.sleep(0.1)
        subject, job = found["subject"], json.loads(base64.b64decode(found["data"]))
        forged = [(f"haptic_eval.results.{job['sweep']}", {"part": part, "sweep": job["sweep"], "build": job["build"], "result": result})
                  for part in range(3) for result in ([], {"record": 3}, None)]
        beside = subject.rsplit(".", 1)[0] + ".x"  # for the same workers
        forged += [(beside, job), (beside, {**job, "part": 2**63}), (beside, {**job, "sweep": "a b"}), (beside, "[" * 500_000)]
        for where, what in forged:
            text = what if isinstance(what, str) else json.dumps(what)
            self.nats_lines(url, f"PUB {where} {len(text)}\r\n{text}\r\n", b"PONG")
        worker = self.start(PROGRAM, "worker", "--nats", url)
        self.assertEqual(sweep.wait(120), 0)
        self.assertEqual((self.out / "failures.json").read_bytes(), self.whole)
        self.assertIn("a result that no worker of this build has sent is not taken", sweep.stdout.read())
        while self.ask(url, "$JS.API.STREAM.INFO.HAPTIC_EVAL_PARTS")["state"]["messages"]:
            time.sleep(0.1)
        worker.send_signal(signal.SIGTERM)
        self.assertEqual(worker.wait(20), 0)
        self.assertEqual(worker.stdout.read().count("it is thrown away"), 4)

    @staticmethod
    def nats_lines(url, text, until):
        """What the server at the address says to this text, until a line begins so."""
        with socket.create_connection(url.removeprefix("nats://").split(":"), 10) as connection, connection.makefile("rb") as lines:
            connection.sendall(f'CONNECT {{"verbose":false,"headers":true}}\r\n{text}PING\r\n'.encode())
            said = []
            while not said or not said[-1].startswith(until):
                said.append(lines.readline())
            return said

    def ask(self, url, subject, text=""):
        """What JetStream answers."""
        said = self.nats_lines(url, f"SUB inbox 1\r\nPUB {subject} inbox {len(text)}\r\n{text}\r\n", b"{")
        return json.loads(said[-1])

    def test_says_that_nobody_is_there(self):
        refused = run("worker", "--nats", "nats://127.0.0.1:1")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("no connection to nats://127.0.0.1:1", refused.stderr)


class Worst(Verb):
    def test_finds_ticks_that_an_allowance_bounds(self):
        fast = "--rate", "10000"  # a tick has a tenth of the allowance then: it is spent, and counted soon
        for seconds in (2, 10, 50):  # the clock of a busy machine leaves a hunt few plays
            said = self.run_well("worst", "--seconds", str(seconds), "--family", "soup", *fast)
            self.assertIn("within", said)
            record, = self.records("worst")
            if record["allowance_spent_ticks"] > 0:
                break
        self.assertEqual((record["family"], record["rate_Hz"], record["bounded"]), ("soup", 10000, True))
        self.assertGreater(record["plays"], 3)
        self.assertGreater(record["allowance_spent_ticks"], 0)
        self.assertGreater(record["instructions"], 1000)
        self.check_pictures("worst")
        again = run("worst", "--kept", str(self.out / "worst.json"), *fast, "--out", str(self.out / "again"))
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        kept, = json.loads((self.out / "again" / "worst.json").read_text())
        self.assertEqual(kept["motion_genes"], record["motion_genes"])

    def test_finds_imports_that_end(self):
        said = self.run_well("worst", "--import", "--seconds", "2", "--family", "slivers")
        self.assertIn("within", said)
        record, = self.records("worst_import")
        self.assertEqual(record["family"], "slivers")
        self.assertGreater(record["files"], 3)
        self.assertEqual(len(record["triangles"]), 4)
        self.assertLess(record["exponent"], 1.2)
        self.check_pictures("worst_import")
        again = run("worst", "--import", "--kept", str(self.out / "worst_import.json"), "--out", str(self.out / "again"))
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        kept, = json.loads((self.out / "again" / "worst_import.json").read_text())
        self.assertEqual((kept["genes"], kept["report"]), (record["genes"], record["report"]))

    def test_names_a_family_that_is_not_there(self):
        done = run("worst", "--family", "lawn", "--out", str(self.out))
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no family lawn", done.stderr)
        self.assertIn("needles", done.stderr)


class Combinations(Verb):
    def test_measures_the_pair_that_was_asked_for(self):
        said = self.run_well("combinations", "--pair", "texture-softness", "--seeds", "2")
        self.assertIn("1 pairs, 1 within", said)
        records = self.records("combinations")
        self.assertEqual([(r["scene"], r["seed"]) for r in records], [("texture-softness", 1), ("texture-softness", 2)])
        rows = list(csv.DictReader((self.out / "combinations.csv").open()))
        height = next(row for row in rows if row["measure"] == "height_ratio")
        self.assertEqual(float(height["worst"]), float(f"{max(r['height_ratio'] for r in records):.6g}"))
        self.assertEqual(height["verdict"], "within")
        self.assertEqual((self.out / "combinations.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_the_same_seed_gives_the_same(self):
        def records():
            self.run_well("combinations", "--pair", "friction-motion", "--seed", "7")
            return self.records("combinations")

        self.assertEqual(records(), records())

    def test_an_ablation_fails_its_pairs_and_is_about_no_other(self):
        said = self.run_well("combinations", "--ablate", "facets", "--pair", "shading-softness")
        self.assertIn("1 pairs, 1 fail by it", said)
        for arguments, says in ((("--ablate", "facets", "--pair", "texture-motion"), "there are shading-softness"),
                                (("--pair", "softness-texture"), "there is no pair softness-texture"),
                                (("--ablate", "everything"), "facets")):
            done = run("combinations", *arguments, "--out", str(self.out))
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(says, done.stderr)


class Fuzz(Verb):
    def check_flat(self, records):
        for record in records:
            for key, value in record.items():
                self.assertIsInstance(value, (bool, int, float, str), key)

    def test_counts_every_tick_of_the_kinds_that_were_asked_for(self):
        run("fuzz", "contact", "--scenes", "6", "--moving", "no", "--world", "wild", "--out", str(self.out))
        kinds = [r for r in self.records("fuzz") if "ticks" in r]
        self.check_flat(self.records("fuzz"))
        self.assertEqual(sorted((r["scene"], r["ticks"]) for r in kinds),
                         [("rest_1_m_per_s", 6000), ("rest_4_m_per_s", 6000)])
        for record in kinds:
            self.assertGreater(record["contact_ticks"], 0)
            self.assertGreater(record["tick_max_ns"], 0)

    def test_takes_all_worlds_by_turns(self):
        run("fuzz", "contact", "--scenes", "20", "--out", str(self.out))
        kinds = [r["scene"] for r in self.records("fuzz") if "ticks" in r]
        self.assertEqual(sorted(kinds),
                         sorted(f"{world}{motion}_{speed}_m_per_s" for motion in ("rest", "moving") for speed in (1, 4)
                                for world in ("", "flush_", "cracked_", "mirrored_", "thin_")))

    def test_counts_edits_by_kind(self):
        run("fuzz", "edits", "--scenes", "3", "--out", str(self.out))
        self.check_flat(self.records("fuzz"))
        tallies = [r for r in self.records("fuzz") if "edits" in r]
        every = tallies.pop()
        self.assertEqual(every["scene"], "all")
        self.assertEqual(sum(r["edits"] for r in tallies), every["edits"])
        self.assertGreater(every["in_contact"], 0)

    def test_the_same_seed_gives_the_same(self):
        def counts():
            run("fuzz", "contact", "--scenes", "4", "--seed", "7", "--out", str(self.out))
            return [{k: v for k, v in r.items() if not k.endswith("_ns")} for r in self.records("fuzz")]

        self.assertEqual(counts(), counts())

    def test_fails_where_something_was_found_and_what_is_written_fails_again(self):
        recordings = HERE / "fuzz" / "recordings"
        box = recordings / "crushed" / "body0.obj"
        folder = self.out / "hand"
        folder.mkdir(parents=True)
        (folder / "body0.obj").write_text(box.read_text())
        # The HIP begins inside of the box: no contact core can help it.
        motion = [f"{tick},0.001,0.002,-0.001,1,0,0,0,0,0,0" for tick in range(5)]
        (folder / "motion.csv").write_text("\n".join(motion) + "\n")
        done = run("fuzz", "replay", str(folder), "--out", str(self.out))
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(self.records("fuzz")[0]["failure"], "inside")

    def test_says_what_is_wrong_with_a_folder(self):
        folder = self.out / "empty"
        folder.mkdir(parents=True)
        done = run("fuzz", "replay", str(folder), "--out", str(self.out))
        self.assertEqual(done.returncode, 1)
        self.assertIn("body0.obj", done.stderr)

    def test_ends_in_order_on_ctrl_c(self):
        program = subprocess.Popen([PROGRAM, "fuzz", "edits", "--scenes", "1000000", "--out", str(self.out)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        program.send_signal(signal.SIGINT)
        printed, _ = program.communicate(timeout=60)
        self.assertIn("interrupted", printed)
        self.assertGreater([r for r in self.records("fuzz") if r["scene"] == "all"][0]["edits"], 0)


class Failures(Verb):
    def test_writes_flat_records_of_every_scene_for_each_seed(self):
        self.run_well("failures", "--seed", "3", "--seeds", "2", "--method", "ours", "--scene", "S7")
        self.assertEqual([(r["seed"], r["scene"]) for r in self.records("failures")], [(3, "S7"), (4, "S7")])
        self.run_well("failures", "--seed", "3", "--method", "ours")
        records = self.records("failures")
        self.assertEqual([(r["seed"], r["scene"]) for r in records], [(3, name) for name in SCENES])
        for record in records:
            self.assertEqual(record["method"], "ours")
            # Bodies that move through each other can close a pocket on the IHIP; of stacks one creeps.
            if record["scene"] not in ("S20",):
                self.assertEqual((record["pass"], record["expected"]), (True, "pass"))
            for key, value in record.items():
                self.assertIsInstance(value, (bool, int, float, str), key)
        by_name = {r["scene"]: r for r in records}
        for scene, zero in (("S1", "ghost_force_N"), ("S2", "inside_box_ticks"), ("S3", "inside_without_force_ticks"),
                            ("S4", "plate_undetected_ticks"), ("S5", "leaks"), ("S7", "lost_ticks"),
                            ("S9", "pop_through_ticks"), ("S11", "wrong_ticks_away_from_defects"),
                            ("S12", "powers_of_two_different_ticks"), ("S13", "light_hand_rings"),
                            ("S15", "encoder_toggles_per_s"), ("S16", "false_exit_ticks"), ("S17", "nan_ticks"),
                            ("S17", "at_rest_nan_ticks"), ("S23", "non_finite_ticks"), ("S26", "awake_after_60_s"), ("S30", "through_the_bowl"),
                            ("S31", "non_finite_ticks"),
                            ("S32", "dented_non_finite_ticks"), ("S33", "wrong_ticks"), ("S34", "wrong_ticks"),
                            ("S35", "wrong_ticks"), ("S36", "wrong_ticks"), ("S37", "wrong_ticks"), ("S38", "wrong_ticks"),
                            ("S39", "inside_ticks"), ("S40", "non_finite_ticks")):
            self.assertEqual(by_name[scene][zero], 0, zero)


class Outside(Verb):
    """Methods from outside are judged by what judges the built-in ones."""
    METHODS = Path(PROGRAM).parent / "methods"
    PENALTY = str(METHODS / "penalty.so")

    def verdicts(self, *arguments):
        self.run_well("failures", *arguments)
        return {r["scene"]: r for r in self.records("failures")}

    def test_the_penalty_method_in_c_measures_as_the_built_in_one(self):
        for scene in ("S1", "S4", "S8", "S9"):
            theirs, ours = (self.verdicts("--scene", scene, "--method", method)[scene]
                            for method in (self.PENALTY, "global_closest"))
            self.assertEqual(theirs.pop("method"), "penalty_c")
            for about_the_run in ("method", "expected", "as_expected"):
                theirs.pop(about_the_run, None), ours.pop(about_the_run, None)
            self.assertEqual(theirs, ours)

    def test_one_in_python_is_judged_too(self):
        program = HERE / "adapters" / "penalty.py"
        record = self.verdicts("--scene", "S9", "--method", f"/usr/bin/python3 -B {program}")["S9"]
        self.assertEqual((record["method"], record["pass"]), ("penalty_python", False))
        self.assertGreater(record["pop_through_ticks"], 0)

    def test_faults_are_named_in_their_rows_and_the_run_goes_on(self):
        WITHOUT_DISPLAY["HAPTICS_FAULT"] = "crash"
        self.addCleanup(WITHOUT_DISPLAY.pop, "HAPTICS_FAULT")
        records = self.verdicts("--method", str(self.METHODS / "faulty.so"))
        self.assertEqual(list(records), SCENES)
        self.assertIn("signal 6 (Aborted) in tick 100", records["S2"]["fault"])
        self.assertIs(records["S2"]["pass"], False)
        for scene, why in (("S11", "not closed"), ("S17", "part"), ("S30", "part")):
            self.assertIsNone(records[scene]["pass"], scene)
            self.assertIn(why, records[scene]["not_applicable"])

    def test_walks_fuzz_and_accuracy_take_them(self):
        run("walk", "--method", self.PENALTY, "--scene", "sphere", "--ticks", "500", "--out", str(self.out))
        self.assertEqual([(r["method"], r["ticks"]) for r in self.records("walk")], [("penalty_c", 500)] * 2)
        run("fuzz", "contact", "--method", self.PENALTY, "--scenes", "4", "--out", str(self.out))
        self.assertGreater(sum(r.get("ticks", 0) for r in self.records("fuzz")), 1000)
        theirs, ours = [], []
        for method, records in ((self.PENALTY, theirs), ("global_closest", ours)):
            self.run_well("accuracy", "--method", method, "--finest", "12")
            records += self.records("accuracy")
        for measure in ("ihip_error_max_mm", "force_error_max_N", "limit_cycle_um", "K_crit_N_per_m", "missed_contact_ticks"):
            for their, our in zip(theirs, ours, strict=True):  # a foot on an edge may be rounded as of either triangle
                self.assertAlmostEqual(their[measure], our[measure], delta=1e-9 * abs(our[measure]) + 1e-9, msg=measure)
        self.assertTrue(all(r["tick_p50_ns"] > 0 and r["pipe_p50_ns"] > 1000 for r in theirs))

    @unittest.skipUnless(os.environ.get("HAPTICS_LONG"), "by the failure scenes, with a method of brute force: many minutes")
    def test_the_chart_has_them_beside_the_curves_of_an_earlier_run(self):
        kept = self.out.parent / "kept.csv"
        rows = (HERE.parents[1] / "deploy" / "pictures" / "chart.csv").read_text().splitlines(keepends=True)
        kept.write_text("".join(row for row in rows if row.startswith(("method,", "ours,", "god_object,"))))
        said = self.run_well("chart", "--method", self.PENALTY, "--from", str(kept), "--finest", "12")
        self.assertRegex(said, r"penalty_c +fails \d+ of")
        table = (self.out / "chart.csv").read_text()
        self.assertTrue(set(kept.read_text().splitlines()) <= set(table.splitlines()))
        (row,) = [r for r in csv.DictReader(table.splitlines()) if r["method"] == "penalty_c"]
        self.assertGreater(float(row["hot_tick_p50_ns"]), 0)
        self.assertEqual((float(row["cold_tick_p50_ns"]), float(row["instructions_per_tick"])), (0, 0))
        self.assertIn("S9", row["failed_scenes"].split())
        self.assertIn("S10", row["passed_scenes"].split())
        self.check_pictures("chart")
        self.assertIn("penalty_c, from outside", re.sub(r"<[^>]*>", "", (self.out / "chart.svg").read_text()) + said)

    def test_faults_are_named_by_every_verb(self):
        WITHOUT_DISPLAY["HAPTICS_FAULT"] = "crash"
        self.addCleanup(WITHOUT_DISPLAY.pop, "HAPTICS_FAULT")
        for verb, *options in (("walk", "--scene", "sphere", "--ticks", "500"), ("fuzz", "contact", "--scenes", "4", "--moving", "no"),
                               ("accuracy", "--finest", "12"), ("combinations", "--pair", "lattice-several")):
            run(verb, *options, "--method", str(self.METHODS / "faulty.so"), "--out", str(self.out))
            faults = re.findall('"fault": "([^"]*)"', json.dumps(self.records(verb)))
            self.assertTrue(faults and all("signal 6 (Aborted) in tick 100" in fault for fault in faults), (verb, faults))

    def test_the_chart_names_what_stopped_one(self):
        WITHOUT_DISPLAY["HAPTICS_FAULT"] = "nan_force"
        self.addCleanup(WITHOUT_DISPLAY.pop, "HAPTICS_FAULT")
        done = run("chart", "--method", str(self.METHODS / "faulty.so"), "--finest", "12", "--out", str(self.out))
        self.assertEqual(done.returncode, 1)
        self.assertIn("a force that is not finite in tick 100", done.stdout)
        self.assertIn("no method has a point", done.stderr)

    def test_combinations_hand_over_what_they_can(self):
        self.run_well("combinations", "--method", self.PENALTY)
        records = self.records("combinations")
        judged = {r["scene"] for r in records if r["pass"] is not None}
        self.assertEqual(judged, {"lattice-several"})
        self.assertEqual({r["method"] for r in records}, {"penalty_c"})
        whys = {r["scene"]: r["not_applicable"] for r in records if r["pass"] is None}
        self.assertEqual(len(whys), 35)
        self.assertEqual(whys["texture-several"], "texture is not handed over")
        self.assertIn("friction", whys["friction-lattice"])
        # Ours by the same way, which has shading and friction: within the same limits.
        self.run_well("combinations", "--method", "ours_without_gain_clamp")
        judged = {r["scene"]: r["pass"] for r in self.records("combinations") if r["pass"] is not None}
        self.assertEqual(judged, dict.fromkeys(("shading-friction", "shading-lattice", "shading-several", "friction-lattice",
                                                "friction-several", "lattice-several"), True))

    def test_are_started_by_nobody_but_who_typed_their_name(self):
        for more in (("--shard", "1/2"), ("--nats", "nats://127.0.0.1:1")):
            done = run("failures", "--method", self.PENALTY, *more, "--out", str(self.out))
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("whole and here", done.stderr)


class Judge(Verb):
    """Verdicts from files are those of the live run."""

    def export(self, method, scene):
        runs = self.out.parent / "runs"
        self.run_well("failures", "--method", method, "--scene", scene, "--export", str(runs))
        return runs / f"{method}-{scene}-1"

    def judge(self, folder):
        return run("judge", str(folder), "--out", str(self.out))

    def test_judges_as_the_live_run_did(self):
        for method, scene in (("ours", "S1"), ("god_object", "S4"), ("global_closest", "S9"), ("ours", "S33"),
                              ("ours", "S37"), ("ours", "S15"), ("ours", "S39")):
            folder = self.export(method, scene)
        done = self.judge(folder.parent)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count("as in verdict.json"), 7)
        self.assertEqual(len(self.records("judge")), 7)

    @unittest.skipUnless(os.environ.get("HAPTICS_LONG"), "all scenes take a minute")
    def test_judges_all_scenes_as_the_live_run_did(self):
        runs = self.out.parent / "runs"
        self.run_well("failures", "--method", "ours", "--export", str(runs))
        done = self.judge(runs)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count("pass, as in verdict.json"), 33)
        (runs / "ours-S17-1" / "dents.csv").unlink()
        self.assertEqual(self.judge(runs / "ours-S17-1").returncode, 1)

    def test_the_page_is_enough_to_draw_a_run(self):
        folder = self.export("god_object", "S1")
        picture = self.out / "S1.png"
        done = subprocess.run(["/usr/bin/python3", "-B", HERE / "exchange" / "draw_run.py", folder, picture],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = {file: list(csv.DictReader((folder / file).read_text().splitlines())) for file in ("motion.csv", "forces.csv")}
        first = {row["row"] for row in rows["motion.csv"] if row["load"] == "0"}
        forces = [row for row in rows["forces.csv"] if row["row"] in first]
        most = max(sum(float(r[f"force_{k}_N"]) ** 2 for k in "xyz") for r in forces) ** 0.5
        self.assertIn(f"1 bodies, {len(forces)} ticks, {sum(r['touching'] == '1' for r in forces)} touching, {most:.6g} N", done.stdout)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(picture.stat().st_size, 30_000)
        wrong = subprocess.run(["/usr/bin/python3", "-B", HERE / "exchange" / "draw_run.py", folder, picture, "9"],
                               capture_output=True, text=True)
        self.assertIn("has loads 0 to", wrong.stderr)

    def test_other_forces_have_another_verdict(self):
        folder = self.export("ours", "S9")
        rows = (folder / "forces.csv").read_text().splitlines()
        pressed = max(range(1, len(rows)), key=lambda i: abs(float(rows[i].split(",")[3])))
        cells = rows[pressed].split(",")
        hip = next(line for line in (folder / "motion.csv").read_text().splitlines() if line.split(",")[0] == cells[0])
        cells[1], cells[3:6], cells[6:9] = "0", ["0"] * 3, hip.split(",")[3:6]  # lets go
        (folder / "forces.csv").write_text("\n".join([*rows[:pressed], ",".join(cells), *rows[pressed + 1:]]) + "\n")
        done = self.judge(folder)
        self.assertEqual(done.returncode, 1)
        self.assertIn("FAIL, OTHER than in verdict.json", done.stdout)

    def test_says_what_is_wrong_with_a_folder(self):
        folder = self.export("ours", "S9")
        forces, motion, scene = (folder / name for name in ("forces.csv", "motion.csv", "scene.json"))
        for file, old, new, says in ((forces, "touching", "touching", None),
                                     (scene, "haptics scene 1", "hearsay", '"haptics scene 1" is right'),
                                     (scene, '"S9"', '"S99"', "there is none called S99"),
                                     (motion, "\n1,load", "\n1,edit", 'row 1 is "edit" where the scene has "load"'),
                                     (motion, "\n2,", "\n3,", "row 2 is not numbered so"),
                                     (forces, "\n2,0", "\n2,x", "line 2 has no number in column 2")):
            before = file.read_text()
            file.write_text(before.replace(old, new, 1))
            done = self.judge(folder)
            file.write_text(before)
            if says is not None:
                self.assertEqual(done.returncode, 1, says)
                self.assertIn(says, done.stderr)
        forces.write_text("\n".join(forces.read_text().splitlines()[:100]) + "\n")
        self.judge(folder)
        self.assertIn("forces.csv ends before row", self.records("judge")[0]["fault"])


class Arguments(Verb):
    def test_each_that_is_wrong_is_named_with_what_would_be_right(self):
        for arguments, says in (
                ("hearsay", ("hearsay", "failures, judge, accuracy, combinations, chart")),
                ("failures --seeds 0", ("--seeds", "at least 1")),
                ("failures --seed -1", ("--seed", "at least 0")),
                ("failures --method hearsay", ("--method", "hearsay", "god_object", "ours_without_guard")),
                ("failures --method ./hearsay.so", ("--method ./hearsay.so", "exit status 2")),
                ("judge /dev", ("/dev", "scene.json")),
                ("walk --ticks -5", ("--ticks", "at least 1")),
                ("walk --scene sphere --ticks 0", ("--ticks", "at least 1")),
                ("walk --scene hearsay", ("--scene", "hearsay", "sphere")),
                ("walk --method hearsay", ("--method", "hearsay", "god_object")),
                ("walk --tool --scene folded", ("--scene", "folded")),
                ("walk --tool --scene sphere --ticks 1", ("--ticks", "at least 2")),
                ("walk --models /hearsay", ("--models", "/hearsay")),
                ("walk --models /dev", ("armadillo", "dragon", "deploy/models/fetch_and_report")),
                ("walk --models /dev --scene dragon", ("dragon", "deploy/models/fetch_and_report")),
                ("walk --scene armadillo", ("armadillo", "deploy/models/fetch_and_report")),
                ("accuracy --finest 3", ("--finest", "at least 12")),
                ("accuracy --method hearsay", ("--method", "hearsay", "god_object")),
                ("chart --finest x", ("--finest", "whole number")),
                ("table1 --seconds 0", ("--seconds", "more than 0")),
                ("table1 --runs 0", ("--runs", "at least 1")),
                ("advise scene --tolerance -1", ("--tolerance", "more than 0")),
                ("advise scene --device-preset hearsay", ("--device-preset", "hearsay", "omega.3")),
                ("advise", ("SCENE", "required")),
                ("accuracy --out /dev/null/results", ("--out", "/dev/null/results"))):
            done = run(*arguments.split()) if "--out" in arguments else run(*arguments.split(), "--out", str(self.out))
            self.assertNotEqual(done.returncode, 0, arguments)
            for words in says:
                self.assertIn(words, done.stderr, arguments)


class Walk(Verb):
    def test_over_a_generated_shape_needs_no_model(self):
        self.run_well("walk", "--models", "/dev", "--scene", "sphere", "--ticks", "500")
        self.assertEqual([r["scene"] for r in self.records("walk")], ["sphere", "all"])

    def test_of_tools_judges_all_of_their_points(self):
        self.run_well("walk", "--tool", "--models", "/dev", "--scene", "sphere", "--ticks", "1000")
        for record in self.records("walk"):
            self.assertEqual(record["judged_points"], record["ticks"] // 23 * record["points"])
            self.assertGreater(record["contact_ticks"], 100)


class Accuracy(Verb):
    def test_has_limit_cycle_critical_stiffness_and_deadline_misses_beside_the_errors(self):
        self.run_well("accuracy", "--finest", "192", "--method", "ours")
        records = self.records("accuracy")
        self.assertEqual(len(records), 6 * 2 * 4)
        for record in records:
            self.assertEqual(record["limit_cycle_allowed_um"], 110)  # two steps of the default device's encoder
            self.assertLessEqual(record["limit_cycle_um"], record["limit_cycle_allowed_um"])
            self.assertGreaterEqual(record["K_crit_N_per_m"], 10_000)  # what haptic_eval stability requires of a wall
            self.assertEqual(record["deadline_misses"], 0)

    def test_tells_what_does_not_come_to_rest(self):
        self.run_well("accuracy", "--finest", "12", "--method", "global_closest")
        self.assertEqual({r["scene"] for r in self.records("accuracy") if not r["steady"]}, {"torus"})


class ChartMeasured(Verb):
    def test_has_every_method_priced_and_judged(self):
        kept = json.loads((HERE / "worst" / "kept.json").read_text())
        self.out.mkdir()
        (self.out / "worst.json").write_text(json.dumps([r for r in kept if r["family"] == "comb"]))
        self.run_well("chart", "--finest", "12", "--kept", str(self.out / "worst.json"))
        rows = list(csv.DictReader((self.out / "chart.csv").read_text().splitlines()))
        methods = {row["method"]: row for row in rows}
        self.assertIn("ours", methods)
        self.assertIn("god_object", methods)
        for row in rows:
            self.assertGreater(float(row["hot_tick_p50_ns"]), 0)
            self.assertGreater(float(row["cold_tick_p50_ns"]), float(row["hot_tick_p50_ns"]))
            self.assertEqual(float(row["limit_cycle_allowed_um"]), 110)
            self.assertEqual(float(row["worst_tick_instructions"]) > 0, row["method"] == "ours")
            scenes = row["passed_scenes"].split() + row["failed_scenes"].split()
            self.assertEqual(len(scenes), len(set(scenes)))
            self.assertLessEqual({"S1", "S12"}, set(scenes))
        self.assertLessEqual(float(methods["ours"]["limit_cycle_um"]), 110)
        self.assertGreater(float(methods["ours"]["worst_tick_instructions"]),
                           10 * float(methods["ours"]["instructions_per_tick"]))
        self.assertEqual(len(methods["ours"]["passed_scenes"].split() + methods["ours"]["failed_scenes"].split()), len(SCENES))
        self.assertLessEqual(set(methods["ours"]["failed_scenes"].split()), {"S20"})
        self.assertIn("S14", methods["ours_shaded"]["passed_scenes"].split())
        self.assertEqual(methods["ours_without_substeps"]["failed_scenes"].split(), ["S7"])
        self.assertIn("S4", methods["god_object"]["failed_scenes"].split())
        self.check_pictures("chart")
        measured = (self.out / "chart.csv").read_text()
        (self.out / "kept.csv").write_text(measured)
        self.run_well("chart", "--from", str(self.out / "kept.csv"))
        self.assertEqual((self.out / "chart.csv").read_text(), measured)
        for row in rows:
            row.update({"passed_scenes": "S1 ", "failed_scenes": ""})
        with open(self.out / "kept.csv", "w", newline="") as kept:
            table = csv.DictWriter(kept, rows[0].keys(), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
        said = self.run_well("chart", "--from", str(self.out / "kept.csv"))
        self.assertRegex(said, "god_object +passes all 1 failure scenes\n")
        self.assertEqual((self.out / "chart.csv").read_text(), (self.out / "kept.csv").read_text())


class Chart(Verb):
    def test_is_drawn_again_from_its_table(self):
        kept = HERE.parents[1] / "deploy" / "pictures" / "chart.csv"
        self.run_well("chart", "--from", str(kept))
        self.check_pictures("chart")
        self.assertEqual((self.out / "chart.csv").read_text(), kept.read_text())

    def test_says_which_line_of_a_table_is_wrong(self):
        self.out.mkdir()
        head = ("method,triangles,hot_tick_p50_ns,cold_tick_p50_ns,instructions_per_tick,epsilon_p99_ratio,"
                "force_above_100Hz_rms_N,limit_cycle_um,limit_cycle_allowed_um,worst_tick_instructions,"
                "passed_scenes,failed_scenes\n")
        row = "ours,12,1,1,1,1,1,0,110,0,"
        for table, says in (("", "is not a chart.csv"), (head + row.replace("ours", "hear say") + "S1,\n", ":2: "),
                            (head.replace("passed_scenes,", "") + row + "\n", "it has no passed_scenes"),
                            (head.replace("limit_cycle_um,", "") + row + "S1,\n", "it has no limit_cycle_um"),
                            (head + "ours,12,1,1,x\n", ":2: "), (head + row + ",S99\n", "S99"),
                            (head + row + "S99,\n", "S99"), (head + row + ",\n", "names no scene that was run"),
                            (head, "the table has no method")):
            (self.out / "wrong.csv").write_text(table)
            done = run("chart", "--from", str(self.out / "wrong.csv"), "--out", str(self.out))
            self.assertEqual(done.returncode, 1, table)
            self.assertIn(says, done.stderr, table)


class Textures(Verb):
    def test_measures_every_family_friction_and_shading_within_the_limits(self):
        self.run_well("textures")
        records = self.records("textures")
        self.assertTrue(all(r["pass"] for r in records))
        for record in records:
            for key, value in record.items():
                self.assertIsInstance(value, (bool, int, float, str), key)
        scenes = {r["scene"] for r in records}
        for family in ("fourier_grating", "fourier_sum", "noise", "fractal", "cellular", "grain", "spots", "stripes",
                       "spot_noise", "image"):
            self.assertIn(family, scenes)
            self.assertIn("rest_" + family, scenes)
        for computed in ("spots", "stripes", "spot_noise", "image"):
            for around in ("cube", "cylinder", "sphere"):
                self.assertIn(f"{computed}_on_{around}", scenes)
        flat, shaded = (r for r in records if r["scene"] == "shading_sphere" and r["triangles"] > 10_000)
        self.assertGreater(flat["direction_error_rms_deg"], 10 * shaded["direction_error_rms_deg"])
        rings = [r for r in records if r["scene"] == "map_grating" and r["hand"] == "light" and not r["steady"]]
        # The clamp of K shows in S13 of the failure scenes: with the stabiliser these gratings rest without it too, but on one
        # device, which senses so finely that its makers make it stiff, and has little friction.
        self.assertEqual({r["method"] for r in rings}, {"bump_mapping", "ours_without_gain_clamp"})
        self.assertEqual({r["device"] for r in rings if r["method"] != "bump_mapping"}, {"sigma.7"})
        self.assertEqual((self.out / "textures.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater((self.out / "textures.png").stat().st_size, 100_000)


class Table1(Verb):
    def test_has_the_papers_counts_and_rates_with_the_viewer_connected_and_repeats_as_the_paper_does(self):
        self.run_well("table1", "--seconds", "0.2", "--runs", "2", "--finest", "64800")
        records = self.records("table1")
        counts = [(r["vertices"], r["lines"], r["polygons"], r["boundary_lines"]) for r in records]
        self.assertEqual(counts, [(8, 18, 12, 0), (239, 695, 456, 22), (902, 2750, 1800, 100), (32402, 97200, 64800, 0)])
        for record in records:
            self.assertTrue(record["viewer_held_the_scene"])
            self.assertGreater(record["viewer_frames_per_s"], 0)
            self.assertGreater(record["complete_step_rate_per_processor_s_kHz"], record["paper_rate_high_kHz"])
            self.assertGreater(record["bare_step_rate_kHz"], record["complete_step_rate_per_processor_s_kHz"])
            self.assertTrue(record["complete"])
            self.assertEqual(record["blocks"], 20)

    def test_keeps_what_was_measured_when_interrupted(self):
        running = subprocess.Popen([PROGRAM, "table1", "--seconds", "5", "--runs", "3", "--finest", "64800", "--out", str(self.out)],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=WITHOUT_DISPLAY)
        self.addCleanup(running.kill)
        written = self.out / "table1.json"
        deadline = time.monotonic() + 120
        while not written.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        running.send_signal(signal.SIGINT)
        said = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 1, said)
        records = self.records("table1")
        self.assertEqual(len(records), 4)
        for record in records:
            self.assertFalse(record["complete"])
            self.assertGreater(record["complete_step_rate_kHz"], 0)


class Advise(Verb):
    def test_keeps_a_balls_roundness_and_not_a_boxs_grid(self):
        said = self.run_well("advise", str(HERE / "advise" / "advise_test.scene"))
        records = self.records("advise")
        self.assertRegex(said, r"\nball: use ball.ply, [0-9,]+ of 12,288 triangles, saves 0.[0-9] MB\n")
        self.assertIn("\nbox: keep; nothing is to be gained\n", said)
        motions = [r for r in records if "motion" in r]
        self.assertEqual([r["motion"] for r in motions if r["scene"] == "box"],
                         ["pressed through", "pushed at its sharpest corner", "stroked at 2 m/s"])
        self.assertTrue(all(r["pass"] for r in motions), motions)
        self.assertEqual(said.count("stroked at 2 m/s: the IHIP stays outside."), 2)
        good = [r["triangles"] for r in records if r["scene"] == "box" and r.get("pass") and "triangles" in r]
        self.assertEqual(good, [192, 12], "flat faces need no more")
        for name, least, most in (("ball", 100, 12288), ("box", 192, 193)):
            meshes = [r for r in records if r["scene"] == name and "triangles" in r]
            advised = [r for r in meshes if r["advised"]]
            self.assertEqual(len(advised), 1)
            self.assertTrue(advised[0]["pass"])
            self.assertLess(advised[0]["epsilon_p99_ratio"], 1)
            self.assertGreaterEqual(advised[0]["triangles"], least)
            self.assertLess(advised[0]["triangles"], most)
            self.assertTrue(any(not r["pass"] for r in meshes), "went on until it would not do")
            coarser = meshes[meshes.index(advised[0]) + 1]
            self.assertEqual(coarser["memory_step_MB"], coarser["memory_MB"] - advised[0]["memory_MB"])
            materials = [r for r in records if r["scene"] == name and "stiffness_N_per_m" in r]
            (here,) = [r for r in materials if r["advised"]]
            steps = {r["step"]: r for r in materials if "step" in r}
            self.assertLessEqual(set(steps), {"stiffness up", "stiffness down", "damping up", "damping down"})
            self.assertIn("stiffness up", steps)
            self.assertTrue({"damping up", "damping down"} & set(steps))
            for step, there in steps.items():
                self.assertEqual("up" in step, (there["stiffness_N_per_m"], there["damping_Ns_per_m"]) >
                                 (here["stiffness_N_per_m"], here["damping_Ns_per_m"]))
                self.assertEqual(there["damping_step_Ns_per_m"] == 0, "stiffness" in step)
        self.assertIn("Ns/m more damping; steady from", said)
        rates = [r for r in records if r["scene"] == "all objects"]
        (advised,) = [r for r in rates if r["advised"]]
        self.assertGreater(advised["rate_Hz"], 250)
        self.assertRegex(advised["decided_by"], r"Hz fails: .*tap on ")
        below = rates[rates.index(advised) - 1]
        self.assertFalse(below["pass"])
        self.assertIn("rest on ball", rates[0]["fails"], "60 Hz")
        self.assertIn("is enough; ", said)
        for r in rates:
            if "step" in r:
                self.assertAlmostEqual(r["processor_step_ratio"], r["processor_ratio"] - advised["processor_ratio"])
        self.assertIn("up", [r.get("step") for r in rates])
        self.assertEqual([r["rate_Hz"] for r in rates if r["pass"]][:1], [r["rate_Hz"] for r in rates if r["advised"]])
        self.check_pictures("advise")

    def test_leaves_an_undamped_stiff_slab_as_it_is_which_the_stabiliser_holds(self):
        self.run_well("advise", str(HERE / "advise" / "stiff_test.scene"), "--device-preset", "premium-1.5")
        options = [r for r in self.records("advise") if "stiffness_N_per_m" in r]
        advised = [r for r in options if r["advised"]]
        self.assertEqual(len(advised), 1)
        own_good = [r["rate_Hz"] for r in options if r["own_material"] and r["pass"]]
        self.assertTrue(advised[0]["own_material"])
        self.assertEqual(advised[0]["stiffness_N_per_m"], 2000)
        self.assertEqual(advised[0]["damping_Ns_per_m"], 0)
        self.assertLess(advised[0]["epsilon_p99_ratio"], 1)
        self.assertEqual(advised[0]["rate_Hz"], own_good[0])
        for option in options:
            if option["stiffness_N_per_m"] != 2000:
                self.assertGreater(option["epsilon_p99_ratio"], 1, "half or twice as stiff is felt")
                self.assertFalse(option["pass"])

    def test_says_and_writes_the_widest_spacing_of_a_tool_that_is_not_felt(self):
        scene = HERE / "advise" / "tool_test.scene"
        done = self.apply(scene)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("knob, held as a tool", done.stdout)
        records = self.records("advise")
        spacings = [r for r in records if r.get("tool")]
        self.assertEqual({r["scene"] for r in spacings}, {"knob"})
        self.assertEqual([r["spacing_mm"] for r in spacings][:2], [1, 1.5])
        self.assertEqual([r["own_spacing"] for r in spacings], [True] + [False] * (len(spacings) - 1))
        (advised,) = [r for r in spacings if r["advised"]]
        before = spacings[:spacings.index(advised) + 1]
        self.assertTrue(all(r["pass"] and r["epsilon_p99_ratio"] < 1 and r["torque_epsilon_p99_ratio"] < 1 for r in before))
        self.assertGreater(advised["spacing_mm"], 1)
        self.assertTrue(any(not r["pass"] for r in spacings), "went on until it would not do")
        points = [r["points"] for r in spacings]
        self.assertEqual(points, sorted(points, reverse=True))
        self.assertTrue(all(r["hot_tick_p50_ns"] > 0 for r in spacings))
        rows = list(csv.DictReader((self.out / "advise_tool.csv").read_text().splitlines()))
        self.assertEqual([int(row["points"]) for row in rows], points)
        self.assertEqual([row["advised"] for row in rows].count("1"), 1)
        self.assertFalse([r for r in records if r["scene"] == "knob" and "triangles" in r], "it is no object to touch")
        spacing = re.search(r"spacing_m: ([0-9.e-]+)", (self.applied / scene.name).read_text())
        self.assertAlmostEqual(float(spacing[1]), 1e-3 * advised["spacing_mm"])
        self.assertIn("torsion_Nm_per_rad: 0.5 } }", (self.applied / scene.name).read_text())
        self.assertGreater(advised["checked_ticks"], 500)
        self.assertLess(advised["checked_epsilon_p99_ratio"], 1)
        self.assertLess(advised["checked_torque_epsilon_p99_ratio"], 1)
        self.assertIn("knob: on other strokes the error is ", done.stdout)

    def apply(self, scene, *options):
        self.applied = self.out.parent / "applied"
        return run("advise", str(scene), "--out", str(self.out), "--apply", str(self.applied), *options)

    def test_writes_the_advised_scene_which_feels_the_same_on_other_strokes(self):
        scene = self.out.parent / "own" / "apply_test.scene"
        scene.parent.mkdir()
        shutil.copy(HERE / "advise" / "apply_test.scene", scene)
        shutil.copy(HERE.parents[1] / "deploy" / "scenes" / "sprinkles.png", scene.parent / "dots.png")
        done = self.apply(scene)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        before, after = scene.read_text(), (self.applied / scene.name).read_text()
        replaced = "mesh { box { size_m { x: 0.1 y: 0.06 z: 0.02 } segments: 24 } }"
        self.assertEqual(after, before.replace(replaced, 'mesh { file: "plate.ply" }'))
        self.assertEqual({p.name for p in self.applied.iterdir()}, {scene.name, "plate.ply", "dots.png"})
        ply = (self.applied / "plate.ply").read_bytes()
        self.assertIn(b"element face 12\n", ply)
        self.assertEqual(len(ply.split(b"end_header\n", 1)[1]), 8 * 12 + 12 * 13)
        for said in ("plate: use plate.ply, 12 of 6,912 triangles",
                     "foam: keep; 12 of 4,800 triangles would do for a rigid body at rest, but its softness",
                     "not judged: softness (judged as rigid)", "but its creases name its vertices",
                     "not felt: texture, which costs", "but its pattern is mapped"):
            self.assertIn(said, done.stdout)
        (plate,) = [r for r in self.records("advise") if r["scene"] == "plate" and "verdict" in r]
        self.assertTrue(plate["pass"] and plate["replaces_mesh"])
        self.assertGreaterEqual(plate["checked_below_1_ratio"], 0.99)
        self.assertGreater(plate["checked_ticks"], 1000)
        again = self.apply(scene)
        self.assertEqual(again.returncode, 1)
        self.assertIn(f"--apply: {self.applied / scene.name} is there already", again.stderr)
        (self.applied / scene.name).unlink()
        (self.applied / "plate.ply").write_text("mine")
        scene.write_text(before[:before.index("operations", before.index("plate"))])
        again = self.apply(scene)
        self.assertIn("plate.ply is there already and holds something else", again.stderr)
        self.assertEqual((self.applied / "plate.ply").read_text(), "mine")

    def test_judges_a_texture_and_the_rate_that_it_needs(self):
        self.run_well("advise", str(HERE / "advise" / "texture_test.scene"))
        records = self.records("advise")
        fine, faint, collision = [r for r in records if "feature" in r]
        self.assertEqual([r["scene"] for r in (fine, faint, collision)], ["fine", "faint", "faint"])
        self.assertTrue(fine["felt"] and fine["epsilon_p99_ratio"] > 1)
        self.assertFalse(faint["felt"] or faint["epsilon_p99_ratio"] > 1)
        self.assertEqual((collision["feature"], collision["judged"]), ("collision", False))
        self.assertIn("hand alone", collision["why"])
        rates = {r["rate_Hz"]: r for r in records if r["scene"] == "all objects"}
        for rate, at in rates.items():
            self.assertEqual("pattern of fine" in at["fails"], rate < 10 * 0.1 / 0.0003)
            self.assertNotIn("pattern of faint", at["fails"])
        rows = {r["object"]: r for r in csv.DictReader((self.out / "advise_objects.csv").read_text().splitlines())}
        self.assertEqual(rows["fine"]["not_felt"], "")
        self.assertIn("texture, which costs", rows["faint"]["not_felt"])
        self.assertEqual(rows["faint"]["not_judged"], "collision (judged by the hand alone)")
        self.assertEqual(rows["faint"]["verdict"], "keep; every triangle is needed")

    def test_judges_a_shaded_object_by_its_shading(self):
        self.run_well("advise", str(HERE.parents[1] / "deploy" / "scenes" / "cylinder.scene"))
        meshes = {name: [r["epsilon_p99_ratio"] for r in self.records("advise") if r["scene"] == name and "triangles" in r]
                  for name in ("smooth-side", "faceted")}
        self.assertNotEqual(meshes["smooth-side"], meshes["faceted"])

    def test_names_the_field_that_is_wrong(self):
        self.out.mkdir()
        scene = self.out / "bad.scene"
        good = (HERE / "advise" / "advise_test.scene").read_text()
        scene.write_text(good.replace("radius_m: 0.03", "radius_m: -1"))
        done = run("advise", str(scene))
        self.assertEqual(done.returncode, 1)
        self.assertIn("operations[0].add.mesh.sphere.radius_m", done.stderr)

    def test_says_of_a_scene_or_mesh_what_is_wrong_with_it(self):
        self.out.mkdir()
        (self.out / "empty.scene").write_text("")
        (self.out / "damaged.obj").write_text("no mesh")
        (self.out / "damaged.scene").write_text('operations { add { name: "a" mesh { file: "damaged.obj" } } }')
        for scene, says in (("missing.scene", "there is no such file"), ("empty.scene", "operations: is empty"),
                            ("damaged.scene", "operations[0].add.mesh.file")):
            done = run("advise", str(self.out / scene))
            self.assertEqual(done.returncode, 1)
            self.assertIn(scene, done.stderr)
            self.assertIn(says, done.stderr)


if __name__ == "__main__":
    unittest.main()
