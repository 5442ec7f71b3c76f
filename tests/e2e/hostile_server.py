"""hapticctl and the viewer against servers that mean no good: they end with a reason, and leave the terminal alone."""
import re
import subprocess
import sys
import unittest

import harness

sys.path.insert(0, str(harness.Path(__file__).resolve().parents[1] / "graphics_client/script/python"))
from haptics.v1 import envelope_pb2  # noqa: E402
from scripted_server import ScriptedServer, an_object, framed, greeting, say, snapshot, welcome  # noqa: E402

EVIL = "a\x1b[2J\x1b]0;owned\x07\r\nFORGED \x7f\x9b31m\u202e Größe"
ESCAPED = r"a\x1b[2J\x1b]0;owned\x07\x0d\x0aFORGED \x7f\x9b31m\u202e Größe"
UNSAFE = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]")


class HostileServer(harness.EndToEnd):
    def serve(self, *said, answer=lambda envelope: b""):
        server = ScriptedServer(framed(*said), answer)
        self.addCleanup(server.close)
        return server

    def ctl(self, server, *arguments, timeout_s=10):
        done = subprocess.run([harness.BIN / "hapticctl", "--connect", server.address, "--timeout", str(timeout_s),
                               *arguments], stdin=subprocess.DEVNULL, capture_output=True, timeout=harness.STOP_TIMEOUT_S)
        said = (done.stdout + done.stderr).decode()
        self.assertIsNone(UNSAFE.search(said), said)
        return done.returncode, said

    def test_a_refusal_does_not_reach_the_terminal_raw(self):
        server = self.serve(say(refusal=envelope_pb2.Refusal(field=EVIL, reason=EVIL)))
        code, said = self.ctl(server, "get")
        self.assertEqual(code, 3)
        self.assertIn(f"refused by the server: {ESCAPED}: {ESCAPED}\n", said)

    def test_nor_does_what_it_answers(self):
        def answer(envelope):
            kind = envelope.WhichOneof("body")
            if kind == "status_request":
                return framed(say(status=envelope_pb2.Status(device=EVIL, fault=99, device_fault=99)))
            if kind == "dump_request":
                return framed(say(dump_reply=envelope_pb2.DumpReply(file=EVIL)))
            if kind == "edit_request":
                reply = envelope_pb2.EditReply(client_seq=envelope.edit_request.client_seq)
                reply.accepted.revision = 1
                reply.accepted.report.append(EVIL)
                reply.accepted.object.add().name = EVIL
                return framed(say(edit_reply=reply), say(edit_live=envelope_pb2.EditLive(client_seq=reply.client_seq)))
            return b""
        server = self.serve(*greeting([an_object(1)]), answer=answer)
        scene = self.folder / "change.scene"
        scene.write_text('operations { remove { object { name: "object_1" } } }')
        for verb in (["status"], ["dump"], ["apply", str(scene)]):
            with self.subTest(verb=verb):
                code, said = self.ctl(server, *verb)
                self.assertEqual(code, 0, said)
                self.assertIn(ESCAPED, said)
                code, said = self.ctl(server, "--json", *verb)
                self.assertEqual(code, 0, said)
                self.assertIn("\\u001b[2J", said)

    def test_one_that_never_answers_is_given_up(self):
        server = self.serve(*greeting([an_object(1)]))
        scene = self.folder / "change.scene"
        scene.write_text('operations { remove { object { name: "object_1" } } }')
        for verb in (["status"], ["dump"], ["apply", str(scene)]):
            with self.subTest(verb=verb):
                code, said = self.ctl(server, *verb, timeout_s=1)
                self.assertEqual(code, 3)
                self.assertIn("no answer within 1 s", said)

    def test_a_clients_name_makes_no_line_of_the_log(self):
        server = self.start_server()
        client = harness.WireClient(server)
        self.addCleanup(client.close)
        client.send_envelope(harness.hello_envelope("x\r\n06:00:00.000 error tick 1: FORGED \x1b[31m"))
        client.receive_envelope()
        client.close()
        harness.wait_until(lambda: any(" left" in line or "client_name" in line for line in server.errors), 10, server.text)
        for line in server.errors:
            self.assertFalse(line.startswith("06:00:00.000"), line)
            self.assertIsNone(UNSAFE.search(line.removesuffix("\r")), line)

    def test_a_scene_beyond_what_a_client_holds(self):
        begin = snapshot()[0]
        begin.snapshot_begin.object_count = 1 << 40
        server = self.serve(welcome(), begin)
        code, said = self.ctl(server, "get")
        self.assertEqual(code, 3)
        self.assertIn("more than 1024 objects", said)
        viewer = harness.Process([harness.BIN / "graphics_client", "--connect", server.address, "--offscreen", "--size",
                                  "320x256", "--seconds", "3"],
                                 env={"DISPLAY": self.start_display().name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE})
        self.addCleanup(viewer.kill)
        self.assertEqual(viewer.wait(), 3, viewer.text())
        self.assertIn("more than 1024 objects", viewer.text())


if __name__ == "__main__":
    unittest.main()
