# SPDX-License-Identifier: Apache-2.0
# Pictures go to tev by its protocol: what it would show is what is written to the file.
scene=$here/scenes/box.xml
cat >tev.py <<'END'
"""tev.py PORT-FILE OUT: takes one connection; OUT.json says what was asked for, OUT.bin is the last picture."""
import array, json, os, socket, struct, sys
server = socket.create_server(("127.0.0.1", 0))
server.settimeout(30)
with open(sys.argv[1] + "~", "w") as f:
    f.write(str(server.getsockname()[1]))
os.rename(sys.argv[1] + "~", sys.argv[1])
connection, _ = server.accept()
data = b""
while more := connection.recv(1 << 16):
    data += more
said, picture, at = [], None, 0
while at < len(data):
    size, kind, focus = struct.unpack_from("<IBB", data, at)
    p, end = at + 6, at + size
    def text():
        global p
        start, p = p, data.index(b"\0", p) + 1
        return data[start:p - 1].decode()
    def ints(n, form="i"):
        global p
        values = struct.unpack_from(f"<{n}{form}", data, p)
        p += struct.calcsize(f"<{n}{form}")
        return values
    name = text()
    if kind == 4:
        width, height, n = ints(3)
        said.append({"create": name, "size": [width, height], "channels": [text() for _ in range(n)], "focus": focus})
        picture = array.array("f", bytes(4 * width * height * n))
    elif kind == 6:
        n, = ints(1)
        names = [text() for _ in range(n)]
        x, y, w, h = ints(4)
        offsets, strides = ints(n, "q"), ints(n, "q")
        pixels = array.array("f", data[p:end])
        assert (x, w, len(pixels)) == (0, width, w * h * n), (x, w, h)
        assert offsets == tuple(range(n)) and strides == (n,) * n, (offsets, strides)
        picture[y * w * n:(y + h) * w * n] = pixels
        p = end
        said.append({"update": name, "rows": [y, y + h], "channels": names})
    assert p == end, (kind, p, end)
    at = end
json.dump(said, open(sys.argv[2] + ".json", "w"))
open(sys.argv[2] + ".bin", "wb").write(picture.tobytes())
END
listen() { rm -f port; /usr/bin/python3 tev.py port "$1" & tev=$!; while [ ! -e port ]; do sleep 0.05; done; }

# A rough picture first, then the whole, in as many parts as it takes; the file is as without.
listen a
"$lumenaut" trace "$scene" -o a.pfm --spp 16 --size 700x300 -q --tev "127.0.0.1:$(cat port)"
wait $tev
"$lumenaut" trace "$scene" -o b.pfm --spp 16 --size 700x300 -q
cmp a.pfm b.pfm
json 'd[0] == {"create": "a.pfm", "size": [700, 300], "channels": ["R", "G", "B"], "focus": 1}' <a.json
json '[e["rows"] for e in d[1:]] == [[0, 124], [124, 248], [248, 300]] * 2' <a.json
/usr/bin/python3 - <<'END'
pfm, width, height = open("a.pfm", "rb").read(), 700, 300
body = pfm[-width * height * 12:]
rows = [body[y * width * 12:(y + 1) * width * 12] for y in range(height)]
assert b"".join(reversed(rows)) == open("a.bin", "rb").read()
END

# No file: all channels, by the name of the scene.
listen c
"$lumenaut" trace "$scene" --buffers --spp 2 -q --tev "127.0.0.1:$(cat port)"
wait $tev
json 'd[0]["create"].endswith("box.xml") and len(d[0]["channels"]) > 20 and len(d) == 2' <c.json

# One that is not there is told before any work; one that goes away costs nothing but the sight.
code 1 "$lumenaut" trace "$scene" -o c.pfm --tev 127.0.0.1:1 2>&1
code 2 "$lumenaut" trace "$scene" -o c.pfm --tev 127.0.0.1:http-x 2>&1
[ ! -e c.pfm ]
