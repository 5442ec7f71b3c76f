"""Ctrl-C while hapticctl sends a mesh: the scene stays as it was, and so does the server."""
import os
import pty
import signal
import subprocess
import unittest

import harness

SIDE = 300  # squares; some 6 MB of mesh, so that the upload takes a while
EXIT_INTERRUPTED, EXIT_NO_CONNECTION = 130, 3
SCENE = 'operations { add { name: "large" mesh { file: "large" } } }'


def write_grid(file):
    """A square sheet in two triangles a square."""
    with file.open("w") as stream:
        stream.write(f"OFF\n{(SIDE + 1) ** 2} {2 * SIDE ** 2} 0\n")
        for y in range(SIDE + 1):
            stream.writelines(f"{x * 1e-3} {y * 1e-3} 0\n" for x in range(SIDE + 1))
        for y in range(SIDE):
            for x in range(SIDE):
                a, b = y * (SIDE + 1) + x, (y + 1) * (SIDE + 1) + x
                stream.write(f"3 {a} {a + 1} {b + 1}\n3 {a} {b + 1} {b}\n")


class Terminal:
    """A program whose standard error is a terminal."""

    def __init__(self, command, text):
        self.screen, there = pty.openpty()
        self.process = subprocess.Popen([*map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                                        stderr=there, text=True)
        os.close(there)
        self.process.stdin.write(text)
        self.process.stdin.close()
        self.shown = ""

    def read_until(self, what):
        while what not in self.shown:
            try:
                piece = os.read(self.screen, 4096)
            except OSError:  # the program has ended
                raise AssertionError(f"never showed {what!r}:\n{self.shown}") from None
            self.shown += piece.decode()

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.screen)


class CancelledUpload(harness.EndToEnd):
    def apply(self, server, *options):
        terminal = Terminal([harness.BIN / "hapticctl", "--connect", server.address, *options, "apply", "-", "--upload",
                             f"large={self.folder / 'large.off'}"], SCENE)
        self.addCleanup(terminal.close)
        return terminal

    def test_ctrl_c_changes_nothing_and_it_may_be_sent_again(self):
        write_grid(self.folder / "large.off")
        server = self.start_server()
        before = server.status()
        terminal = self.apply(server)
        terminal.read_until("uploading large [")
        server.send(signal.SIGSTOP)  # a server that takes its time
        terminal.process.send_signal(signal.SIGINT)
        terminal.read_until("was cancelled")
        self.assertEqual(terminal.process.wait(harness.STOP_TIMEOUT_S), EXIT_INTERRUPTED, terminal.shown)
        server.send(signal.SIGCONT)
        self.assertEqual(server.status()["root"], before["root"])

        terminal = self.apply(server)
        terminal.read_until("100 % of")
        self.assertEqual(terminal.process.wait(harness.STOP_TIMEOUT_S), 0, terminal.shown)
        self.assertEqual(int(server.status()["revision"]), int(before["revision"]) + 1)
        self.stop_and_check(server)

    def test_a_lost_connection_is_no_refusal(self):
        write_grid(self.folder / "large.off")
        server = self.start_server()
        terminal = self.apply(server, "--timeout", "1")
        terminal.read_until("uploading large [")
        server.send(signal.SIGSTOP)  # before it has all
        server.kill()
        terminal.read_until("no connection")
        self.assertEqual(terminal.process.wait(60), EXIT_NO_CONNECTION, terminal.shown)


if __name__ == "__main__":
    unittest.main()
