#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""protocol.py LUMENAUT: the viewer's server as viewer/PROTOCOL.md describes it, without a browser."""
import http.client
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from client import Client, Closed, Viewer

ROOT = pathlib.Path(__file__).parents[2]
SCENE = str(ROOT / "tests/cli/scenes/box.xml")


def get(port, path, **headers):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def refused(*arguments, **options):
    """The status, or the code, with which a connection is refused."""
    try:
        Client(*arguments, **options)
    except Closed as why:
        return why.args[0]
    raise AssertionError("it was let in")


def jpeg_size(data):
    """Width and height in a JPEG's frame header."""
    assert data[:2] == b"\xff\xd8" and data[-2:] == b"\xff\xd9", data[:16]
    at = 2
    while data[at + 1] not in (0xC0, 0xC2):
        at += 2 + int.from_bytes(data[at + 2:at + 4], "big")
    return int.from_bytes(data[at + 7:at + 9], "big"), int.from_bytes(data[at + 5:at + 7], "big")


def check_files(viewer):
    answer, body = get(viewer.port, "/")
    assert answer.status == 200 and b"<html" in body, answer.status
    assert answer.headers["content-type"].startswith("text/html")
    policy = answer.headers["content-security-policy"]
    assert "default-src 'self'" in policy and "unsafe" not in policy, policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    for path in ("/nothing", "/../etc/passwd", "/socket/", "/view", "/index.html"):
        assert get(viewer.port, path)[0].status == 404, path
    assert get(viewer.port, "/", Host="evil.example")[0].status == 403
    assert get(viewer.port, "/", Host="localhost:9000")[0].status == 200  # a tunnel's other end


def check_doors(viewer):
    port = viewer.port
    assert refused(port, headers={"Host": "evil.example"}) == 403
    assert refused(port, headers={"Origin": "http://evil.example"}) == 403
    assert refused(port, headers={"Origin": "null"}) == 403
    assert refused(port, headers={"Origin": f"http://localhost:{port}"}) == 403  # not of this Host
    assert refused(port, path="/") == 403
    assert refused(port, protocol="other") != 101
    assert refused(port, protocol=None) == 403
    with Client(port, headers={"Origin": f"http://127.0.0.1:{port}"}) as c:
        assert c.hello["protocol"] == 1


def check_hello(viewer):
    with Client(viewer.port) as c:
        hello = c.hello
    names = [v["name"] for v in hello["variables"]]
    assert names == ["slide", "tint.r", "tint.g", "tint.b", "gloss", "shown"], names
    assert hello["variables"][0]["min"] == -1 and hello["variables"][0]["value"] == 0
    assert hello["variables"][5]["choices"] == ["off", "on"] and hello["variables"][5]["max"] == 1
    assert hello["size"] == [48, 32] and not hello["orthographic"]
    assert hello["camera"]["origin"] == [0, 1.5, 5] and hello["camera"]["fov"] == 45
    return hello


def check_frames(viewer):
    with Client(viewer.port) as c:
        layer = c.hello["layers"][0]
        sizes = []
        for i in range(3):
            state = c.state(width=320, height=200, moving=True, values=[i / 3, 1, 1, 1, .2, 1])
            frame = c.frame(state["version"])
            assert frame.version == state["version"] and jpeg_size(frame.bytes) == (frame.width, frame.height)
            assert (frame.full_width, frame.full_height) == (320, 200)
            sizes.append(frame.width)
        assert min(sizes) >= 80, sizes  # the least share
        # At rest: the full size, then better ones, which end.
        state = c.state(width=64, height=40)
        frame = c.frame(state["version"], lambda f: f.width == 64)
        better = c.frame(state["version"], lambda f: f.spp > frame.spp)
        assert better.version == state["version"] and better.height == 40
        if layer == "neural":
            last = better if better.is_final else c.frame(state["version"], lambda f: f.is_final)
            assert last.spp == 64
        # Each buffer, and two layers at once.
        pictures = set()
        for name in ("albedo", "normal", "position", "roughness", "depth", "emission"):
            state = c.state(layers=[name])
            frame = c.frame(state["version"])
            assert frame.layer == 3 and frame.is_final, name
            pictures.add(frame.bytes)
        assert len(pictures) == 6
        state = c.state(layers=["traced", "normal"])
        seen = {c.frame(state["version"]).layer for _ in range(6)}
        assert seen == {1, 3}, seen
        # Values, camera and exposure change the picture.
        first = c.frame(c.state(layers=["depth"])["version"]).bytes
        moved = c.frame(c.state(layers=["depth"], values=[.8, 1, 1, 1, .2, 1])["version"]).bytes
        camera = dict(c.hello["camera"], origin=[2, 1, 4])
        turned = c.frame(c.state(layers=["depth"], camera=camera)["version"]).bytes
        assert len({first, moved, turned}) == 3
        dark = c.frame(c.state(layers=["traced"], exposure=1e-6)["version"], lambda f: f.width == 96)
        light = c.frame(c.state(layers=["traced"], tone="aces")["version"], lambda f: f.width == 96)
        assert len(light.bytes) > 2 * len(dark.bytes)
        stats = c.text("stats")
        assert stats["sessions"] == 1 and stats["render_ms"] > 0 and stats["encode_ms"] > 0


def check_latest_wins(viewer):
    """States faster than pictures: versions rise, and the last is reached."""
    with Client(viewer.port) as c:
        for i in range(300):
            c.state(width=320, height=200, moving=True, values=[i / 300, 1, 1, 1, .2, 1])
        last, versions = c.version, []
        while not versions or versions[-1] < last:
            versions.append(c.next_frame().version)
        assert versions == sorted(versions) and len(versions) < 100, versions
        # Without acknowledgement no more than two come.
        c.state(layers=["traced"], width=64, height=40)
        while not c.frames:
            c.receive()
        time.sleep(1.5)
        c.socket.settimeout(0.3)
        try:
            while True:
                c.receive()
        except TimeoutError:
            pass
        assert len(c.frames) <= 2, len(c.frames)
        c.socket.settimeout(30)
        numbers = [f.number for f in c.frames]
        for frame in list(c.frames):
            c.acknowledge(frame)
        c.frames.clear()
        assert c.next_frame().number > max(numbers)


def check_questions(viewer, has_network):
    with Client(viewer.port) as c:
        c.send({"type": "pixel", "id": 1, "x": 0, "y": 0})
        assert "outside" in c.text("error")["message"]  # no picture yet
        state = c.state(layers=["traced"], width=96, height=64)
        c.frame(state["version"], lambda f: f.width == 96)
        c.send({"type": "pixel", "id": 7, "x": 48, "y": 60})
        pixel = c.text("pixel")
        assert pixel["id"] == 7 and pixel["version"] == state["version"]
        values = pixel["values"]
        assert abs(values["normal"][1] - 1) < 1e-4 and values["roughness"] == [1], values  # the floor
        assert 1 < values["depth"][0] < 6 and min(values["traced"]) > 0
        c.send({"type": "pixel", "id": 8, "x": 96, "y": 0})
        assert "outside" in c.text("error")["message"]
        for form, magic in (("png", b"\x89PNG"), ("exr", b"\x76\x2f\x31\x01")):
            c.send({"type": "capture", "id": 9, "layer": "traced", "format": form})
            said = c.text("capture")
            while True:
                frame = c.next_frame()
                if frame.layer == 255:
                    break
            assert said["id"] == frame.number == 9 and len(frame.bytes) == said["size"]
            assert frame.bytes.startswith(magic) and said["name"].endswith(form)
        if not has_network:
            c.send({"type": "capture", "id": 9, "layer": "neural", "format": "png"})
            assert "network" in c.text("error")["message"]


BAD = ["", "{", "[]", "3", "null", '"state"', '{"type":3}', '{"type":"nothing"}', '{"type":"ack"}',
       '{"type":"ack","frame":-1}', '{"type":"ack","frame":1.5}', '{"type":"pixel","id":1,"x":1}',
       '{"type":"train","action":"pause"}', '{"type":"ack","frame":1,"frame":2}',
       '{"type":"capture","id":1,"layer":"x","format":"png"}', '{"type":"pixel","id":1,"x":5000,"y":1}']


def check_bad_messages(viewer):
    with Client(viewer.port) as c:
        for text in BAD:
            c.send_raw(text.encode())
            why = c.text("error")["message"]
            assert 5 < len(why) < 220, (text, why)
        state = c.state()
        c.frame(state["version"])
    # Faulty states change nothing.
    with Client(viewer.port) as c:
        good = c.state()
        c.frame(good["version"])
        faults = [{"values": [1]}, {"values": "x"}, {"values": [0, 0, 0, 0, 0, "a"]}, {"version": 1},
                  {"version": -1}, {"width": 8}, {"height": 5000}, {"layers": []},
                  {"layers": ["traced", "traced"]}, {"layers": ["albedo", "depth"]}, {"layers": ["sun"]},
                  {"exposure": 0}, {"tone": "film"}, {"rate": 0}, {"least": 2}, {"camera": {}},
                  {"camera": {"origin": [1, 2], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 40}}]
        for fault in faults:
            c.send({**good, "version": c.version + 1, **fault})
            assert c.text("error")["message"], fault
    # What only the library can know is told as well, and the session goes on.
    with Client(viewer.port) as c:
        c.state(values=[7, 1, 1, 1, .2, 1])
        assert "slide" in c.text("error")["message"]
        camera = dict(c.hello["camera"], target=c.hello["camera"]["origin"])
        c.state(camera=camera)
        assert "camera" in c.text("error")["message"]
        c.frame(c.state()["version"])
    # Too much of it ends the session, for the others nothing changes.
    with Client(viewer.port) as other:
        with Client(viewer.port) as c:
            try:
                for _ in range(25):
                    c.send_raw(b"no")
                while True:
                    c.receive()
            except Closed as why:
                assert why.args[0] == 1008, why
        with Client(viewer.port) as c:
            try:
                c.send_raw(b" " * 70000)
                while True:
                    c.receive()
            except Closed as why:
                assert why.args[0] == 1009, why
        other.frame(other.state()["version"])


def check_fragments(viewer):
    with Client(viewer.port) as c:
        c.version = 5
        text = json.dumps({"type": "state", "version": 5, "values": [0, 1, 1, 1, .2, 1], "camera": None,
                           "layers": ["depth"], "width": 64, "height": 40, "exposure": 1, "tone": "srgb",
                           "moving": False, "rate": 12, "least": .25}).encode()
        for i in range(0, len(text), 7):
            c.send_raw(text[i:i + 7], opcode=1 if i == 0 else 0, final=i + 7 >= len(text))
            if i == 21:
                c.send_raw(b"are you there", opcode=9)
        assert c.frame(5).layer == 3
        c.send_raw(b"\xff\xfe", opcode=2)
        assert "text" in c.text("error")["message"]


def check_token(lumenaut):
    with Viewer(lumenaut, SCENE, "--bind", "127.0.0.1", "--token", "abc-1") as v:
        assert v.url.endswith("/?token=abc-1"), v.url
        assert get(v.port, "/")[0].status == 200  # the page has no secret
        assert refused(v.port) == 403
        assert refused(v.port, path="/socket?token=abc-2") == 403
        assert refused(v.port, path="/socket?token=abc-11") == 403
        with Client(v.port, path="/socket?token=abc-1") as c:
            assert c.hello["protocol"] == 1
    with Viewer(lumenaut, SCENE, "--bind", "0.0.0.0") as v:
        assert len(v.url.split("token=")[1]) == 32, v.url
        assert refused(v.port) == 403


def check_ports(lumenaut):
    with Viewer(lumenaut, SCENE, default_port=True) as first:
        with Viewer(lumenaut, SCENE, default_port=True) as second:
            assert first.port != second.port
        taken = subprocess.run([lumenaut, "view", SCENE, "--port", str(first.port)], capture_output=True,
                               text=True, timeout=60)
        assert taken.returncode == 1 and "taken" in taken.stderr, taken
    for arguments in (["--port", "0"], ["--token", "a b"], ["--port", "99999"], ["--bind", "nowhere"], ["--bind", "::1"]):
        run = subprocess.run([lumenaut, "view", SCENE, *arguments], capture_output=True, text=True, timeout=60)
        assert run.returncode == 2 and run.stderr.count("\n") == 1, run


def step(name):
    if os.environ.get("VERBOSE"):
        print(f"{time.strftime('%H:%M:%S')} {name}", flush=True)


def check_all(lumenaut, path, has_network):
    with Viewer(lumenaut, path, "-t", "2") as v:
        step("check_files")
        check_files(v)
        step("check_doors")
        check_doors(v)
        hello = check_hello(v)
        assert ("neural" in hello["layers"]) == has_network == (hello["model"] is not None)
        step("check_frames")
        check_frames(v)
        step("check_latest_wins")
        check_latest_wins(v)
        step("check_questions")
        check_questions(v, has_network)
        step("check_bad_messages")
        check_bad_messages(v)
        step("check_fragments")
        check_fragments(v)
        if has_network:
            check_error(v, lumenaut, path)
            check_network(v, lumenaut, path)
    assert v.process.returncode == 0, v.process.returncode


def check_error(viewer, lumenaut, model):
    """Figures beside the error map are those of `lumenaut compare` of the same samples."""
    with Client(viewer.port) as c:
        state = c.state(layers=["neural", "traced", "error"], width=96, height=64,
                        values=[.4, .9, .5, .1, .3, 1])
        page = {"neural_spp": 0}
        while page["neural_spp"] < 64:
            c.frame(state["version"], lambda f: f.layer == 2)
            page = c.text("metrics")
    assert page["version"] == state["version"]
    same = ["-q", "-P", "slide=.4", "-P", "tint=.9,.5,.1", "-P", "gloss=.3", "--size", "96x64", "-o"]
    subprocess.run([lumenaut, "render", model, *same, "n.exr", "--spp", "64"], check=True, timeout=60)
    subprocess.run([lumenaut, "trace", SCENE, *same, "t.exr", "--spp", str(page["traced_spp"]),
                    "--integrator", "path"], check=True, timeout=60)
    run = subprocess.run([lumenaut, "compare", "n.exr", "t.exr", "--json"], check=True, timeout=60,
                         capture_output=True, text=True)
    figures = json.loads(run.stdout)["metrics"]
    for name in ("mape", "relmse", "flip", "psnr"):  # files keep half the digits
        assert abs(page[name] - figures[name]) <= 1e-3 * abs(figures[name]), (name, page, figures)


def check_network(viewer, lumenaut, model):
    """Files are those of `lumenaut render`, whose command line the page copies."""
    with Client(viewer.port) as c:
        camera = dict(c.hello["camera"], origin=[1, 2, 4])
        c.state(values=[.5, .9, .5, .1, .3, 1], camera=camera, width=90, height=60)
        c.send({"type": "capture", "id": 3, "layer": "neural", "format": "png"})
        words = c.text("capture", lambda t: t["id"] == 3)
        while (frame := c.next_frame()).layer != 255:
            pass
        assert words["size"] == len(frame.bytes)
        command = c.hello["commands"]["render"]
        numbers = [",".join(repr(x) for x in camera[k]) for k in ("origin", "target", "up")]
        subprocess.run([lumenaut, *command[1:], "-q", "-P", "slide=.5", "-P", "tint=.9,.5,.1", "-P",
                        "gloss=.3", "--origin", numbers[0], "--target", numbers[1], "--up", numbers[2],
                        "--fov", str(camera["fov"]), "--size", "90x60"], check=True, timeout=60)
        assert pathlib.Path("picture.png").read_bytes() == frame.bytes


def main():
    lumenaut = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        check_all(lumenaut, SCENE, False)
        subprocess.run([lumenaut, "train", SCENE, "-q", "-o", "m.lmn", "--width", "16", "--depth", "1",
                        "--steps", "30", "--spp", "4", "--memory", "8", "--eval-every", "never"],
                       check=True, timeout=120)
        check_all(lumenaut, "m.lmn", True)
        check_token(lumenaut)
        check_ports(lumenaut)
    return 0


if __name__ == "__main__":
    sys.exit(main())
