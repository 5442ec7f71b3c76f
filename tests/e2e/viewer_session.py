"""The viewer's window and its servers: what it says of them, asks before edits are lost, and replays."""
import os
import re
import struct
import subprocess
import time
import unittest
import zlib

import harness

WIDTH, HEIGHT = 1270, 790


def colours(png):
    """The different pixels of a picture, 8 bits a channel and not interlaced."""
    data, at, header, packed = png.read_bytes(), 8, None, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        header = body if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, _, kind = struct.unpack(">IIBB", header[:10])
    size = {2: 3, 6: 4}[kind]
    rows, before, seen = zlib.decompress(packed), bytes(width * size), set()
    for y in range(height):
        start = y * (width * size + 1)
        row = bytearray(rows[start + 1:start + 1 + width * size])
        filtered = rows[start]
        for i, value in enumerate(row):
            left = row[i - size] if i >= size else 0
            above = before[i]
            corner = before[i - size] if i >= size else 0
            if filtered == 4:
                guess = left + above - corner
                near = min((abs(guess - left), 0, left), (abs(guess - above), 1, above),
                           (abs(guess - corner), 2, corner))
                row[i] = value + near[2] & 255
            else:
                row[i] = value + (0, left, above, (left + above) // 2)[filtered] & 255
        before = bytes(row)
        seen.update(before[i:i + 3] for i in range(0, len(before), size * 7))
    return seen


class Window(harness.Process):
    """graphics_client in a window; it writes its files and settings into `folder`."""

    def __init__(self, folder, display, *arguments):
        self.folder = folder
        self.env = {"DISPLAY": display.name, "LP_NUM_THREADS": "1", "XDG_CONFIG_HOME": str(folder / "settings"),
                    **harness.FOREIGN_CODE}
        super().__init__([harness.BIN / "graphics_client", "--size", f"{WIDTH}x{HEIGHT}", "--fps-limit", "10", *arguments],
                         env=self.env, cwd=folder)

    def do(self, *events):
        subprocess.run(["xdotool", *map(str, events)], env={**os.environ, **self.env}, check=True)

    def find_windows(self, title):
        found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", f"^{re.escape(title)}$"],
                               env={**os.environ, **self.env}, capture_output=True, text=True, check=False)
        return found.stdout.split()

    def focus(self, title="Haptic viewer"):
        """There is no window manager to give a window the focus."""
        window = harness.wait_until(lambda: self.find_windows(title), harness.START_TIMEOUT_S,
                                    lambda: f"no window {title!r}:\n{self.text()}")[0]
        self.do("windowfocus", "--sync", window)

    def press(self, *keys):
        self.focus()
        for key in keys:
            self.do("key", key)

    def type_into(self, title, text):
        """Into the field that has the focus when the dialog opens, in place of what is there."""
        self.focus(title)
        self.do("key", "ctrl+a")
        self.do("type", "--delay", 5, text)
        self.do("key", "Return")

    def count(self, pattern):
        return sum(bool(re.search(pattern, line)) for line in [*self.lines, *self.errors])

    def wait_for(self, pattern, times=1):
        harness.wait_until(lambda: self.count(pattern) >= times, harness.START_TIMEOUT_S,
                           lambda: f"said less than {times} times {pattern!r}:\n{self.text()}")

    def wait_for_scene(self):
        self.wait_for(r"^scene revision \d+ root \w+ equal$")
        time.sleep(2)  # until the objects are drawn, and the camera shows them


class ViewerSession(harness.EndToEnd):
    def open_window(self, *arguments):
        window = Window(self.folder, self.start_display(), *arguments)
        self.addCleanup(window.kill)
        return window

    def test_says_that_the_server_is_gone_until_it_is_back(self):
        server = self.start_server()
        window = self.open_window("--connect", server.address)
        window.wait_for_scene()
        server.kill()
        window.wait_for(r"connection: The server is gone; trying again\. Edits wait until it is back\.")
        again = self.start_server(listen=server.address)
        window.wait_for(r"connection: nothing$")
        again.ctl("apply", "-", text='operations { remove { object { name: "box" } } }')
        window.wait_for(r"^scene revision 2 root \w+ equal$")
        self.assertEqual(window.stop(), 0, window.text())

    def test_tells_one_who_may_only_look_that_edits_and_leading_are_refused(self):
        credentials = harness.make_credentials(self.folder / "credentials")
        server = self.start_server(credentials=credentials)
        window = self.open_window("--connect", server.address, "--credentials", credentials / "viewer.credentials")
        window.wait_for_scene()
        window.focus()
        window.do("mousemove", 30, 74, "click", 1)  # the first of the list
        time.sleep(0.5)
        window.press("Delete")
        window.wait_for(r"^[^ ]+ warning delete \w+: .*(edit|role)")
        self.assertEqual(server.ctl("status").json()["revision"], 1)
        window.do("mousemove", 700, 330, "mousedown", 1)
        self.addCleanup(window.do, "mouseup", 1)
        window.wait_for(r"^[^ ]+ warning hand: .*(edit|role)")
        self.assertEqual(server.ctl("status").json()["hand_leader"], "")

    def test_says_in_words_what_is_refused_and_connects_to_another_server(self):
        credentials = harness.make_credentials(self.folder / "credentials")
        secured = self.start_server(credentials=credentials)
        token = credentials / "viewer.credentials"
        wrong = self.folder / "wrong.credentials"
        wrong.write_text(token.read_text().replace(harness.token_of(token).hex(), "0" * 64))
        window = self.open_window("--connect", secured.address, "--credentials", wrong)
        window.wait_for(r"connection: refused by the server: hello\.token: is not one that this server knows")

        window.press("ctrl+k")
        window.type_into("Connect", "127.0.0.1:port")
        window.wait_for(r'connect: 127\.0\.0\.1:port: "port" is not a port')
        plain = self.start_server()
        window.type_into("Connect", plain.address)
        window.wait_for_scene()
        window.wait_for(r"connection: nothing$")
        settings = (self.folder / "settings/haptics/graphics_client.conf").read_text()
        self.assertIn(plain.address, settings)

        window.press("ctrl+shift+k")
        window.wait_for(r"connection: Not connected to a server")
        self.assertEqual(window.stop(), 0, window.text())

    def test_asks_before_edits_are_lost_that_are_in_no_file(self):
        server = self.start_server()
        window = self.open_window("--connect", server.address)
        window.wait_for_scene()
        window.do("mousemove", 30, 74, "click", 1)
        time.sleep(0.5)
        window.press("Delete")
        harness.wait_until(lambda: server.status()["revision"] == 2, 10, "the object is not deleted")
        time.sleep(0.5)
        window.press("q")
        window.wait_for(r"asks: Quitting leaves edits of yours behind")
        window.focus("Save the scene?")
        window.do("key", "Escape")
        time.sleep(0.5)
        self.assertTrue(window.alive(), window.text())

        window.press("ctrl+s")
        file = self.folder / "kept.scene"
        window.type_into("Save scene as", str(file))
        window.wait_for(r"saved .*kept\.scene")
        kept = set(re.findall(r'^    name: "(\w+)"', file.read_text(), re.MULTILINE))
        self.assertEqual(kept, {thing["name"] for thing in server.ctl("get").json()["object"]})
        self.assertEqual(len(kept), 1)
        window.press("q")
        self.assertEqual(window.wait(), 0, window.text())
        self.assertEqual(window.count("asks: "), 1)

    def test_a_server_that_is_started_anew_loses_no_edit_and_overwrites_no_file(self):
        def names(file):
            return set(re.findall(r'^    name: "(\w+)"', file.read_text(), re.MULTILINE))
        first, lost, second = (self.folder / f"{name}.scene" for name in ("first", "lost", "second"))
        server = self.start_server()
        window = self.open_window("--connect", server.address)
        window.wait_for_scene()
        window.press("ctrl+s")
        window.type_into("Save scene as", str(first))
        window.wait_for(r"saved .*first\.scene")
        window.do("mousemove", 30, 74, "click", 1)
        time.sleep(0.5)
        window.press("Delete")
        harness.wait_until(lambda: server.status()["revision"] == 2, 10, "the object is not deleted")
        kept = {thing["name"] for thing in server.ctl("get").json()["object"]}
        time.sleep(0.5)

        server.kill()
        again = self.start_server(listen=server.address)
        window.wait_for(r"asks: The server was started anew")
        window.focus("Save what was shown before?")
        window.do("key", "Return")
        window.type_into("Save scene as", str(lost))
        window.wait_for(r"saved .*lost\.scene")
        self.assertEqual(names(lost), kept)
        again.ctl("apply", "-", text=f'operations {{ remove {{ object {{ name: "{min(kept)}" }} }} }}')
        window.wait_for(r"^scene revision 2 root \w+ equal$", 2)
        window.press("ctrl+s")
        window.type_into("Save scene as", str(second))
        window.wait_for(r"saved .*second\.scene")
        self.assertEqual((names(first) - names(lost), names(first) - names(second)), (names(first) - kept, {min(kept)}))

    def test_a_signal_ends_it_without_a_question(self):
        server = self.start_server()
        window = self.open_window("--connect", server.address)
        window.wait_for_scene()
        window.do("mousemove", 30, 74, "click", 1)
        time.sleep(0.5)
        window.press("Delete")
        harness.wait_until(lambda: server.status()["revision"] == 2, 10, "the object is not deleted")
        self.assertEqual(window.stop(), 0, window.text())

    def test_saves_the_last_seconds_and_replays_them_without_a_server(self):
        server = self.start_server()
        window = self.open_window("--connect", server.address)
        window.wait_for_scene()
        window.press("ctrl+r")
        window.wait_for(r"Save the last 10 seconds: .*\.haptics is written on the server's machine")
        recording = next((self.folder / "recordings").glob("*.haptics"))
        window.press("ctrl+shift+o")
        window.type_into("Open recording", str(recording))
        window.wait_for(r"replay of .*\.haptics, 0\.00 s of \d+\.\d\d s; every force is the same bit for bit")
        window.press("space", "comma")
        window.do("mousemove", 30, 74, "click", 1)
        time.sleep(0.5)
        window.press("Delete")
        window.wait_for(r"delete \w+: a replay is shown; go back to the server first")
        window.press("ctrl+b")
        window.wait_for(r"back to the server")
        self.assertEqual(server.status()["revision"], 1)
        self.assertEqual(window.stop(), 0, window.text())
        server.kill()

        window = self.open_window("--recording", recording)
        window.wait_for(r"replay of .*every force is the same bit for bit")
        time.sleep(2)
        window.press("space", "s")
        picture = self.folder / "haptic_view_1.png"
        harness.wait_until(picture.exists, 10, "no picture")
        time.sleep(0.5)
        self.assertGreater(len(colours(picture)), 200)
        self.assertEqual(window.count("connection: "), 0, "it was told of no server")
        self.assertEqual(window.stop(), 0, window.text())

    def test_refuses_in_words_what_is_no_recording(self):
        file = self.folder / "no.haptics"
        file.write_text("operations {}\n")
        window = self.open_window("--recording", file, "--seconds", 6)
        window.wait_for(r"Open recording: .*no\.haptics.*no recording")
        self.assertEqual(window.wait(), 1, window.text())


if __name__ == "__main__":
    unittest.main()
