"""A NATS server of a test's own, and a client of it that speaks the protocol by hand."""
import json
import os
import re
import socket
import ssl
import threading

import harness


ANY_PORT = -1


def ports_of(server):
    """Where a NATS server listens to clients and, if it does, to pages, once it is ready."""
    harness.wait_until(lambda: "Server is ready" in server.text() or not server.alive(), 20, server.text)
    said = server.text()
    if not server.alive():
        raise AssertionError(said)
    return tuple(int(found[1]) if (found := re.search(rf"Listening for {who} on \S+:(\d+)", said)) else None
                 for who in ("client connections", "websocket clients"))


class NatsServer(harness.Process):
    """nats-server with JetStream; the store in `folder` outlives it. Ready when constructed."""

    def __init__(self, folder, port=None, config="", store="32G"):
        """`config`: more lines of its file. `store`: what JetStream may take; None: it is off."""
        file = harness.Path(folder) / "nats.conf"
        stored = f'jetstream {{ store_dir: "{folder}/jetstream", max_file_store: {store} }}\n' if store else ""
        file.write_text(f'listen: "127.0.0.1:{port or ANY_PORT}"\n{stored}{config}')
        super().__init__(["nats-server", "-c", file])
        self.port, self.web_port = ports_of(self)
        self.url = f"nats://127.0.0.1:{self.port}"


class SecuredNatsServer(harness.Process):
    """nats-server as deploy/nats.conf has it, with a certificate of its own."""
    PAGE = "https://pages.example"

    def __init__(self, folder):
        self.folder = harness.Path(folder)
        self.certificate, key = self.folder / "nats.crt", self.folder / "nats.key"
        harness.subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj",
             "/CN=nats", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", self.certificate],
            check=True, capture_output=True)
        harness.shutil.copy(harness.PROJECT / "deploy/nats.conf", self.folder)
        (self.folder / "site.conf").write_text(
            f'LISTEN: "127.0.0.1:{ANY_PORT}"\nWEB_LISTEN: "127.0.0.1:{ANY_PORT}"\nCERTIFICATE: "{self.certificate}"\n'
            f'KEY: "{key}"\nSTORE: "{self.folder}/secured"\nRELAY_PASSWORD: "long-and-random"\n'
            f'PAGES: ["{self.PAGE}"]\n')
        super().__init__(["nats-server", "-c", self.folder / "nats.conf"])
        self.port, self.web_port = ports_of(self)
        self.url = f"tls://127.0.0.1:{self.port}"
        self.relay, self.audience = self.credentials("relay", "long-and-random"), self.certificate

    def answer_to_page(self, origin):
        """HTTP status for a page from there that opens a WebSocket."""
        context = ssl.create_default_context(cafile=self.certificate)
        with socket.create_connection(("127.0.0.1", self.web_port), 10) as plain, \
                context.wrap_socket(plain, server_hostname="127.0.0.1") as page:
            page.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nOrigin: {origin}\r\n"
                         "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
            return int(page.recv(4096).split()[1])

    def credentials(self, user, password):
        file = self.folder / f"{user}-{password}.nats"
        file.write_text(f"{self.certificate.read_text()}user: {user}\npassword: {password}\n")
        return file


class FakeNatsServer:
    """Says INFO, and then what it is asked to do."""
    HUGE = 2**31 - 1000

    def __init__(self, does, **info):
        """`does`: "nothing", not even a PONG; "closes"; "floods" who subscribes with one message of HUGE bytes."""
        self.does, self.connections, self.heard, self.sent = does, 0, b"", 0
        self.info = {"server_id": "fake", "version": "2.9.10", "proto": 1, "headers": True, "max_payload": 1 << 20, **info}
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        self.url = f"nats://{self.address}"
        self.port = self.listener.getsockname()[1]
        self.held = []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                connection = self.listener.accept()[0]
            except OSError:
                return
            self.connections += 1
            self.held.append(connection)
            threading.Thread(target=self.serve, args=(connection,), daemon=True).start()

    def serve(self, connection):
        try:
            connection.sendall(f"INFO {json.dumps(self.info)} \r\n".encode())
            while self.does != "closes" and (data := connection.recv(1 << 16)):
                self.heard += data
                if self.does != "floods":
                    continue
                if b"PING" in data:
                    connection.sendall(b"PONG\r\n")
                if b"SUB " in data:
                    number = data.split(b"SUB ", 1)[1].split(b"\r\n")[0].split()[-1]
                    connection.sendall(b"MSG a %s %d\r\n" % (number, self.HUGE))
                    while self.sent < self.HUGE:
                        connection.sendall(bytes(1 << 18))
                        self.sent += 1 << 18
        except OSError:
            pass
        connection.close()

    def close(self):
        self.listener.close()
        for connection in self.held:
            connection.close()


class Refused(Exception):
    """What the NATS server said with -ERR."""


class NatsWire:
    """One connection. Messages wait in `messages` as (subject, headers, bytes)."""

    def __init__(self, port, user=None, password=None, tls=None):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=harness.STOP_TIMEOUT_S)
        self.input = self.socket.makefile("rb")
        json.loads(self.input.readline().split(b" ", 1)[1])  # INFO
        if tls:
            self.socket = ssl.create_default_context(cafile=tls).wrap_socket(self.socket, server_hostname="127.0.0.1")
            self.input = self.socket.makefile("rb")
        self.messages = []
        options = {"verbose": False, "pedantic": False, "headers": True, "no_responders": True, "lang": "test", "version": "1"}
        if user:
            options.update(user=user, **{"pass": password})
        self.inbox = f"_INBOX.{os.urandom(8).hex()}"
        self.say(f"CONNECT {json.dumps(options)}")
        self.asked = 0
        self.say(f"SUB {self.inbox}.* 1")
        self.flush()

    def close(self):
        self.socket.close()

    def say(self, line, payload=None):
        self.socket.sendall(line.encode() + b"\r\n" + (b"" if payload is None else payload + b"\r\n"))

    def subscribe(self, subject, number=2):
        self.say(f"SUB {subject} {number}")
        self.flush()

    def publish(self, subject, payload, reply=""):
        self.say(f"PUB {subject} {reply} {len(payload)}", payload)

    def flush(self):
        """Until the server has seen all; raises Refused for what it did not permit."""
        self.say("PING")
        while self.take() != "PONG":
            pass

    def take(self):
        """Reads one line of the server, and what belongs to it."""
        line = self.input.readline().decode().rstrip()
        word, *rest = line.split(" ")
        if word in ("MSG", "HMSG"):
            total = int(rest[-1])
            head = int(rest[-2]) if word == "HMSG" else 0
            data = self.input.read(total + 2)[:-2]
            self.messages.append((rest[0], data[:head].decode(), data[head:]))
        elif word == "PING":
            self.say("PONG")
        elif word == "-ERR":
            raise Refused(line)
        elif not word:
            raise Refused("the connection is closed")
        return word

    def request(self, subject, payload=b""):
        """(headers, bytes) of the answer."""
        self.asked += 1
        reply = f"{self.inbox}.{self.asked}"
        self.say(f"PUB {subject} {reply} {len(payload)}", payload)
        while True:
            for i, (to, headers, data) in enumerate(self.messages):
                if to == reply:
                    del self.messages[i]
                    return headers, data
            self.take()

    def stored(self, stream, sequence):
        """(subject, bytes), or None."""
        headers, data = self.request(f"$JS.API.DIRECT.GET.{stream}", json.dumps({"seq": sequence}).encode())
        if headers.startswith("NATS/1.0 "):
            return None
        return headers.split("Nats-Subject: ")[1].split("\r\n")[0], data

    def state(self, stream):
        """The stream's state, as JetStream tells it."""
        return json.loads(self.request(f"$JS.API.STREAM.INFO.{stream}")[1])["state"]
