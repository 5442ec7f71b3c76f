"""Assets of one's own: computed height maps, values per vertex and at points, sent to the server, to be named by an edit."""
import concurrent.futures
import hashlib
import struct
import time

from haptic_edits import PATIENCE_S, settle
from haptic_text import printable
from haptics.v1 import envelope_pb2, scene_pb2

FIELD, VERTEX_VALUES = scene_pb2.ASSET_KIND_SCALAR_FIELD, scene_pb2.ASSET_KIND_VERTEX_VALUES
MOVED_VERTICES, POINT_FIELD = scene_pb2.ASSET_KIND_MOVED_VERTICES, scene_pb2.ASSET_KIND_POINT_FIELD
CHUNK_BYTES = 32_000
MAX_UNNAMED_BYTES = 256 << 20


def field(rows):
    """Canonical bytes of a scalar field: rows of numbers, the first row lowest, each side 2 to 4096. It repeats."""
    width = len(rows[0])
    if any(len(row) != width for row in rows):
        raise ValueError("a field's rows are equally long")
    return struct.pack("<4sIII", b"HSFD", 1, width, len(rows)) + b"".join(struct.pack(f"<{width}f", *row) for row in rows)


def vertex_values(values):
    """Canonical bytes of a number >= 0 for each vertex of a mesh, in its canonical numbering."""
    return struct.pack("<4sIQ", b"HVTX", 1, len(values)) + struct.pack(f"<{len(values)}f", *(v + 0.0 for v in values))


def moved_vertices(places):
    """Canonical bytes of a residue: {vertex in the mesh's canonical numbering: (x, y, z)}, object frame, m."""
    vertices = sorted(places)
    return (struct.pack("<4sIQ", b"HMOV", 1, len(vertices)) + struct.pack(f"<{len(vertices)}I", *vertices) +
            b"".join(struct.pack("<3f", *(x + 0.0 for x in places[vertex])) for vertex in vertices))


def point_field(samples, reach_m):
    """Canonical bytes of a field given at points of a surface: (x, y, z, value) each, object frame, m, at most 60,000.
    Each counts for as far as reach_m: twice the distance between neighbours."""
    return (struct.pack("<4sIIf", b"HPTF", 1, len(samples), reach_m) +
            b"".join(struct.pack("<4f", *(number + 0.0 for number in sample)) for sample in samples))


class UploadRefused(Exception):
    """The server does not take the asset; `field` names the part that is wrong."""

    def __init__(self, field_name, reason):
        super().__init__(printable(f"{field_name}: {reason}" if field_name else reason))
        self.field, self.reason = field_name, reason


class Upload:
    def __init__(self, kind, data):
        self.kind, self.data = envelope_pb2.AssetChunk(kind=kind).kind, bytes(data)
        self.hash = hashlib.sha256(self.data).digest()
        self.sent_bytes, self.again = 0, False
        self.put_off_since = None
        self.held = concurrent.futures.Future()


class UploadQueue:
    """Uploads on their way, one after the other, sent anew after a reconnect until they are answered. The server keeps one for
    its connection until an edit names it: after a reconnect the newest 256 MB that none has named are sent again."""

    def __init__(self):
        self._uploads, self._unnamed, self._waiting_until, self._end = [], [], 0.0, None

    def add(self, kind, data):
        upload = Upload(kind, data)
        if self._end:
            settle(upload.held, error=self._end)
        elif not upload.data:
            settle(upload.held, error=UploadRefused("chunk.data", "is empty; an asset has bytes"))
        else:
            self._uploads.append(upload)
        return upload

    def sends(self):
        """Whether there is a chunk to send now."""
        return (bool(self._uploads) and self._uploads[0].sent_bytes < len(self._uploads[0].data) and
                time.monotonic() >= self._waiting_until)

    def take_chunk(self):
        """The first upload's next one; None where there is none to send now."""
        if not self.sends():
            return None
        upload, at = self._uploads[0], self._uploads[0].sent_bytes
        data = upload.data[at:at + CHUNK_BYTES]
        upload.sent_bytes += len(data)
        return envelope_pb2.AssetUpload(chunk=envelope_pb2.AssetChunk(
            hash=upload.hash, kind=upload.kind, total_size=len(upload.data), offset=at, data=data))

    def connection_lost(self):
        self._waiting_until = 0.0
        for upload in self._unnamed:
            upload.again = True
        self._uploads, self._unnamed = self._unnamed + self._uploads, []
        for upload in self._uploads:
            upload.sent_bytes = 0

    def sends_again(self):
        """Edits have to wait: what they name may be among what the server is to get once more."""
        return bool(self._uploads) and self._uploads[0].again

    def committed(self, commit):
        """The scene holds what this names from now on."""
        if self._unnamed:
            names = commit.SerializeToString()
            self._unnamed = [upload for upload in self._unnamed if upload.hash not in names]

    def end(self, error):
        """Every wait ends with the error, now and from now on."""
        self._end = error
        for upload in self._uploads:
            settle(upload.held, error=error)
        self._uploads.clear()

    def replied(self, reply):
        if not self._uploads or self._uploads[0].hash != reply.hash:
            return
        upload, now = self._uploads[0], time.monotonic()
        upload.put_off_since = upload.put_off_since or now
        if reply.retry_after_ms and now - upload.put_off_since < PATIENCE_S:
            upload.sent_bytes = 0
            self._waiting_until = now + min(1e-3 * reply.retry_after_ms, PATIENCE_S)
            return
        self._uploads.pop(0)
        if reply.accepted:
            self._unnamed.append(upload)
            while sum(len(each.data) for each in self._unnamed) > MAX_UNNAMED_BYTES:
                self._unnamed.pop(0)
            settle(upload.held, upload.hash)
        else:
            settle(upload.held, error=UploadRefused(reply.field, reply.reason))
