#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""make_demo.py [FOLDER]    (default: scenes/demo)

Makes the meshes of the bundled scene: a torus knot and a turned vase, as binary PLY with normals.
Standard library only; the same bytes every time.
"""
import math
import pathlib
import struct
import sys

TAU = 2 * math.pi


def add(a, b, s=1.0):
    return tuple(x + s * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalize(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def write_ply(path, vertices, normals, triangles):
    header = ("ply\nformat binary_little_endian 1.0\n"
              "comment made by scripts/scenes/make_demo.py, CC0\n"
              f"element vertex {len(vertices)}\n"
              + "".join(f"property float {n}\n" for n in ("x", "y", "z", "nx", "ny", "nz"))
              + f"element face {len(triangles)}\nproperty list uchar int vertex_indices\n"
              "end_header\n")
    body = b"".join(struct.pack("<6f", *v, *n) for v, n in zip(vertices, normals))
    body += b"".join(struct.pack("<B3i", 3, *t) for t in triangles)
    path.write_bytes(header.encode() + body)


def grid(n_u, n_v, wrap_u, wrap_v):
    """Triangles of a grid of n_u x n_v vertices, u outermost."""
    triangles = []
    for i in range(n_u if wrap_u else n_u - 1):
        for j in range(n_v if wrap_v else n_v - 1):
            a, b = i * n_v + j, (i + 1) % n_u * n_v + j
            c, d = i * n_v + (j + 1) % n_v, (i + 1) % n_u * n_v + (j + 1) % n_v
            triangles += [(a, b, d), (a, d, c)]
    return triangles


def torus_knot(p=2, q=3, size=0.235, radius=0.07, n_along=260, n_around=20):
    """A tube around a (p, q) torus knot, standing on y = 0 with its axis along y."""
    def centre(t):
        r = 1.0 + 0.42 * math.cos(q * t)
        return (size * r * math.cos(p * t), size * 0.78 * math.sin(q * t),
                size * r * math.sin(p * t))

    vertices, normals = [], []
    for i in range(n_along):
        t, h = TAU * i / n_along, 1e-4
        here = centre(t)
        tangent = normalize(add(centre(t + h), centre(t - h), -1.0))
        side = normalize(cross(tangent, normalize(here)))
        up = cross(side, tangent)
        for j in range(n_around):
            a = TAU * j / n_around
            n = tuple(math.cos(a) * s + math.sin(a) * u for s, u in zip(side, up))
            vertices.append(add(here, n, radius))
            normals.append(n)
    low = min(v[1] for v in vertices)
    vertices = [(x, y - low, z) for x, y, z in vertices]
    return vertices, normals, grid(n_along, n_around, True, True)


def catmull_rom(points, n):
    """n + 1 points on a smooth curve through all points."""
    out = []
    last = len(points) - 1
    for k in range(n + 1):
        s = last * k / n
        i = min(int(s), last - 1)
        t = s - i
        p = [points[min(max(i + d, 0), last)] for d in (-1, 0, 1, 2)]
        out.append(tuple(0.5 * (2 * p[1][c] + (p[2][c] - p[0][c]) * t
                                + (2 * p[0][c] - 5 * p[1][c] + 4 * p[2][c] - p[3][c]) * t * t
                                + (3 * p[1][c] - p[0][c] - 3 * p[2][c] + p[3][c]) * t ** 3)
                         for c in (0, 1)))
    return out


def vase(n_profile=64, n_around=56):
    """A turned vase with a wall, open at the top; its foot is at y = 0."""
    outside = [(0.130, 0.000), (0.150, 0.012), (0.136, 0.040), (0.200, 0.140), (0.262, 0.290),
               (0.258, 0.420), (0.190, 0.570), (0.104, 0.690), (0.080, 0.780), (0.096, 0.860),
               (0.142, 0.915)]
    inside = [(0.132, 0.922), (0.086, 0.862), (0.068, 0.780), (0.090, 0.690), (0.110, 0.600)]
    profile = catmull_rom(outside + inside, n_profile)
    vertices, normals = [], []
    for k, (r, y) in enumerate(profile):
        before, after = profile[max(k - 1, 0)], profile[min(k + 1, n_profile)]
        dr, dy = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dy)
        for j in range(n_around):
            a = TAU * j / n_around
            c, s = math.cos(a), math.sin(a)
            vertices.append((r * c, y, r * s))
            normals.append((dy / length * c, -dr / length, dy / length * s))
    triangles = [(a, c, b) for a, b, c in grid(n_profile + 1, n_around, False, True)]
    return vertices, normals, triangles


def facing_outward(vertices, normals, triangles):
    """Triangles turned so that their winding agrees with the normals."""
    out = []
    for a, b, c in triangles:
        n = cross(add(vertices[b], vertices[a], -1.0), add(vertices[c], vertices[a], -1.0))
        agrees = sum(x * y for x, y in zip(n, normals[a])) >= 0
        out.append((a, b, c) if agrees else (a, c, b))
    return out


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "scenes/demo"
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    for name, (vertices, normals, triangles) in (("knot", torus_knot()), ("vase", vase())):
        path = folder / "meshes" / f"{name}.ply"
        write_ply(path, vertices, normals, facing_outward(vertices, normals, triangles))
        print(f"{path}: {len(triangles)} triangles, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
