#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""training.py LUMENAUT: a training that is watched, as viewer/PROTOCOL.md describes it."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from client import Client, Closed, Viewer

ROOT = pathlib.Path(__file__).parents[2]
SCENE = str(ROOT / "tests/cli/scenes/box.xml")
SMALL = ["--width", "16", "--depth", "1", "--spp", "4", "--memory", "8", "--eval-every", "never"]


def drain(client):
    try:
        while True:
            client.receive()
    except (Closed, ConnectionError):
        pass


def check_told(client):
    """The curve, the states, and pictures that follow the network."""
    hello = client.hello
    assert hello["can_train"] and hello["layers"][0] == "neural"
    first = client.text("training")
    assert first["running"] and isinstance(first["history"], list) and first["message"] is None
    assert first["acceptance"] is None and first["reuse"] is None  # the improved method has no chains
    later = client.text("training", lambda t: t["step"] > first["step"] and t["states"])
    assert "history" not in later and len(later["point"]) == 2 and later["loss"] > 0
    ranges = [(v["min"], v["max"]) for v in hello["variables"]]
    for values in later["states"]:
        assert len(values) == len(ranges)
        assert all(low - 1e-6 <= x <= high + 1e-6 for x, (low, high) in zip(values, ranges)), values
    state, pictures, end = client.state(), set(), time.monotonic() + 30
    while len(pictures) < 3 and time.monotonic() < end:  # many pictures fit between two steps
        pictures.add(client.frame(state["version"]).bytes)
    assert len(pictures) == 3, "the picture does not follow the training"


def check_orders(client):
    """Pause, save, go on, stop."""
    client.send({"type": "train", "action": "rest"})
    assert "action" in client.text("error")["message"]
    client.send({"type": "train", "action": "pause"})
    paused = client.text("training", lambda t: not t["running"])
    state = client.state(width=48, height=32)
    assert client.frame(state["version"], lambda f: f.is_final).spp == 64  # at rest now
    client.texts.clear()
    assert client.text("training")["step"] == paused["step"]
    assert not os.path.exists("m.lmn")
    client.send({"type": "train", "action": "save"})
    while not os.path.exists("m.lmn"):
        client.text("training")
    client.send({"type": "train", "action": "start"})
    client.text("training", lambda t: t["running"] and t["step"] > paused["step"])
    client.send({"type": "train", "action": "stop"})
    drain(client)


def check_same_bytes(lumenaut):
    """Who looks changes nothing of what is learnt."""
    run = ["-o", "alone.lmn", "--steps", "60", *SMALL]
    subprocess.run([lumenaut, "train", SCENE, "-q", *run], check=True, timeout=120)
    run[1] = "seen.lmn"
    with Viewer(lumenaut, SCENE, *run, "--view", command="train") as v:
        try:
            with Client(v.port) as c:
                while True:
                    c.state(layers=["neural", "traced"], moving=c.version % 2 == 0)
                    c.next_frame()
        except (Closed, ConnectionError):
            pass
        assert v.process.wait(60) == 0, v.process.stderr.read()
    assert pathlib.Path("alone.lmn").read_bytes() == pathlib.Path("seen.lmn").read_bytes()


def come_back(port, where, path, seconds=60):
    """A session of the first viewer at this port whose hello fits."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            client = Client(port, path, timeout=20)
            if where(client.hello):
                return client
            client.socket.close()
        except (Closed, OSError):
            pass
        time.sleep(0.1)
    raise TimeoutError


def check_started(lumenaut):
    """From a scene to a training to its model, and on, at one address."""
    def is_training(hello):
        return hello["can_train"] and hello["commands"]["train"] is None

    with Viewer(lumenaut, SCENE, "--bind", "127.0.0.1", "--token", "t-1") as v:
        path = "/socket?token=t-1"
        first = come_back(v.port, lambda hello: True, path)
        command = first.hello["commands"]["train"]
        assert command == ["lumenaut", "train", SCENE, "-o", "box.lmn", "--view"], command
        assert first.hello["model"] is None and "neural" not in first.hello["layers"]
        first.send({"type": "train", "action": "pause"})
        assert "under way" in first.text("error")["message"]
        # What cannot be trained is told, and the scene is shown as before.
        os.mkdir("box.lmn")
        first.send({"type": "train", "action": "start"})
        drain(first)
        second = come_back(v.port, lambda hello: hello["notice"], path)
        assert "failed" in second.hello["notice"] and second.hello["model"] is None
        os.rmdir("box.lmn")
        second.send({"type": "train", "action": "start"})
        drain(second)
        with come_back(v.port, is_training, path) as c:
            steps = c.text("training", lambda t: t["step"] > 3)["step"]
            state = c.state(layers=["neural"])
            c.frame(state["version"])
            c.send({"type": "train", "action": "stop"})
            drain(c)
        with come_back(v.port, lambda hello: hello["model"], path) as c:
            assert c.hello["model"] == "box.lmn" and c.hello["notice"] is None
            c.frame(c.state(layers=["neural"])["version"])
            command = c.hello["commands"]["train"]
            assert command[:6] == ["lumenaut", "train", SCENE, "-o", "box.lmn", "--resume"], command
            c.send({"type": "train", "action": "start"})
            drain(c)
        with come_back(v.port, is_training, path) as c:
            assert c.text("training")["step"] >= steps
            c.send({"type": "train", "action": "stop"})
            drain(c)
        come_back(v.port, lambda hello: hello["model"], path).socket.close()
    assert v.process.returncode == 0, v.process.returncode


def main():
    lumenaut = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with Viewer(lumenaut, SCENE, "-o", "m.lmn", "--time", "10m", *SMALL, "--view", command="train") as v:
            with Client(v.port) as c:
                check_told(c)
                check_orders(c)
            assert v.process.wait(60) == 0, v.process.stderr.read()
        check_same_bytes(lumenaut)
        check_started(lumenaut)
    return 0


if __name__ == "__main__":
    sys.exit(main())
