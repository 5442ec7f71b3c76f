"""A bad network in one process: what TCP makes of delay, jitter and loss. A lost segment comes a retransmission later, and
what was sent after it waits for it."""
import queue
import random
import socket
import threading
import time

RETRANSMISSION_S = 0.2  # Linux's least


class SlowLink:
    """Relays connections to a server. `loss`: the share of segments that are lost, each way."""

    def __init__(self, server, rtt_s, jitter_s, loss, seed=1):
        self.target, self.one_way_s, self.jitter_s, self.loss = server.host_and_port(), rtt_s / 2, jitter_s, loss
        self.random = random.Random(seed)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.accept, daemon=True).start()

    def close(self):
        self.listener.close()

    def accept(self):
        while True:
            try:
                client = self.listener.accept()[0]
            except OSError:
                return
            server = socket.create_connection(self.target)
            for source, target in ((client, server), (server, client)):
                target.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                segments = queue.Queue()
                threading.Thread(target=self.read, args=(source, segments), daemon=True).start()
                threading.Thread(target=self.write, args=(target, segments), daemon=True).start()

    def read(self, source, segments):
        data = b" "
        while data:
            try:
                data = source.recv(1400)
            except OSError:
                data = b""
            delay = self.one_way_s + self.random.gauss(0, self.jitter_s)
            if self.random.random() < self.loss:
                delay += RETRANSMISSION_S
            segments.put((time.monotonic() + delay, data))

    def write(self, target, segments):
        while True:
            due, data = segments.get()
            time.sleep(max(0, due - time.monotonic()))
            try:
                if not data:
                    return target.close()
                target.sendall(data)
            except OSError:
                return
