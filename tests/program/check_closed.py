"""An independent check of extracted cuts: reads a PLY with numpy alone, welds bit-equal points, and counts border and
non-manifold edges. Shares no code with Colossus. As a program: check_closed.py CUT.ply..., status 1 if one is open."""
import sys

import numpy as np

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4",
             "float": "<f4", "double": "<f8", "uint8": "u1", "int32": "<i4", "float32": "<f4", "float64": "<f8"}


class Mesh:
    """points: (n, 3) doubles; triangles: (m, 3) indices; attributes: the other vertex properties by name."""

    def __init__(self, points, triangles, attributes=None):
        self.points = np.asarray(points, dtype=float).reshape(-1, 3)
        self.triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
        self.attributes = attributes or {}


def read_ply(path):
    """A little-endian PLY of vertices and triangles. Checks that the file is exactly as long as its header says."""
    with open(path, "rb") as file:
        header, body = file.read().split(b"end_header\n", 1)
    counts, vertex, index, element = {}, [], None, None
    for words in (line.split() for line in header.decode().splitlines()):
        if words[0] == "format":
            assert words[1] == "binary_little_endian", words
        elif words[0] == "element":
            element = words[1]
            counts[element] = int(words[2])
        elif words[0] == "property" and element == "vertex":
            vertex.append((words[2], PLY_TYPES[words[1]]))
        elif words[0] == "property" and element == "face":
            assert words[1] == "list" and index is None, words
            index = np.dtype([("count", PLY_TYPES[words[2]]), ("corners", PLY_TYPES[words[3]], 3)])
    vertex = np.dtype(vertex)
    split = counts["vertex"] * vertex.itemsize
    assert len(body) == split + counts["face"] * index.itemsize, "the file is not as long as its header says"
    vertices = np.frombuffer(body[:split], vertex)
    faces = np.frombuffer(body[split:], index)
    assert (faces["count"] == 3).all(), "a face is no triangle"
    corners = faces["corners"].astype(np.int64)
    assert corners.size == 0 or (corners.min() >= 0 and corners.max() < len(vertices)), "a face's index is out of range"
    points = np.stack([vertices[axis].astype(float) for axis in "xyz"], axis=1)
    return Mesh(points, corners, {name: vertices[name] for name in vertex.names if name not in "xyz"})


def weld(mesh):
    """Merges points whose coordinates are bit-equal, drops triangles with two equal corners. Negative zero is another
    value than zero: equal points must be bit-equal."""
    bits = np.ascontiguousarray(mesh.points).view(np.uint64)
    order = np.lexsort(bits.T[::-1])  # some ten times faster than np.unique of rows
    is_new = np.ones(len(bits), dtype=bool)
    is_new[1:] = (bits[order[1:]] != bits[order[:-1]]).any(axis=1)
    first = order[is_new]
    number = np.empty(len(bits), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    triangles = number[mesh.triangles]
    a, b, c = triangles.T
    return Mesh(mesh.points[first], triangles[(a != b) & (b != c) & (c != a)])


def edges(mesh):
    """The undirected edges, ends in order, with the number of triangles at each."""
    t = mesh.triangles
    a, b = np.concatenate([t[:, 0], t[:, 1], t[:, 2]]), np.concatenate([t[:, 1], t[:, 2], t[:, 0]])
    count = max(1, len(mesh.points))
    keys, uses = np.unique(np.minimum(a, b) * count + np.maximum(a, b), return_counts=True)
    return np.stack([keys // count, keys % count], axis=1), uses


def loops(border):
    """Border edges (k, 2) grouped into chains joined at shared ends: a list of arrays of edges."""
    if len(border) == 0:
        return []
    vertices, local = np.unique(border, return_inverse=True)
    local = local.reshape(-1, 2)
    label = np.arange(len(vertices))
    while True:
        least = np.minimum(label[local[:, 0]], label[local[:, 1]])
        before = label.copy()
        np.minimum.at(label, local[:, 0], least)
        np.minimum.at(label, local[:, 1], least)
        label = label[label]
        if (label == before).all():
            of_edge = label[local[:, 0]]
            order = np.argsort(of_edge, kind="stable")
            return np.split(border[order], np.flatnonzero(np.diff(of_edge[order])) + 1)


class Census:
    """What the welded surface is like."""

    def __init__(self, mesh):
        self.mesh = weld(mesh)
        ends, count = edges(self.mesh)
        self.border = ends[count == 1]
        self.nonmanifold = ends[count > 2]
        self.loops = loops(self.border)

    @property
    def is_closed(self):
        return len(self.border) == 0

    def __str__(self):
        return (f"{len(self.mesh.points)} points, {len(self.mesh.triangles)} triangles, {len(self.border)} border edges "
                f"in {len(self.loops)} loops, {len(self.nonmanifold)} non-manifold edges")


def area(mesh):
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def main(paths):
    is_closed = True
    for path in paths:
        census = Census(read_ply(path))
        is_closed = is_closed and census.is_closed
        print(f"{path}: {census}")
    return 0 if is_closed else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
