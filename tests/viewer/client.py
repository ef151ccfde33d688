# SPDX-License-Identifier: Apache-2.0
"""A small client of the viewer's protocol (viewer/PROTOCOL.md), with nothing but Python.

    with Client(port) as c:
        state = c.state(layers=["neural"])     # sends it
        frame = c.frame(state["version"])      # waits for a picture of it, acknowledges
"""
import base64
import json
import os
import random
import socket
import struct
import subprocess
import time

HEADER = struct.Struct("<4sBBHIIHHHHIffI")


class Frame:
    """A picture, or the file of a capture."""

    def __init__(self, data):
        (magic, self.layer, self.encoding, final, self.number, self.version, self.width, self.height,
         self.full_width, self.full_height, self.spp, self.render_ms, self.encode_ms,
         zero) = HEADER.unpack_from(data)
        assert magic == b"LMNF" and zero == 0, data[:40]
        self.is_final = final == 1
        self.bytes = data[HEADER.size:]


class Closed(Exception):
    """The server closed the socket: its code and reason."""


class Client:
    """One session. `hello` is there at once."""

    def __init__(self, port, path="/socket", headers=None, protocol="lumenaut-1", timeout=60):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout)
        self.buffer = b""
        self.version = 0
        self.texts, self.frames = [], []
        key = base64.b64encode(os.urandom(16)).decode()
        lines = {"Host": f"127.0.0.1:{port}", "Upgrade": "websocket", "Connection": "Upgrade",
                 "Sec-WebSocket-Key": key, "Sec-WebSocket-Version": "13"}
        if protocol:
            lines["Sec-WebSocket-Protocol"] = protocol
        lines.update(headers or {})
        head = "".join(f"{k}: {v}\r\n" for k, v in lines.items() if v is not None)
        self.socket.sendall(f"GET {path} HTTP/1.1\r\n{head}\r\n".encode())
        while b"\r\n\r\n" not in self.buffer:
            more = self.socket.recv(4096)
            if not more:
                raise Closed("no answer")
            self.buffer += more
        answer, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        status = int(answer.split(b" ", 2)[1])
        if status != 101:
            self.socket.close()
            raise Closed(status)
        self.hello = self.text("hello")

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.socket.close()

    # ---- Bytes ----

    def send_raw(self, data, opcode=1, final=True):
        mask = os.urandom(4)
        head = bytes([(0x80 if final else 0) | opcode])
        n = len(data)
        if n < 126:
            head += bytes([0x80 | n])
        elif n < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", n)
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", n)
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(data))
        self.socket.sendall(head + mask + masked)

    def send(self, message):
        self.send_raw(json.dumps(message).encode())

    def _exact(self, n):
        while len(self.buffer) < n:
            more = self.socket.recv(1 << 16)
            if not more:
                raise Closed("the end")
            self.buffer += more
        data, self.buffer = self.buffer[:n], self.buffer[n:]
        return data

    def _message(self):
        """The next message: its opcode and bytes."""
        whole, kind = b"", 0
        while True:
            first, second = self._exact(2)
            n = second & 127
            if n == 126:
                n = struct.unpack(">H", self._exact(2))[0]
            elif n == 127:
                n = struct.unpack(">Q", self._exact(8))[0]
            data = self._exact(n)
            opcode = first & 15
            if opcode == 8:
                raise Closed(struct.unpack(">H", data[:2])[0] if n >= 2 else 0, data[2:].decode())
            if opcode == 9:
                self.send_raw(data, 10)
                continue
            if opcode == 10:
                continue
            whole += data
            kind = kind or opcode
            if first & 0x80:
                return kind, whole

    def receive(self):
        """The next message into `texts` or `frames`."""
        kind, data = self._message()
        if kind == 1:
            self.texts.append(json.loads(data))
        else:
            self.frames.append(Frame(data))

    # ---- Messages ----

    def text(self, kind, where=lambda t: True):
        """The next text of a type."""
        while True:
            for i, t in enumerate(self.texts):
                if t["type"] == kind and where(t):
                    return self.texts.pop(i)
            self.receive()

    def state(self, **fields):
        """Sends a state: the default one but for the fields given."""
        self.version += 1
        state = {"type": "state", "version": self.version,
                 "values": [v["value"] for v in self.hello["variables"]], "camera": None,
                 "layers": [self.hello["layers"][0]], "width": 96, "height": 64, "exposure": 1,
                 "tone": "srgb", "moving": False, "rate": 12, "least": 0.25}
        state.update(fields)
        self.send(state)
        return state

    def acknowledge(self, frame):
        self.send({"type": "ack", "frame": frame.number})

    def next_frame(self):
        """The next picture, acknowledged."""
        while not self.frames:
            self.receive()
        frame = self.frames.pop(0)
        if frame.layer != 255:
            self.acknowledge(frame)
        return frame

    def frame(self, version=0, where=lambda f: True, seconds=60):
        """The first picture of this version or a later one that fits."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            frame = self.next_frame()
            if frame.layer != 255 and frame.version >= version and where(frame):
                return frame
        raise TimeoutError


def own_port():
    """A free port no other test takes while its viewer closes and comes back: neither one of the
    first free from 8750 on, nor one the system gives to clients."""
    while True:
        port = random.randrange(10000, 30000)
        with socket.socket() as s:
            try:
                s.bind(("127.0.0.1", port))
                return port
            except OSError:
                pass


class Viewer:
    """A running `lumenaut view`, or another command that serves the page, at a port of its own
    where the arguments name none and its default is not asked for."""

    def __init__(self, lumenaut, *arguments, command="view", default_port=False):
        if not default_port and "--port" not in arguments:
            arguments += ("--port", str(own_port()))
        self.process = subprocess.Popen([lumenaut, command, *arguments], stderr=subprocess.PIPE,
                                        text=True)
        self.url = ""
        while "http://" not in self.url:
            self.url = self.process.stderr.readline()
            if not self.url:
                raise RuntimeError("the viewer did not start")
        self.url = self.url[self.url.index("http://"):].strip()
        self.port = int(self.url.split(":")[2].split("/")[0])

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.process.terminate()
        self.process.communicate(timeout=20)

    def rest(self, seconds=30):
        """Until it works no more: its processor time stands still."""
        def used():
            with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as f:
                words = f.read().rsplit(")", 1)[1].split()
            return int(words[11]) + int(words[12])
        end, before, now = time.monotonic() + seconds, -1, used()
        while now != before and time.monotonic() < end:
            time.sleep(0.3)
            before, now = now, used()

    def size(self):
        """Bytes of memory, and open descriptors."""
        with open(f"/proc/{self.process.pid}/statm", encoding="ascii") as f:
            pages = int(f.read().split()[1])
        return pages * 4096, len(os.listdir(f"/proc/{self.process.pid}/fd"))
