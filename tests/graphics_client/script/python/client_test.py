"""The Python client against servers that are hostile, newer, or gone."""
import concurrent.futures
import gc
import hashlib
import math
import os
import struct
import tempfile
import threading
import time
import unittest
import wave
import weakref
from unittest import mock

import haptic_assets
import haptic_client
import haptic_edits
import haptic_recording
import haptic_scene
from haptic_client import Client, Closed, Refused, Rejected
from haptic_text import printable
from haptics import scene
from haptics.v1 import envelope_pb2, recording_pb2, scene_pb2, telemetry_pb2
from scripted_server import (NOTHING, ScriptedServer, an_object, framed, greeting, root_of, say, snapshot, welcome)

SOON_S = 20  # no test's verdict: only how long a broken one takes


def accept(revision):
    """Each edit is accepted as this revision."""
    def answer(envelope):
        if envelope.WhichOneof("body") != "edit_request":
            return b""
        reply = envelope_pb2.EditReply(client_seq=envelope.edit_request.client_seq)
        reply.accepted.revision = revision
        return framed(say(edit_reply=reply))
    return answer


def newer(state):
    """The state as a newer server could send it: with a field, and a texture's family, that nobody here knows."""
    state.texture.law = 77
    state.texture.field.MergeFromString(b"\xfa\x01\x02ab")  # field 31
    return scene_pb2.ObjectState.FromString(state.SerializeToString() + b"\xa2\x06\x03new")  # field 100


class ClientTest(unittest.TestCase):
    def setUp(self):
        self.died = []
        for name, value in (("RECONNECT_S", (0.001, 0.01)), ("REFUSED_RECONNECT_S", 0.02)):
            self.patch(haptic_client, name, value)
        self.patch(threading, "excepthook", lambda given: self.died.append(given))
        self.addCleanup(lambda: self.assertEqual(self.died, []))

    def patch(self, module, name, value):
        patched = mock.patch.object(module, name, value)
        patched.start()
        self.addCleanup(patched.stop)

    def server(self, *said, answer=lambda envelope: b""):
        server = ScriptedServer(b"".join(part if isinstance(part, bytes) else framed(part) for part in said), answer)
        self.addCleanup(server.close)
        return server

    def client(self, server, **options):
        client = Client(server.address, **options)
        self.addCleanup(client.close)
        return client

    def live(self, *said, answer=lambda envelope: b"", **options):
        server = self.server(*said, answer=answer)
        client = self.client(server, **options)
        client.wait_live(SOON_S)
        return server, client

    def until(self, condition):
        end = time.monotonic() + SOON_S
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.005)

    def assert_turned_down(self, why, *said):
        """The client does not go live, says why, tries again, and is live at once when the server has come to reason."""
        server = self.server(*said)
        client = self.client(server)
        self.until(lambda: server.connections > 3)
        with self.assertRaises(Refused) as refused:
            client.wait_live(0)
        self.assertIn(why, str(refused.exception))
        server.script = framed(*greeting([an_object(1)]))
        self.until(lambda: client.objects())
        client.wait_live(SOON_S)


class MalformedData(ClientTest):
    def test_objects_before_their_beginning(self):
        self.assert_turned_down("objects came without its beginning", welcome(), snapshot([an_object(1)])[1])

    def test_an_end_before_its_beginning(self):
        self.assert_turned_down("ended without its beginning", welcome(), snapshot()[-1])

    def test_a_field_of_no_family(self):
        broken = an_object(1)
        broken.texture.field.SetInParent()
        self.assert_turned_down('object "object_1" is not whole', welcome(), *snapshot([broken], root=NOTHING))

    def test_resuming_a_client_that_holds_nothing(self):
        self.assert_turned_down("resumes what this client lacks", welcome(resumed=True))

    def test_a_commit_before_the_snapshot(self):
        commit = scene_pb2.Commit(revision=1, prev_root=NOTHING, root=root_of(1, []))
        self.assert_turned_down("a commit came before the snapshot", welcome(), say(commit=commit))

    def test_a_second_welcome(self):
        self.assert_turned_down("second welcome", welcome(), welcome(), *snapshot())

    def test_a_welcome_of_another_version(self):
        other = welcome()
        other.protocol_version = 2
        self.assert_turned_down("speaks version 2", other, *snapshot())

    def test_a_snapshot_that_is_not_the_one_that_was_begun(self):
        begin, *objects, end = snapshot([an_object(1), an_object(2)])
        self.assert_turned_down("not the one that was begun", welcome(root=end.snapshot_end.root), begin, objects[0], end)

    def test_an_object_twice(self):
        self.assert_turned_down("twice", welcome(), *snapshot([newer(an_object(1)), newer(an_object(1))]))

    def test_another_root_than_the_welcomes(self):
        self.assert_turned_down("the welcome's root", welcome(root=bytes(32)), *snapshot())

    def test_bytes_that_are_no_message(self):
        self.assert_turned_down("a frame of 0 bytes", b"\0\0\0\0")
        self.assert_turned_down("a frame of 4294967295 bytes", b"\xff\xff\xff\xff")
        self.assert_turned_down("does not speak this protocol", b"\2\0\0\0\xff\xff")
        with self.assertWarns(RuntimeWarning):  # protobuf's own
            self.assert_turned_down("more than its message", b"\4\0\0\0\x08\1\x0c\7")


class NewerServer(ClientTest):
    def test_what_it_adds_is_kept_and_named(self):
        known, unknown = an_object(1), newer(an_object(2))
        root = root_of(1, [known, unknown])
        server, client = self.live(*greeting([known, unknown], revision=1))
        self.assertEqual(client.unknown_objects(), ["object_2"])
        self.assertEqual(client.objects()["object_2"], unknown)
        self.assertEqual(client.revision_and_root(), (1, root.hex()))
        commit = scene_pb2.Commit(revision=2, prev_root=root, removed=[2], root=root_of(2, [known]))
        server.send(framed(say(commit=commit)))
        self.until(lambda: client.revision_and_root() == (2, root_of(2, [known]).hex()))
        self.assertEqual((client.unknown_objects(), client.resyncs), ([], 0))

    def test_a_message_an_answer_and_a_feature_of_a_kind_that_nobody_knows(self):
        sample = telemetry_pb2.Telemetry(tick=1, energy=[telemetry_pb2.FeatureEnergy(object=1, feature=99, energy_J=2)])
        unknown = b"\x0a\0\0\0\x08\x01\xf2\x07\x05other"  # field 126
        server, client = self.live(*greeting([an_object(1)]), unknown, say(telemetry=sample),
                                   answer=lambda envelope: framed(say(edit_reply=envelope_pb2.EditReply(client_seq=1)))
                                   if envelope.WhichOneof("body") == "edit_request" else b"")
        self.assertEqual(client.gave_most(next(client.samples(SOON_S))), ("object_1", "feature 99", 2))
        with self.assertRaises(Rejected) as rejected:
            client.submit(scene_pb2.Transaction()).result(SOON_S)
        self.assertEqual(rejected.exception.field, "edit_reply")
        self.assertEqual(server.connections, 1)

    def test_an_answer_that_cannot_be_read_ends_its_edit_at_the_second_time(self):
        server, client = self.live(*greeting(), answer=lambda envelope: b"\x04\0\0\0\x08\x01\x0a\x05"
                                   if envelope.WhichOneof("body") == "edit_request" else b"")
        with self.assertRaises(Rejected) as rejected:
            client.submit(scene_pb2.Transaction()).result(SOON_S)
        self.assertEqual(rejected.exception.field, "edit_reply")
        self.assertEqual(sum(envelope.HasField("edit_request") for envelope in server.heard), 2)


class LargeEdits(ClientTest):
    def test_an_edit_that_does_not_fit_a_frame_is_refused_at_once_and_the_next_one_goes_through(self):
        server, client = self.live(*greeting(), answer=accept(1))
        large = scene_pb2.Transaction()
        large.operations.add().remove.object.name = "x" * haptic_edits.MAX_TRANSACTION_BYTES
        with self.assertRaises(Rejected) as rejected:
            client.submit(large).result(0)
        self.assertEqual(rejected.exception.field, "transaction")
        self.assertIn("1 MiB", str(rejected.exception))
        self.assertEqual(client.submit(scene_pb2.Transaction()).result(SOON_S).revision, 1)
        self.assertEqual(server.connections, 1)

    def test_the_largest_that_fits_goes_through(self):
        server, client = self.live(*greeting(), answer=accept(1))
        large = scene_pb2.Transaction()
        name = large.operations.add().remove.object
        name.name = "x" * (haptic_edits.MAX_TRANSACTION_BYTES - 100)
        name.name += "x" * (haptic_edits.MAX_TRANSACTION_BYTES - large.ByteSize())
        self.assertEqual(large.ByteSize(), haptic_edits.MAX_TRANSACTION_BYTES)
        self.assertEqual(client.submit(large).result(SOON_S).revision, 1)
        self.assertEqual(server.connections, 1)

    def test_one_edit_too_many_is_refused(self):
        _, client = self.live(*greeting())
        self.patch(haptic_edits, "MAX_PENDING", 3)
        for _ in range(3):
            client.submit(scene_pb2.Transaction())
        with self.assertRaises(Rejected) as rejected:
            client.submit(scene_pb2.Transaction()).result(0)
        self.assertIn("3 edits wait", str(rejected.exception))


class Waits(ClientTest):
    @staticmethod
    def begin(wait):
        """Of what comes of wait()."""
        outcome = concurrent.futures.Future()

        def run():
            try:
                outcome.set_result(wait())
            except Exception as error:
                outcome.set_exception(error)
        threading.Thread(target=run, daemon=True).start()
        return outcome

    def waits(self):
        """A client, and waits without a timeout that nobody answers."""
        server, client = self.live(*greeting(), answer=accept(1))
        accepted = client.submit(scene_pb2.Transaction())
        accepted.result(SOON_S)
        server.answer = lambda envelope: b""
        waits = [self.begin(client.submit(scene_pb2.Transaction()).result), self.begin(accepted.live_since_tick),
                 self.begin(lambda: client.upload(haptic_assets.FIELD, b"1", None)),
                 self.begin(lambda: list(client.samples()))]
        time.sleep(0.05)
        self.assertFalse(any(wait.done() for wait in waits))
        return client, waits

    def test_closing_the_client_ends_them(self):
        client, (*answers, samples) = self.waits()
        client.close()
        for answer in answers:
            self.assertIsInstance(answer.exception(SOON_S), Closed)
        self.assertEqual(samples.result(SOON_S), [])
        late = client.submit(scene_pb2.Transaction())
        for wait in (late.result, late.live_since_tick, lambda: client.upload(haptic_assets.FIELD, b"1", None)):
            self.assertIsInstance(self.begin(wait).exception(SOON_S), Closed)
        self.assertIsInstance(self.begin(lambda: client.wait_live(None)).exception(SOON_S), Refused)

    def test_a_thread_that_fails_ends_them(self):
        client, waits = self.waits()
        self.patch(client, "_lost", mock.Mock(side_effect=SystemExit))
        self.patch(client, "_send_edits", mock.Mock(side_effect=MemoryError))
        for wait in waits:
            self.assertIn("failed", str(wait.exception(SOON_S)))
        with self.assertRaises(Refused) as refused:
            client.wait_live(None)
        self.assertIn("failed", str(refused.exception))
        self.assertEqual([died.exc_type for died in self.died], [SystemExit])
        self.died.clear()

    def test_closing_ends_the_wait_for_a_server_that_never_speaks(self):
        client = self.client(self.server())
        wait = self.begin(lambda: client.wait_live(None))
        time.sleep(0.05)
        client.close()
        self.assertIsInstance(wait.exception(SOON_S), Refused)

    def test_a_timeout_says_why_there_is_no_answer(self):
        server, client = self.live(*greeting())
        edit = client.submit(scene_pb2.Transaction())
        server.script = framed(say(heartbeat=envelope_pb2.Heartbeat()))
        server.hang_up()
        self.until(lambda: server.connections > 1 and "before its welcome" in client._trouble)
        for wait in (edit.result, edit.live_since_tick, lambda timeout_s: client.upload(haptic_assets.FIELD, b"1", timeout_s)):
            with self.assertRaises(TimeoutError) as timeout:
                wait(0.02)
            self.assertRegex(str(timeout.exception), "no answer within 0.02 s: .*before its welcome")

    def test_what_a_caller_has_cancelled_does_not_harm_the_others(self):
        server, client = self.live(*greeting())
        cancelled = client.submit(scene_pb2.Transaction())
        self.until(lambda: any(said.WhichOneof("body") == "edit_request" for said in server.heard))
        cancelled.reply.cancel()
        reply = envelope_pb2.EditReply(client_seq=1)
        reply.accepted.revision = 1
        server.answer = accept(1)
        server.send(framed(say(edit_reply=reply)))
        client.submit(scene_pb2.Transaction()).result(SOON_S)
        self.assertEqual(server.connections, 1)

    def test_news_that_an_edit_is_live_do_not_come_before_its_answer(self):
        live = framed(say(edit_live=envelope_pb2.EditLive(client_seq=1, tick=9)))
        _, client = self.live(*greeting(), answer=lambda envelope: live + accept(1)(envelope) + live)
        self.assertEqual(client.apply(scene_pb2.Transaction(), SOON_S)[1], 9)

    def test_a_file_beside_a_scene_that_has_to_be_imported_is_said_to_be_hapticctls(self):
        def reject(envelope):
            reply = envelope_pb2.EditReply(client_seq=1)
            reply.rejected.field, reply.rejected.reason = "operations[0].add.mesh.file", "is not here"
            return framed(say(edit_reply=reply)) if envelope.WhichOneof("body") == "edit_request" else b""
        with tempfile.TemporaryDirectory() as folder:
            beside = scene.Scene(folder=folder)
            beside.add(name="part", mesh={"file": "part.stl"})
            for is_there in (False, True):
                if is_there:
                    open(os.path.join(folder, "part.stl"), "w").close()
                _, client = self.live(*greeting(), answer=reject)
                with self.assertRaises(Rejected) as rejected:
                    client.apply(beside, SOON_S)
                self.assertEqual("hapticctl" in str(rejected.exception), is_there)
                self.assertIn("is not here", str(rejected.exception))

    def test_what_the_server_puts_off_for_ever_is_given_up(self):
        def put_off(envelope):
            if envelope.WhichOneof("body") == "edit_request":
                reply = envelope_pb2.EditReply(client_seq=1)
                reply.rejected.reason, reply.rejected.retry_after_ms = "too early", 1
                return framed(say(edit_reply=reply))
            if envelope.WhichOneof("body") == "asset_upload":
                return framed(say(asset_upload_reply=envelope_pb2.AssetUploadReply(
                    hash=envelope.asset_upload.chunk.hash, reason="no room", retry_after_ms=1)))
            return b""
        _, client = self.live(*greeting(), answer=put_off)
        for module in (haptic_edits, haptic_assets):
            self.patch(module, "PATIENCE_S", 0.2)
        self.assertIn("too early", str(self.begin(client.submit(scene_pb2.Transaction()).result).exception(SOON_S)))
        upload = self.begin(lambda: client.upload(haptic_assets.FIELD, b"1", None))
        self.assertIn("no room", str(upload.exception(SOON_S)))

    def test_what_no_edit_has_named_is_uploaded_again_before_one_does(self):
        heard = []
        def accept(envelope):
            body = envelope.WhichOneof("body")
            if body == "asset_upload":
                heard.append(body)
                return framed(say(asset_upload_reply=envelope_pb2.AssetUploadReply(
                    hash=envelope.asset_upload.chunk.hash, accepted=True)))
            if body == "edit_request":
                heard.append(body)
                reply = envelope_pb2.EditReply(client_seq=envelope.edit_request.client_seq)
                reply.rejected.reason = "no"
                return framed(say(edit_reply=reply))
            return b""
        server, client = self.live(*greeting(), answer=accept)
        client.upload(haptic_assets.FIELD, b"1", SOON_S)
        server.hang_up()
        self.assertIn("no", str(self.begin(client.submit(scene_pb2.Transaction()).result).exception(SOON_S)))
        self.until(lambda: len(heard) > 2)
        self.assertEqual(heard[:3], ["asset_upload", "asset_upload", "edit_request"])

    def test_what_comes_during_an_upload_is_read(self):
        data = bytes(16 << 20)
        flood = framed(say(asset_chunk=envelope_pb2.AssetChunk(data=bytes(1_000_000)))) * 16

        def answer(envelope):
            if envelope.WhichOneof("body") != "asset_upload":
                return b""
            chunk = envelope.asset_upload.chunk
            held = envelope_pb2.AssetUploadReply(hash=chunk.hash, accepted=True)
            if not chunk.offset:
                return flood  # more than lies between the two
            return framed(say(asset_upload_reply=held)) if chunk.offset + len(chunk.data) == len(data) else b""
        server = self.server(*greeting(), answer=answer)
        with Client(server.address) as client:
            client.upload(haptic_assets.FIELD, data, SOON_S)
            self.assertEqual(client.connections, 1)

    def test_an_accepted_edit_is_not_lost_where_the_scene_is_asked_for_anew(self):
        server = self.server(*greeting(), answer=accept(2))
        with Client(server.address) as client:
            edit = client.submit(scene_pb2.Transaction())
            edit.result(SOON_S)
            server.send(framed(say(heartbeat=envelope_pb2.Heartbeat(revision=0, root=b"x" * 32))))
            self.until(lambda: client.resyncs and client.connections == 2)
            server.send(framed(say(edit_live=envelope_pb2.EditLive(client_seq=edit.request.client_seq, tick=7))))
            self.assertEqual(edit.live_since_tick(SOON_S), 7)

    def test_a_hand_that_nobody_waits_for_is_not_asked_for_after_a_reconnect(self):
        server = self.server(*greeting())
        with Client(server.address, telemetry_hz=100) as client:
            self.patch(haptic_client, "RECONNECT_S", (0.5, 0.5))
            server.hang_up()
            self.until(lambda: not client._live)
            with self.assertRaises(haptic_client.NotLeading), client.hand():
                pass
            self.until(lambda: client._live)
            client.submit(scene_pb2.Transaction())  # goes after whatever is said of the hand
            self.until(lambda: any(each.HasField("edit_request") for each in server.heard))
            self.assertFalse(any(each.HasField("lead_hand") for each in server.heard))

    def test_what_cannot_be_sent_is_the_callers_error(self):
        server, client = self.live(*greeting())
        with self.assertRaises((TypeError, ValueError)):
            client.upload("mesh", b"1")
        with self.assertRaises(haptic_assets.UploadRefused):
            client.upload(haptic_assets.FIELD, b"")
        for options in ({"name": 7}, {"telemetry_hz": "fast"}):
            with self.assertRaises((TypeError, ValueError)):
                self.client(server, **options)
        self.assertEqual(server.connections, 1)


class Bounds(ClientTest):
    def assert_left(self, limit, *said):
        """The client leaves the server, names the limit, and holds nothing."""
        client = self.client(self.server(*said))
        with self.assertRaises(Refused) as refused:
            client.wait_live(SOON_S)
        self.assertIn(limit, str(refused.exception))
        self.assertEqual(client.objects(), {})

    def test_of_objects(self):
        self.patch(haptic_scene, "MAX_OBJECTS", 3)
        objects = [an_object(number) for number in range(1, 5)]
        self.assert_left("more than 3 objects", *greeting(objects))
        first, *_ = snapshot([])
        first.snapshot_begin.object_count = 1 << 60
        self.assert_left("more than 3 objects", welcome(), first)
        root = root_of(0, objects[:3])
        commit = scene_pb2.Commit(revision=1, prev_root=root, put=objects[3:], root=root_of(1, objects))
        ahead = [welcome(1, root_of(1, objects)), *snapshot(objects[:3]), say(commit=commit)]
        self.assert_left("more than 3 objects", *ahead)

    def test_of_the_records_bytes(self):
        self.patch(haptic_scene, "MAX_SCENE_BYTES", 3 << 20)
        large = [an_object(number) for number in range(1, 6)]
        for state in large:
            state.name = "x" * 900_000
        self.assert_left("more than 3 MiB", *greeting(large))

    def test_of_samples_that_nobody_takes(self):
        self.patch(haptic_client, "MAX_KEPT_SAMPLES", 50)
        self.patch(haptic_client, "MAX_KEPT_BYTES", 100_000)
        for size, kept in ((0, 50), (9_900, 10)):
            samples = [say(telemetry=telemetry_pb2.Telemetry(
                tick=tick, dent=[telemetry_pb2.Dent(centre=[0.5] * (size // 4))])) for tick in range(1, 101)]
            _, client = self.live(*greeting(), *samples)
            self.until(lambda: client._tick == 100)
            self.assertEqual([sample.tick for sample in client.samples(0)], [*range(101 - kept, 101)])
            self.assertEqual(list(client.samples(0)), [])

    def test_of_every_tick_those_that_nobody_takes_are_named(self):
        self.patch(haptic_client, "MAX_KEPT_SAMPLES", 50)
        batches = [say(telemetry_batch=telemetry_pb2.TelemetryBatch(sample=[
            telemetry_pb2.Telemetry(tick=tick, missed_ticks=3 if tick > 40 else 0) for tick in ticks if not 20 < tick <= 23]))
            for ticks in (range(1, 31), range(31, 101), range(111, 121))]
        server = self.server(*greeting(), *batches)
        client = self.client(server, every_tick=True)
        client.wait_live(SOON_S)
        self.until(lambda: client._tick == 120)
        self.assertEqual([sample.tick for sample in client.samples(0.2)], [*range(61, 101), *range(111, 121)])
        self.assertEqual(client.gaps, [haptic_client.Gap(0, 3, 57), haptic_client.Gap(100, 0, 10)])

    def test_of_bodies(self):
        moving = an_object(1)
        moving.motion.mass_kg = 1
        bodies = [telemetry_pb2.BodyPose(object=number) for number in range(1, 1000)]
        _, client = self.live(*greeting([moving, an_object(2)]), say(telemetry=telemetry_pb2.Telemetry(tick=1, body=bodies)))
        self.until(lambda: client._tick == 1)
        self.assertEqual((list(client.bodies()), list(client._bodies)), (["object_1"], [1]))

    def test_an_accepted_edits_answer_is_not_kept_by_the_client(self):
        _, client = self.live(*greeting(), answer=accept(1))
        edit = client.submit(scene_pb2.Transaction())
        edit.result(SOON_S)
        kept = weakref.ref(edit)
        del edit
        gc.collect()
        self.assertIsNone(kept())


class Text(ClientTest):
    def test_a_refusal_is_escaped(self):
        refusal = envelope_pb2.Refusal(field="a\x1b[2J", reason="\x1b]0;owned\x07\nline Größe \u202e\x9b")
        client = self.client(self.server(say(refusal=refusal)))
        with self.assertRaises(Refused) as refused:
            client.wait_live(SOON_S)
        self.assertEqual(str(refused.exception),
                         r"refused by the server: a\x1b[2J: \x1b]0;owned\x07\x0aline Größe \u202e\x9b")

    def test_what_is_wrong_with_an_edit_is_escaped(self):
        self.assertEqual(str(Rejected("a\nb", "\x1bc")), r"a\x0ab: \x1bc")
        self.assertEqual(str(haptic_client.Conflict("\x7f", [])), r"\x7f")
        self.assertEqual(str(haptic_assets.UploadRefused("f", "\u2066")), r"f: \u2066")

    def test_long_text_is_shortened(self):
        self.assertEqual(printable("x" * 10, 3), "xxx...")


class RecordingTest(unittest.TestCase):
    """What is in a file is anybody's."""

    def file_of(self, data):
        file = tempfile.NamedTemporaryFile(suffix=".haptics")
        self.addCleanup(file.close)
        file.write(data)
        file.flush()
        return file.name

    def recording_of(self, *payloads):
        data, chain = haptic_recording.HEAD, hashlib.sha256(haptic_recording.HEAD).digest()
        for payload in payloads:
            part = struct.pack("<I4x", len(payload)) + payload
            chain = hashlib.sha256(chain + part).digest()
            data += part + chain
        return self.file_of(data)

    def test_what_is_no_part_is_named(self):
        for payload in (b"\xff" * 8, b"\x0a\xff", b"\x01"):
            with self.assertRaisesRegex(haptic_recording.Damaged, "holds no RecordingPart before byte"):
                list(haptic_recording.parts(self.recording_of(payload)))

    def test_a_part_of_a_tick_is_named(self):
        whole = recording_pb2.RecordingPart()
        whole.ticks.ticks = bytes(haptic_recording.TICK.size)
        broken = recording_pb2.RecordingPart()
        broken.ticks.ticks = bytes(haptic_recording.TICK.size + 1)
        file = self.recording_of(whole.SerializeToString(), broken.SerializeToString())
        with self.assertRaisesRegex(haptic_recording.Damaged, "holds a part of a tick"):
            list(haptic_recording.ticks(file))

    def test_telemetry_that_ends_early_is_named(self):
        sample = telemetry_pb2.Telemetry(tick=1).SerializeToString()
        good = bytes([len(sample)]) + sample
        self.assertEqual([each.tick for each in haptic_recording.telemetry(self.file_of(good * 2))], [1, 1])
        for bad in (b"\x80", b"\xff" * 9, good[:-1], b"\x03abc", b"\x7f"):
            with self.assertRaises(haptic_recording.Damaged):
                list(haptic_recording.telemetry(self.file_of(good + bad)))


class Wav(unittest.TestCase):
    def written(self, channels, size, rate, data):
        file = tempfile.NamedTemporaryFile(suffix=".wav")
        self.addCleanup(file.close)
        with wave.open(file.name, "wb") as out:
            out.setparams((channels, size, rate, 0, "NONE", ""))
            out.writeframes(data)
        return file.name

    def test_its_samples_are_those_of_an_effect(self):
        for size, data in ((1, bytes((0, 128, 192))), (2, struct.pack("<3h", -32768, 0, 16384)),
                           (3, bytes((0, 0, 128, 0, 0, 0, 0, 0, 64)))):
            with self.subTest(size=size):
                self.assertEqual(scene.wav(self.written(1, size, 8000, data)), {"samples": [-1, 0, 0.5], "sample_rate_Hz": 8000})
        stereo = scene.wav(self.written(2, 2, 44100, struct.pack("<4h", 16384, 0, -32768, -32768)))
        self.assertEqual(stereo["samples"], [0.25, -1])
        self.assertEqual(list(scene.samples(**stereo, amplitude_N=1, direction=(0, 0, 1)).samples), [0.25, -1])

    def test_an_hour_is_refused_before_it_is_read(self):
        hour = self.written(1, 1, 8000, b"")
        with open(hour, "r+b") as file:
            for at in (4, 40):
                file.seek(at)
                file.write(struct.pack("<I", 8000 * 3600 + (36 if at == 4 else 0)))
        with self.assertRaisesRegex(ValueError, "has 3600 s at 8000 Hz; an effect has at most 65536 samples, 8.192 s at this rate"):
            scene.wav(hour)


class Spline(unittest.TestCase):
    POINTS = [(0, 0, 0), (0.02, 0.01, 0), (0.021, 0.03, 0.005), (0.06, 0.03, -0.01), (0.06, 0, 0)]

    @staticmethod
    def distance_from(path, place):
        nearest = math.inf
        for a, b in zip(path, path[1:]):
            side = [y - x for x, y in zip(a, b)]
            along = sum((z - x) * s for x, z, s in zip(a, place, side)) / sum(s * s for s in side)
            nearest = min(nearest, math.dist(place, [x + s * min(1, max(0, along)) for x, s in zip(a, side)]))
        return nearest

    @staticmethod
    def on_curve(four, part):
        """By Barry and Goldman's pyramid: knots as far apart as the roots of the distances."""
        knots = [0]
        for a, b in zip(four, four[1:]):
            knots.append(knots[-1] + math.dist(a, b) ** 0.5)
        t, row = knots[1] + part * (knots[2] - knots[1]), list(four)
        for level in (1, 2, 3):
            row = [[((knots[k + min(level, 2)] - t) * x + (t - knots[k + (level == 3)]) * y)
                    / (knots[k + min(level, 2)] - knots[k + (level == 3)]) for x, y in zip(row[k], row[k + 1])]
                   for k in range(len(row) - 1)]
        return row[0]

    def test_its_path_is_within_the_tolerance_of_the_curve(self):
        for tolerance_m in (1e-3, 1e-5):
            path = scene.spline(self.POINTS, tolerance_m=tolerance_m)
            self.assertLess(len(path), 30 if tolerance_m == 1e-3 else 200)
            for point in self.POINTS:
                self.assertLess(min(math.dist(point, p) for p in path), 1e-12)
            for k in range(len(self.POINTS) - 3):
                for part in range(101):
                    place = self.on_curve(self.POINTS[k:k + 4], part / 100)
                    self.assertLess(self.distance_from(path, place), tolerance_m)

    def test_a_closed_one_comes_back_without_a_corner(self):
        path = scene.spline(self.POINTS[:3], closed=True, tolerance_m=1e-8)
        self.assertLess(math.dist(path[0], path[-1]), 1e-15)
        first, last = ([b - a for a, b in zip(*two)] for two in (path[:2], path[-2:]))
        self.assertGreater(sum(a * b for a, b in zip(first, last)), 0.99 * math.hypot(*first) * math.hypot(*last))

    def test_a_straight_one_has_its_points(self):
        self.assertEqual(scene.spline([(0, 0, 0), (1, 0, 0)]), [(0, 0, 0), (1, 0, 0)])
        self.assertEqual(len(scene.guide(path_m=scene.spline(self.POINTS)).path_m) % 3, 0)

    def test_what_is_no_curve_is_said(self):
        for points, options, said in (([(0, 0, 0)], {}, "through two points or more"), (self.POINTS[:1] * 2, {}, "at one place"),
                                      (self.POINTS, {"tolerance_m": 1e-12}, "tolerance_m: 1e-12 asks for more points")):
            with self.assertRaisesRegex(ValueError, said):
                scene.spline(points, **options)


if __name__ == "__main__":
    unittest.main()
