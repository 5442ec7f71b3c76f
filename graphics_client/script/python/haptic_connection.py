"""A connection to haptic_server: how it is made, its frames, and why it ended."""
import re
import socket
import ssl
import struct

from google.protobuf.message import DecodeError

from haptic_scene import LimitExceeded, OutOfStep
from haptics.v1 import envelope_pb2

PROTOCOL_VERSION = 1
MAX_FRAME_BYTES = 1 << 20
MAX_SENT_AT_ONCE = 1 << 16


class ConnectionLost(Exception):
    pass


class TurnedAway(ConnectionLost):
    pass


def endpoint(address):
    """(host, port) of HOST:PORT. Raises ValueError, which says what is wrong with it and what would be right."""
    host, colon, port = address.rpartition(":")
    problem = ""
    if not colon:
        problem = "has no port"
    elif not (port.isascii() and port.isdigit() and int(port) < 1 << 16):
        problem = f'"{port}" is not a port from 0 to 65535'
    elif host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif ":" in host:
        problem = f'"{host}" has colons: an IPv6 address needs brackets'
    elif not re.fullmatch("[-A-Za-z0-9._]+", host):
        problem = f'"{host}" is not a host'
    if problem:
        raise ValueError(f"{address}: {problem}; give HOST:PORT, as in 127.0.0.1:7400, localhost:7400 or [::1]:7400")
    return "127.0.0.1" if host == "localhost" else host, int(port)


def connect(server, credentials, timeout_s):
    """To (host, port); with a file of credentials by TLS."""
    try:
        connection = socket.create_connection(server, timeout=timeout_s)
    except OSError as error:
        host, port = server
        raise ConnectionLost(f"{f'[{host}]' if ':' in host else host}:{port}: cannot connect: {error.strerror or error}; "
                             "is haptic_server running there?") from None
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if not credentials:
        return connection
    context = ssl.create_default_context(cadata=certificate_in(credentials))
    return context.wrap_socket(connection, server_hostname="haptic_server")


def text_of(credentials):
    """The file's text, of which editors may have changed line ends and put a byte order mark in front."""
    with open(credentials, "rb") as file:
        text = file.read()
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ConnectionLost(f"{credentials}: is in UTF-16; save it in UTF-8")
    return re.sub("\r\n?", "\n", text.decode("utf-8-sig", errors="replace"))


def certificate_in(credentials):
    """The server's certificate, as PEM."""
    pem = re.search("-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", text_of(credentials), re.DOTALL)
    if not pem:
        raise ConnectionLost(f"{credentials}: holds no certificate of a server; give what hapticctl credentials made")
    return pem[0]


def token_in(credentials):
    """Bytes for the Hello; none without a file of credentials."""
    if not credentials:
        return b""
    lines = re.findall(r"^[ \t]*token:[ \t]*(\S*)", text_of(credentials), re.MULTILINE)
    if not lines or not re.fullmatch("[0-9a-f]{64}", lines[-1]):
        raise ConnectionLost(f"{credentials}: has no token; give what hapticctl credentials made")
    return bytes.fromhex(lines[-1])


def send_frame(connection, number, **body):
    """An envelope; each MAX_SENT_AT_ONCE bytes have the connection's timeout."""
    data = envelope_pb2.Envelope(protocol_version=PROTOCOL_VERSION, message_id=number, **body).SerializeToString()
    data = struct.pack("<I", len(data)) + data
    for at in range(0, len(data), MAX_SENT_AT_ONCE):
        connection.sendall(data[at:at + MAX_SENT_AT_ONCE])


def frames(buffer):
    """The whole envelopes at the buffer's beginning, which are taken from it."""
    while len(buffer) >= 4:
        size = struct.unpack_from("<I", buffer)[0]
        if not 0 < size <= MAX_FRAME_BYTES:
            raise ConnectionLost(f"a frame of {size} bytes")
        if len(buffer) < 4 + size:
            return
        envelope = envelope_pb2.Envelope()
        if envelope.MergeFromString(bytes(buffer[4:4 + size])) != size:
            raise DecodeError("a frame holds more than its message")
        del buffer[:4 + size]
        yield envelope


def in_words(error):
    """Why a connection ended."""
    if isinstance(error, OutOfStep):
        return f"out of step, asking for a snapshot: {error}"
    if isinstance(error, DecodeError):
        return f"the server does not speak this protocol: {error}"
    if isinstance(error, (OSError, ConnectionLost, LimitExceeded)) and str(error):
        return str(error)
    return f"{type(error).__name__}: {error}"
