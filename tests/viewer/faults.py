#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""faults.py LUMENAUT [SECONDS]: fifty pages at once, one that never reads, and others that break every rule.
Those that behave get their pictures, nothing crashes, and in the end memory and descriptors are as before."""
import os
import pathlib
import random
import socket
import sys
import threading
import time

from client import Client, Closed, Viewer

ROOT = pathlib.Path(__file__).parents[2]
SCENE = str(ROOT / "tests/cli/scenes/box.xml")
PAGES = 50


def behave(port, until, counts, index):
    """A page: states that change now and then, pictures of them, as long as it lasts."""
    draw = random.Random(index)
    with Client(port, timeout=120) as c:
        while time.monotonic() < until:
            values = [draw.uniform(-1, 1), draw.random(), draw.random(), draw.random(), 0.2, 1]
            state = c.state(values=values, layers=["traced"], width=64, height=40, moving=draw.random() < 0.5)
            frame = c.frame(state["version"], seconds=120)
            assert frame.version == state["version"]
            counts[index] += 1
            time.sleep(draw.uniform(0, 0.05))


def never_read(port, until):
    """Asks for everything and takes nothing."""
    with Client(port) as c:
        c.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        while time.monotonic() < until:
            try:
                c.state(layers=["traced", "depth"], width=512, height=512)
            except OSError:
                return  # the server has had enough
            time.sleep(0.05)


def misbehave(port, until, seed):
    """Garbage, too much, half a handshake, half a frame, sockets that die."""
    draw = random.Random(seed)
    while time.monotonic() < until:
        kind = draw.randrange(7)
        try:
            if kind == 0:  # not HTTP
                with socket.create_connection(("127.0.0.1", port), timeout=20) as s:
                    s.sendall(draw.randbytes(draw.randrange(1, 3000)))
                    s.settimeout(0.2)
                    s.recv(100)
                continue
            if kind == 1:  # half a request
                with socket.create_connection(("127.0.0.1", port), timeout=20) as s:
                    s.sendall(b"GET /socket HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgr")
                continue
            c = Client(port, timeout=20)
            if kind == 2:  # bytes that are no frames
                c.socket.sendall(draw.randbytes(draw.randrange(1, 5000)))
            elif kind == 3:  # messages that are no messages
                for _ in range(draw.randrange(30)):
                    c.send_raw(draw.randbytes(draw.randrange(200)), opcode=draw.choice([1, 2]))
            elif kind == 4:  # a message without an end
                c.send_raw(b'{"type":"', final=False)
                for _ in range(40):
                    c.send_raw(b" " * 2000, opcode=0, final=False)
            elif kind == 5:  # gone while a picture is made
                c.state(layers=["traced"], width=800, height=800)
                time.sleep(draw.uniform(0, 0.1))
            else:  # a flood
                for _ in range(3000):
                    c.send_raw(b'{"type":"ack","frame":1}')
            if draw.random() < 0.5:  # closed without a word
                c.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            c.socket.close()
        except (OSError, Closed):
            pass


def main():
    lumenaut, seconds = os.path.abspath(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 10
    with Viewer(lumenaut, SCENE, "-t", "2") as v:
        with Client(v.port) as c:
            c.frame(c.state()["version"])
        before = v.size()
        until, counts, failures = time.monotonic() + seconds, [0] * PAGES, []

        def run(work, *arguments):
            try:
                work(*arguments)
            except BaseException as why:  # told by the main thread
                failures.append(f"{work.__name__}: {why!r}")

        threads = [threading.Thread(target=run, args=(behave, v.port, until, counts, i)) for i in range(PAGES)]
        threads.append(threading.Thread(target=run, args=(never_read, v.port, until)))
        threads += [threading.Thread(target=run, args=(misbehave, v.port, until, i)) for i in range(3)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        assert not failures, failures[:5]
        assert v.process.poll() is None, "the viewer is gone"
        assert min(counts) > 0, f"starved: {counts}"
        end = time.monotonic() + 60
        while time.monotonic() < end and v.size()[1] > before[1]:
            time.sleep(0.5)
        with Client(v.port) as c:  # and it still works
            c.frame(c.state()["version"])
        after = v.size()
        assert after[1] <= before[1] + 1, f"descriptors: {before[1]} before, {after[1]} after"
        grown = (after[0] - before[0]) / 2**20
        print(f"{sum(counts)} states of {PAGES} pages, {min(counts)} to {max(counts)} each; "
              f"{grown:.1f} MiB more than before")
        limit = 400 if "asan" in lumenaut else 64
        assert grown < limit, grown
    assert v.process.returncode == 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
