"""Real processes for end-to-end tests: server, viewer, hapticctl, and a client that speaks the protocol by hand.

The programs are found in HAPTICS_BIN; the generated protocol modules are on PYTHONPATH. Waits are generous: a test fails
for what it sees, not for how long it took, except where the requirement is a time.
"""
import contextlib
import json
import os
import queue
import random
import re
import shutil
import signal
import socket
import ssl
import struct
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

BIN = Path(os.environ["HAPTICS_BIN"])
PROJECT = Path(__file__).resolve().parents[2]
START_TIMEOUT_S = 60
STOP_TIMEOUT_S = 240
PATIENCE = 5  # times as long as a quiet machine may take

# In sanitizer builds: Mesa and VTK were built without, and Mesa keeps what it allocated.
FOREIGN_CODE = {"TSAN_OPTIONS": "ignore_noninstrumented_modules=1", "ASAN_OPTIONS": "detect_leaks=0"}


def effects_of_every_kind():
    """In text format: each with every field that its kind uses, so that all of their hashes are compared."""
    pull = "stiffness_N_per_m: 50 damping_Ns_per_m: 0.5 limit_N: 1 "
    reach = pull + "reach_m: 0.01 release_m: 0.02 fade_m: 0.005 "
    point, direction, path = "point_m { x: 9 y: -0.0 z: 1e-9 } ", "direction { x: 0.6 y: -0.8 } ", "path_m: [9, 0, -0.0, 9, 9, 1e-9] "
    box = f"region: EFFECT_REGION_BOX {point} size_m {{ x: 1 y: 2 z: 3 }} fade_m: 0.1 "
    sphere = f"region: EFFECT_REGION_SPHERE {point} size_m {{ x: 0.1 }} "
    world, push = "frame: EFFECT_FRAME_WORLD ", direction + "amplitude_N: 0.1 "
    fields = {
        "CONSTANT": push + box + "trigger: EFFECT_TRIGGER_TOUCH ",
        "SPRING_TO_POINT": world + point + reach,
        "SPRING_TO_LINE": point + direction + reach + "trigger: EFFECT_TRIGGER_ALWAYS ",
        "SPRING_TO_PLANE": point + direction + reach,
        "SPRING_TO_PATH": path + reach,
        "GUIDE": world + path + reach,
        "FORBIDDEN_SIDE": point + direction + pull,
        "VISCOSITY": "damping_Ns_per_m: 0.5 limit_N: 1 " + sphere,
        "VIBRATION": world + push + "frequency_Hz: 50 phase_rad: -1 trigger: EFFECT_TRIGGER_BUTTON " + box,
        "TUBE": path + pull + "size_m { x: 0.1 } ",
        "INERTIA": pull + "mass_kg: 0.25 region: EFFECT_REGION_INSIDE fade_m: 0.01 ",
        "MAGNET": reach,
        "SPRING_TO_VERTEX": reach,
        "SPRING_TO_EDGE": reach,
        "SAMPLES": push + sphere + "samples: [0.1, -0.0, -1] sample_rate_Hz: 8000 ",
        "RECORDED_TEXTURE": "amplitude_N: 1 limit_N: 2 sample_rate_Hz: 1e4 speeds_m_per_s: [0.1, 0.2] forces_N: 1 "
                            "models: [0.1, -0.9, -0.0, 1, 0.5, 0] "}
    return [f"effects {{ kind: EFFECT_KIND_{kind} {its}}}" for kind, its in fields.items()]


SCENE = """
operations { add { name: "torus" mesh { torus { major_radius_m: 0.042 minor_radius_m: 0.018 } }
                   pose { position { x: -0.06 z: 0.018 } } } }
operations { add { name: "box" mesh { box { size_m { x: 0.07 y: 0.07 z: 0.05 } segments: 4 } }
                   pose { position { x: 0.06 z: 0.025 } } } }
"""

TETRAHEDRON_OFF = """OFF
4 4 6
0 0 0
0.05 0 0
0 0.05 0
0 0 0.05
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
"""


def wait_until(condition, timeout_s, what, pause_s=0.05):
    """The first true value of condition(); fails with `what` after timeout_s of a quiet machine."""
    deadline = time.monotonic() + PATIENCE * timeout_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {timeout_s} s: {what() if callable(what) else what}")
        time.sleep(pause_s)


class Process:
    """A child whose output is collected line by line, standard error apart."""

    def __init__(self, command, env=None, prefix=(), cwd=None):
        self.lines, self.errors = [], []
        self.process = subprocess.Popen([*map(str, prefix), *map(str, command)], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        env={**os.environ, **(env or {})}, cwd=cwd)
        self.readers = [threading.Thread(target=self.collect, args=pair, daemon=True)
                        for pair in ((self.process.stdout, self.lines), (self.process.stderr, self.errors))]
        for reader in self.readers:
            reader.start()

    @staticmethod
    def collect(stream, lines):
        with stream:
            for line in stream:
                lines.append(line.rstrip("\n"))

    def find(self, pattern):
        """The newest line of standard output that matches, as a match object."""
        for line in reversed(list(self.lines)):
            match = re.search(pattern, line)
            if match:
                return match
        return None

    def text(self):
        return "\n".join([*self.lines, *self.errors])

    def alive(self):
        return self.process.poll() is None

    def send(self, number):
        self.process.send_signal(number)

    def wait(self, timeout_s=STOP_TIMEOUT_S):
        try:
            code = self.process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(f"{self.process.args[0]} does not end:\n{self.text()}") from None
        self.join()
        return code

    def join(self):
        """Until all is said, also by a watchdog that outlives its server."""
        for reader in self.readers:
            reader.join(STOP_TIMEOUT_S)

    def kill(self):
        if self.alive():
            self.send(signal.SIGKILL)
            self.process.wait()
            self.join()

    def stop(self):
        """Asks it to end and returns its exit code."""
        if self.alive():
            self.send(signal.SIGTERM)
        return self.wait()


class NotStarted(AssertionError):
    """Carries the server's exit code, None when it did not end by itself."""

    def __init__(self, code, said):
        super().__init__(f"the server did not start (exit code {code}):\n{said}")
        self.code = code


class Server(Process):
    """haptic_server, with the simulated device unless told otherwise; ready when constructed."""

    def __init__(self, folder, scene=SCENE, listen="127.0.0.1:0", options=(), prefix=(), credentials=None,
                 device="simulated", env=None):
        """`scene`: its text, a Path where it lies, or None. `credentials`: a folder of make_credentials()."""
        self.folder = Path(folder)
        self.credentials = credentials
        if credentials:
            options = [*options, "--credentials", credentials]
        if "--recordings" not in options:  # one that is killed leaves one
            options = [*options, "--recordings", self.folder / "recordings"]
        self.summary_file = self.folder / "server.json"
        if isinstance(scene, str):
            scene, text = self.folder / "test.scene", scene
            scene.write_text(text)
        super().__init__([BIN / "haptic_server", *(["--scene", scene] if scene else []), "--device", device, "--listen", listen,
                          "--summary", self.summary_file, *options], prefix=prefix, env=env)
        try:
            wait_until(lambda: self.find(r"^listening on ") or not self.alive(), START_TIMEOUT_S, self.text)
        except AssertionError:
            self.kill()
            raise
        if not self.find(r"^listening on "):
            raise NotStarted(self.wait(), self.text())
        self.address = self.find(r"^listening on (\S+)").group(1)

    def host_and_port(self):
        host, port = self.address.rsplit(":", 1)
        return host.strip("[]"), int(port)

    def ctl(self, *arguments, **options):
        if self.credentials:
            options.setdefault("credentials", self.credentials / "editor.credentials")
        return ctl(self.address, *arguments, **options)

    def status(self):
        return self.ctl("status").json()

    def summary(self):
        return json.loads(self.summary_file.read_text())


class Answer:
    """What a hapticctl that has ended said."""

    def __init__(self, code, output, errors):
        self.code, self.output, self.errors = code, output, errors

    def json(self):
        if self.code != 0:
            raise AssertionError(f"hapticctl ended with {self.code}: {self.errors}{self.output}")
        return json.loads(self.output)


def ctl(address, *arguments, text=None, timeout_s=300, prefix=(), credentials=None):
    """hapticctl --json; `text` is its standard input, `credentials` a client's file."""
    secured = ["--credentials", str(credentials)] if credentials else []
    patient = [] if "--timeout" in arguments else ["--timeout", str(START_TIMEOUT_S)]
    done = subprocess.run([*map(str, prefix), str(BIN / "hapticctl"), "--connect", address, "--json", *secured, *patient,
                           *map(str, arguments)], input=text or "", capture_output=True, text=True, timeout=timeout_s)
    return Answer(done.returncode, done.stdout, done.stderr)


def make_credentials(folder):
    """The folder, with what hapticctl credentials makes in it."""
    subprocess.run([BIN / "hapticctl", "credentials", folder], check=True, stdout=subprocess.DEVNULL)
    return Path(folder)


def token_of(file):
    """The token in a client's credentials."""
    return bytes.fromhex(re.search(r"^token: ([0-9a-f]{64})$", Path(file).read_text(), re.MULTILINE)[1])


class Hardware:
    """The process of an emulated device, real-time like a device's own where that is permitted."""

    def __init__(self, *command):
        realtime = ["chrt", "--fifo", "50"]
        prefix = realtime if subprocess.run([*realtime, "true"], capture_output=True).returncode == 0 else []
        self.process = subprocess.Popen([*prefix, *map(str, command)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                        bufsize=1)
        self.said = queue.Queue()
        threading.Thread(target=self.listen, daemon=True).start()
        assert self.said.get(timeout=STOP_TIMEOUT_S)[0] == "ready"

    def listen(self):
        for line in self.process.stdout:
            self.said.put(line.split())

    def tell(self, text):
        self.process.stdin.write(text + "\n")

    def hears(self, word):
        said = self.said.get(timeout=STOP_TIMEOUT_S)
        assert said[0] == word, f"{said} instead of {word}"
        return int(said[1])

    def close(self):
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            pipe.close()


def waited_s(process):
    """How long the first thread of a process was ready to run and did not."""
    return 1e-9 * int(Path(f"/proc/{process}/schedstat").read_text().split()[1])


class Cyclictest:
    """How late a thread of real-time priority on each processor wakes up in the same moment."""

    LATE_US = 1000

    def __enter__(self):
        self.process = subprocess.Popen(["cyclictest", "-q", "-p", "2", "-i", "1000", "-h", str(self.LATE_US), "-t", "-a"],
                                        text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        said = self.process.communicate()[0]
        # Both 0 where it may not run.
        self.longest_us = max(map(int, re.search(r"Max Latencies:([ \d]*)", said + "Max Latencies: 0")[1].split()))
        self.late = sum(map(int, re.search(r"Overflows:([ \d]*)", said + "Overflows: 0")[1].split()))


class Display:
    """An X server of its own; viewers get it by DISPLAY. Its screen lies in a file, as xwd writes it."""

    ATTEMPTS = 20

    def __init__(self, folder, options=()):
        self.folder = Path(tempfile.mkdtemp(prefix="screen-", dir=folder))
        self.options = options
        for _ in range(self.ATTEMPTS):
            if self.start():
                return
        raise AssertionError("Xvfb does not start")

    def start(self):
        """Xvfb locks a number that it is told. One that it chooses may be another's, in another network."""
        self.name = f":{random.randrange(1000, 50000)}"
        reader, writer = os.pipe()
        self.process = subprocess.Popen(["Xvfb", self.name, "-displayfd", str(writer), "-screen", "0", "1280x1024x24",
                                         "-r",  # else a key that a loaded machine releases late is typed twice
                                         "-noreset", "-nolisten", "tcp", "-fbdir", self.folder, *self.options],
                                        pass_fds=(writer,), stderr=subprocess.DEVNULL)
        os.close(writer)
        with os.fdopen(reader) as stream:
            if stream.readline():
                return True
        self.process.wait()
        return False

    def screen_file(self):
        return self.folder / "Xvfb_screen0"

    def close(self):
        self.process.terminate()
        self.process.wait()


class Viewer(Process):
    """graphics_client, off screen, a frame now and then: what counts here is what it holds."""

    def __init__(self, folder, address, display, prefix=()):
        self.summary_file = Path(folder) / "viewer.json"
        self.summary_file.unlink(missing_ok=True)
        super().__init__([BIN / "graphics_client", "--connect", address, "--offscreen", "--size", "320x256",
                          "--fps-limit", "20", "--summary", self.summary_file],
                         env={"DISPLAY": display.name, "LP_NUM_THREADS": "1", **FOREIGN_CODE}, prefix=prefix)

    def held(self):
        """(revision, root, equal) as the viewer last said: its own hash, and whether it found the server's equal."""
        match = self.find(r"^scene revision (\d+) root ([0-9a-f]{64}) (equal|not equal)$")
        return (int(match[1]), match[2], match[3] == "equal") if match else None

    def wait_for(self, revision, root, timeout_s=START_TIMEOUT_S):
        """Until its own hash is `root` at `revision`."""
        def in_step():
            if not self.alive():
                raise AssertionError(f"the viewer ended:\n{self.text()}")
            return self.held() == (revision, root, True)
        wait_until(in_step, timeout_s, lambda: f"viewer at revision {revision} root {root}; it holds {self.held()}\n"
                                               f"{self.text()}", pause_s=0.01)

    def summary(self):
        return json.loads(self.summary_file.read_text())


class WireClient:
    """A connection on which a test says what it likes."""

    def __init__(self, server, tls=None):
        """`tls`: an ssl.SSLContext."""
        self.socket = socket.create_connection(server.host_and_port(), timeout=START_TIMEOUT_S)
        if tls:
            self.socket = tls.wrap_socket(self.socket, server_hostname="haptic_server")

    def send(self, data):
        self.socket.sendall(data)

    def send_envelope(self, envelope):
        data = envelope.SerializeToString()
        self.send(struct.pack("<I", len(data)) + data)

    def receive_exactly(self, count):
        data = b""
        while len(data) < count:
            piece = self.socket.recv(count - len(data))
            if not piece:
                return None
            data += piece
        return data

    def receive_envelope(self):
        """The next envelope, or None when the server has closed."""
        from haptics.v1 import envelope_pb2
        try:
            head = self.receive_exactly(4)
            body = head and self.receive_exactly(struct.unpack("<I", head)[0])
        except ConnectionError:
            return None
        return envelope_pb2.Envelope.FromString(body) if body else None

    def until_closed(self):
        """Everything that the server still says before it closes."""
        said = []
        while True:
            envelope = self.receive_envelope()
            if envelope is None:
                return said
            said.append(envelope)

    def close(self):
        self.socket.close()


def tls_context(credentials_file):
    """Python's own verification, host name and all, with the certificate in a client's credentials."""
    return ssl.create_default_context(cafile=str(credentials_file))


def hello_envelope(name, version=1, token=b""):
    from haptics.v1 import envelope_pb2
    envelope = envelope_pb2.Envelope(protocol_version=version, message_id=1)
    envelope.hello.session = int.from_bytes(os.urandom(8), "little")
    envelope.hello.client_name = name
    envelope.hello.token = token
    return envelope


class StatusProbe(WireClient):
    """Asks for the server's status at no more than the cost of two small messages."""

    def __init__(self, server):
        self.server = server
        self.join()

    def join(self):
        super().__init__(self.server)
        self.send_envelope(hello_envelope("status probe"))

    def status(self):
        from haptics.v1 import envelope_pb2
        request = envelope_pb2.Envelope(protocol_version=1)
        request.status_request.SetInParent()
        for _ in range(2):
            with contextlib.suppress(ConnectionError):
                self.send_envelope(request)
                while envelope := self.receive_envelope():
                    if envelope.WhichOneof("body") == "status":
                        return envelope.status
            self.close()
            self.join()  # who says nothing for 3 s is left by the server
        raise AssertionError("the server closes the connection")


class EndToEnd(unittest.TestCase):
    """A temporary folder and a display for each test; what it started has ended when it is over.

    Where tests watch real time (in_real_time says so), one that fails while the machine holds threads of real-time priority up
    by more than a millisecond, more often than MOST_LATE_HZ, is not judged: it counts as skipped, and its failure is shown."""

    MOST_LATE_HZ = 1.0

    def run(self, result=None):
        if result is None or "HAPTICS_REAL_TIME" not in os.environ:
            return super().run(result)
        known = len(result.failures), len(result.errors)
        began = time.monotonic()
        with Cyclictest() as stall:
            super().run(result)
        late_hz = stall.late / (time.monotonic() - began)
        failed = result.failures[known[0]:] + result.errors[known[1]:]
        if failed and late_hz > self.MOST_LATE_HZ:
            del result.failures[known[0]:], result.errors[known[1]:]
            for test, traceback in failed:
                print(f"\nnot judged: the machine was late {late_hz:.1f} times a second\n{traceback}", flush=True)
                result.addSkip(test, f"the machine was late {late_hz:.1f} times a second")
        return result

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="haptics-e2e-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def start_server(self, **options):
        server = Server(self.folder, **options)
        self.addCleanup(server.kill)
        return server

    def start_display(self, options=()):
        display = Display(self.folder, options)
        self.addCleanup(display.close)
        return display

    def start_viewer(self, address, display, prefix=()):
        viewer = Viewer(self.folder, address, display, prefix)
        self.addCleanup(viewer.kill)
        return viewer

    def stop_and_check(self, server):
        """The server ends well and has a summary. It ends within 2 s in any case: stopping.py judges that."""
        code = server.stop()
        if code != 0 and "something does not end" in server.text() and os.getloadavg()[0] > 3 * os.cpu_count():
            self.skipTest("the machine held the server's end up")
        self.assertEqual(code, 0, server.text())
        return server.summary()
