"""Videos of recordings play in Chromium, and their frames are those of the recording: an object in the scene changes its colour
by edits, at ticks that the server names, and each frame shows the colour of its moment.
"""
import bisect
import functools
import hashlib
import http.server
import random
import shutil
import struct
import sys
import threading
import time
import unittest

import browser
import harness
import haptic_recording
from haptic_client import Client

SKIPPED = 77  # as CMake is told
SCENES = harness.PROJECT / "deploy" / "scenes"
ASSETS = ["--assets", "/usr/share/inventor/data", "--assets", SCENES]
COLOURS = ["red: 1 blue: 1", "green: 1 blue: 1"]  # magenta, cyan
MARK = """
operations { add { name: "mark" mesh { box { size_m { x: 0.04 y: 0.04 z: 0.04 } } } pose { position { z: 0.22 } }
                             material { color { red: 1 blue: 1 } } } }"""
WIDTH, HEIGHT, FPS, EDITS = 720, 480, 10, 5
LEAST_PIXELS = 60   # of the mark
NEAR_S = 0.02       # an edit: the moments of a recording are some milliseconds apart

PAGE = """<canvas></canvas><script>
let video = document.createElement("video"), seen = null, ended = false, failed = "";
video.muted = true;
video.onerror = () => failed = video.error.message || "error " + video.error.code;
fetch("video.webm").then((r) => r.blob()).then((b) => { video.src = URL.createObjectURL(b); });
function play() { video.onended = () => ended = true; video.playbackRate = 4; video.play(); }
/// How many pixels of the scene are magenta at these times, beside the close-up of what the hand touches.
async function look(times) {
  const found = [], canvas = document.querySelector("canvas"), context = canvas.getContext("2d", {willReadFrequently: true});
  [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
  for (const time of times) {
    video.currentTime = time;
    await new Promise((resolve) => { video.onseeked = resolve; });
    context.drawImage(video, 0, 0);
    const p = context.getImageData(0, 0, canvas.width, Math.floor(canvas.height * 0.7)).data;
    let magenta = 0;
    for (let i = 0; i < p.length; i += 4) {
      const y = Math.floor(i / 4 / canvas.width), x = i / 4 % canvas.width;
      if (x > 0.8 * canvas.width && y > 0.4 * canvas.height) continue;
      magenta += Math.min(p[i], p[i + 2]) - p[i + 1] > 60;
    }
    found.push(magenta);
  }
  seen = found;
}
</script>"""


def last_tick_later(recording, file, ticks):
    """The recording, but for its last tick's number, with a chain of hashes that holds (record_chain.h)."""
    def sha(data):
        return hashlib.sha256(data).digest()
    parts = list(haptic_recording.parts(recording))
    last = [part for part in parts if part.HasField("ticks")][-1].ticks
    number, = struct.unpack_from("<Q", last.ticks, len(last.ticks) - 88)
    last.ticks = last.ticks[:-88] + struct.pack("<Q", number + ticks) + last.ticks[-80:]
    out = haptic_recording.HEAD
    chain = sha(out)
    for part in parts:
        payload = part.SerializeToString()
        head = struct.pack("<I", len(payload))
        head += sha(chain + head)[:4]
        chain = sha(chain + head + payload)
        out += head + payload + chain
    file.write_bytes(out)
    return file


class QuietFiles(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Filming(harness.EndToEnd):
    def record(self, scene, seed=1):
        """A recording, and the times in it at which the mark changes its colour, and its length (s). `scene`: its text."""
        file = self.folder / "ticks.haptics"
        server = self.start_server(scene=scene + MARK, options=["--record", file, *ASSETS])
        chance, ticks = random.Random(seed), []
        client = Client(server.address, "painter")
        for step in range(1, EDITS + 1):
            time.sleep(0.15 + 0.5 * chance.random())
            _, tick = client.apply(f'operations {{ set_material {{ object {{ name: "mark" }} '
                                   f'material {{ color {{ {COLOURS[step % 2]} }} }} }} }}')
            ticks.append(tick)
        time.sleep(0.3)
        client.close()
        self.stop_and_check(server)
        all_ticks = [tick.tick for tick in haptic_recording.ticks(file)]
        self.moments_s = [1e-3 * (tick - all_ticks[0]) for tick in all_ticks]  # a busy machine leaves gaps
        return file, [1e-3 * (tick - all_ticks[0]) for tick in ticks], self.moments_s[-1]

    def film(self, recording, *options, code=0):
        display = self.start_display()
        file = self.folder / "page" / "video.webm"
        file.parent.mkdir(exist_ok=True)
        viewer = harness.Process([harness.BIN / "graphics_client", "--recording", recording, "--video", file, "--size",
                                  f"{WIDTH}x{HEIGHT}", "--video-fps", FPS, *options],
                                 env={"DISPLAY": display.name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE})
        self.addCleanup(viewer.kill)
        self.assertEqual(viewer.wait(300), code, viewer.text())
        return file

    def open_page(self):
        folder = self.folder / "page"
        (folder / "index.html").write_text(PAGE)
        files = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(QuietFiles, directory=folder))
        threading.Thread(target=files.serve_forever, daemon=True).start()
        self.addCleanup(files.server_close)
        self.addCleanup(files.shutdown)
        page = browser.Browser(self.folder / "profile", f"http://127.0.0.1:{files.server_port}/")
        self.addCleanup(page.close)
        return page

    def check(self, scene):
        """The video of such a scene."""
        recording, changes_s, length_s = self.record(scene)
        self.film(recording)
        page = self.open_page()
        harness.wait_until(lambda: page.evaluate("typeof video !== 'undefined' && video.readyState >= 1"), 30,
                           lambda: page.evaluate("failed"))
        self.assertEqual(page.evaluate("[video.videoWidth, video.videoHeight]"), [WIDTH, HEIGHT])
        self.assertAlmostEqual(page.evaluate("video.duration"), length_s, delta=1.5 / FPS)
        page.evaluate("play(), 0")
        harness.wait_until(lambda: page.evaluate("ended"), 60, lambda: "does not play: " + page.evaluate("failed"))
        frames = [i for i in range(int(length_s * FPS)) if all(abs(i / FPS - change) > NEAR_S for change in changes_s)]
        page.evaluate(f"look({[(i + 0.5) / FPS for i in frames]}), 0")
        seen = harness.wait_until(lambda: page.evaluate("seen"), 120, "frames are not shown")
        self.assertGreater(max(seen) - min(seen), LEAST_PIXELS)
        middle = (max(seen) + min(seen)) / 2  # the scene may have something of that colour
        for i, magenta in zip(frames, seen):
            moment_s = self.moments_s[bisect.bisect_right(self.moments_s, i / FPS) - 1]
            edits = sum(change <= moment_s for change in changes_s)
            self.assertEqual(magenta > middle, edits % 2 == 0, f"frame {i}, after {edits} edits: {seen} pixels; {changes_s}")
        return page


class Videos(Filming):
    def test_each_frame_shows_its_moment_of_the_recording(self):
        self.check(harness.SCENE)

    def test_what_cannot_be_made_is_refused_with_a_reason(self):
        recording, _, _ = self.record(harness.SCENE)
        long = last_tick_later(recording, self.folder / "long.haptics", 10 ** 9)
        display = self.start_display()
        for file, options, words in [(recording, ["--video", self.folder / "missing" / "a.webm"], "missing/a.webm: "),
                                     (recording, ["--video", self.folder / "a.webm", "--size", "300x300"], "300x300 leaves no room"),
                                     (long, ["--video", self.folder / "a.webm"], "more than the 1000000 that a video may have")]:
            viewer = harness.Process([harness.BIN / "graphics_client", "--recording", file, *options],
                                     env={"DISPLAY": display.name, **harness.FOREIGN_CODE})
            self.addCleanup(viewer.kill)
            self.assertEqual(viewer.wait(120), 1, viewer.text())
            self.assertIn(words, viewer.text())

    def test_no_file_gets_the_ending_of_another_kind(self):
        for options in (["--screenshot", "a.jpg"], ["--sheet", "a.jpg"], ["--video", "a.mp4"]):
            viewer = harness.Process([harness.BIN / "graphics_client", *options])
            self.addCleanup(viewer.kill)
            self.assertEqual(viewer.wait(), 2, viewer.text())
            self.assertIn(f"{options[0]}: {options[1]}: ends with", viewer.text())


class VideosOfScenes(Filming):
    def test_of_every_demo_scene(self):
        for scene in sorted(SCENES.glob("*.scene")):
            with self.subTest(scene=scene.stem):
                try:
                    self.check(scene.read_text())
                finally:
                    self.doCleanups()
                    self.setUp()


if __name__ == "__main__":
    if not shutil.which("chromium"):
        print("chromium is not installed")
        sys.exit(SKIPPED)
    unittest.main()
