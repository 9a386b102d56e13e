#!/usr/bin/env python3
"""Reads a Colossus container with h5py, numpy and zstandard only, following schemas/container.md.

read_container.py statue.h5                          what is inside, level by level
read_container.py statue.h5 --nodes                  one line per node
read_container.py statue.h5 --level 3 -o out.ply     all nodes of level 3 (of diamonds not a conforming cut)
read_container.py statue.h5 --finest -o out.ply      all leaf nodes: the finest mesh
read_container.py statue.h5 --node 7 --node 8 -o out.ply

The PLY is binary, with positions as doubles. Tetrahedra and cubes are not joined: points that several of them have
appear once in each, with equal bits.
"""
import argparse
import itertools
import struct
import sys

import h5py
import numpy
import zstandard

SCHEMA_MAJOR = 1
IS_LEAF = 1
HAS_NORMALS, HAS_COLORS, HAS_PARENTS = 1, 2, 4


class BadContainer(Exception):
    pass


# ---------------------------------------------------------------------------------------------- file and node table

class Container:
    def __init__(self, path):
        try:
            self.file = h5py.File(path, "r")
        except OSError as error:
            raise BadContainer(f"{path}: cannot open as an HDF5 file: {error}")
        root = self.file.attrs
        if root.get("format") not in (b"colossus", "colossus"):
            raise BadContainer(f"{path}: is an HDF5 file, but no Colossus container")
        self.version = tuple(int(v) for v in root["schema_version"])
        if self.version[0] != SCHEMA_MAJOR:
            raise BadContainer(f"{path}: schema version {self.version}: this program reads {SCHEMA_MAJOR}.x")
        scheme = root["scheme"]
        self.scheme = scheme.decode() if isinstance(scheme, bytes) else str(scheme)
        if self.scheme not in DECODERS:
            raise BadContainer(f"{path}: scheme {self.scheme}: this program reads {' and '.join(DECODERS)}")
        self.attributes = int(root["attributes"])
        lattice = self.file["lattice"].attrs
        self.origin = numpy.array(lattice["origin"], dtype="<f8")
        self.step = float(lattice["step"])
        self.root_bits = int(lattice["root_bits"])
        self.parameters = {}
        if "parameters" in self.file:
            self.parameters = {r["name"].decode(): float(r["value"]) for r in self.file["parameters"][:]}
        self.nodes = self.file["nodes"][:]
        self.raw = open(path, "rb")

    def payload(self, index):
        """The decoded chunk of a node: a plain byte range of the file, one zstd frame, cut to the payload's size."""
        node = self.nodes[index]
        self.raw.seek(int(node["offset"]))
        frame = self.raw.read(int(node["stored_bytes"]))
        # The same bytes through HDF5: the chunk number chunk_index of the dataset of the node's class.
        dataset = self.file[f"chunks/class_{node['chunk_class']}"]
        capacity = dataset.chunks[0]
        mask, chunk = dataset.id.read_direct_chunk((int(node["chunk_index"]) * capacity,))
        if mask != 0 or chunk != frame:
            raise BadContainer(f"node {index}: the byte range and HDF5's chunk differ")
        content = zstandard.ZstdDecompressor().decompress(frame)
        size = int(node["payload_bytes"])
        if len(content) != capacity or any(content[size:]):
            raise BadContainer(f"node {index}: expected {capacity} bytes, zeros behind {size}; found {len(content)}")
        return content[:size]


# --------------------------------------------------------------------------------------------- hierarchy arithmetic

def diamond(level, center, root_bits):
    """Corners of all 6, 4 or 8 tetrahedra of a diamond, in the order of their places: an array (places, 4, 3)."""
    side = 2 ** root_bits >> (level // 3)
    half = side // 2
    center = numpy.array(center, dtype=numpy.int64)
    unit = numpy.eye(3, dtype=numpy.int64)
    # An odd multiple of half a side lies inside an interval of the grid of cubes; its parity gives the direction.
    is_odd = (center // half) % 2 == 1
    sign = numpy.where((center // side) % 2 == 0, 1, -1)
    inside = [a for a in range(3) if is_odd[a]]
    across = [a for a in range(3) if not is_odd[a]]
    if len(inside) != 3 - level % 3:
        raise BadContainer(f"level {level}: no diamond has the centre {tuple(center)}")
    tetrahedra = []
    if level % 3 == 0:  # a cube's diagonal, six Kuhn simplices along it
        start = center - half * sign
        for a, b, _ in itertools.permutations(range(3)):
            first = start + side * sign[a] * unit[a]
            second = first + side * sign[b] * unit[b]
            tetrahedra.append((start, first, second, center + half * sign))
    elif level % 3 == 1:  # a square's diagonal; the square's other corners; the cubes' centres on both sides
        a, b = inside
        along = half * (sign[a] * unit[a] + sign[b] * unit[b])
        beside = half * (sign[a] * unit[a] - sign[b] * unit[b])
        for corner in (center - beside, center + beside):
            for cube in (center - half * unit[across[0]], center + half * unit[across[0]]):
                tetrahedra.append((center - along, center + along, corner, cube))
    else:  # a cube's edge; a cube's centre beside it; the centre of a square of that cube that has the edge
        along = half * unit[inside[0]]
        for s, t in itertools.product((-1, 1), repeat=2):
            steps = (s * half * unit[across[0]], t * half * unit[across[1]])
            for step in steps:
                tetrahedra.append((center - along, center + along, center + steps[0] + steps[1], center + step))
    tetrahedra = [sorted(tuple(int(x) for x in corner) for corner in t) for t in tetrahedra]
    return numpy.array(sorted(tetrahedra), dtype=numpy.int64)


# -------------------------------------------------------------------------------------------------- payload decoding

class Reader:
    def __init__(self, data):
        self.data, self.offset = data, 0

    def take(self, dtype, count=1):
        size = numpy.dtype(dtype).itemsize * count
        if size > len(self.data) - self.offset:
            raise BadContainer(f"payload: expected {size} bytes at {self.offset} of {len(self.data)}")
        values = numpy.frombuffer(self.data, dtype, count, self.offset)
        self.offset += size
        return values


def index_type(vertex_count):
    return "<u1" if vertex_count < 2**8 else "<u2" if vertex_count < 2**16 else "<u4"


def decode_payload(data):
    """(position_bits, flags, list of dicts: place, weights (n, 4), marks (n), normals, colors, triangles (t, 3))."""
    reader = Reader(data)
    codec, version, bits, flags, count = (int(v) for v in reader.take("<u1", 5))
    if (codec, version) != (1, 1):
        raise BadContainer(f"payload: expected codec 1 version 1, found {codec} version {version}")
    heads = [struct.unpack("<BII", reader.take("<u1", 9).tobytes()) for _ in range(count)]
    tetrahedra = []
    for place, n, t in heads:
        weight = "<u2" if bits < 16 else "<u4"
        weights = numpy.stack([reader.take(weight, n) for _ in range(3)], axis=1).astype(numpy.int64)
        last = 2**bits - weights.sum(axis=1, keepdims=True)
        if (last < 0).any():
            raise BadContainer(f"payload: weights at place {place} sum to more than 2^{bits}")
        part = {"place": place, "weights": numpy.hstack([weights, last]), "marks": reader.take("<u1", n)}
        part["normals"] = decode_normals(reader.take("<u1", n), reader.take("<u1", n)) if flags & HAS_NORMALS else None
        part["colors"] = numpy.stack([reader.take("<u1", n) for _ in range(4)], axis=1) if flags & HAS_COLORS else None
        part["triangles"] = decode_corners(reader.take(index_type(n), 3 * t), n).reshape(-1, 3)
        tetrahedra.append(part)
    if reader.offset != len(data):
        raise BadContainer(f"payload: {len(data) - reader.offset} bytes left over")
    return bits, flags, tetrahedra


def decode_cube_payload(data):
    """A dict: flags, positions (n, 3) on the lattice, normals, colors, parents (n) or None, triangles (t, 3), used."""
    reader = Reader(data)
    codec, version, flags, width, parent_bytes = (int(v) for v in reader.take("<u1", 5))
    if (codec, version) != (2, 1):
        raise BadContainer(f"payload: expected codec 2 version 1, found {codec} version {version}")
    if width > 32 or parent_bytes not in ((1, 2, 4) if flags & HAS_PARENTS else (0,)):
        raise BadContainer(f"payload: width {width}, {parent_bytes} bytes per parent")
    n, t = (int(v) for v in reader.take("<u4", 2))
    offset = reader.take("<i4", 3).astype(numpy.int64)
    axes = []
    for axis in range(3):
        planes = [reader.take("<u1", n).astype(numpy.int64) << 8 * byte for byte in range(max(1, (width + 7) // 8))]
        axes.append(offset[axis] + sum(planes))
    cube = {"flags": flags, "positions": numpy.stack(axes, axis=1)}
    if n and cube["positions"].max() >= 2**31:
        raise BadContainer("payload: a coordinate is out of range")
    cube["normals"] = decode_normals(reader.take("<u1", n), reader.take("<u1", n)) if flags & HAS_NORMALS else None
    cube["colors"] = numpy.stack([reader.take("<u1", n) for _ in range(4)], axis=1) if flags & HAS_COLORS else None
    cube["parents"] = reader.take(f"<u{parent_bytes}", n).astype(numpy.int64) if flags & HAS_PARENTS else None
    codes = reader.take(index_type(n), 3 * t)
    cube["used"] = int((codes == 0).sum())
    if cube["used"] > n:
        raise BadContainer(f"payload: triangles use {cube['used']} of {n} vertices")
    cube["triangles"] = decode_corners(codes, cube["used"]).reshape(-1, 3)
    if reader.offset != len(data):
        raise BadContainer(f"payload: {len(data) - reader.offset} bytes left over")
    return cube


def decode_corners(codes, vertex_count):
    """A code is high water minus index; each 0 names the next new vertex and lifts the high water by one."""
    codes = codes.astype(numpy.int64)
    is_new = (codes == 0).astype(numpy.int64)
    indices = numpy.cumsum(is_new) - is_new - codes
    if is_new.sum() != vertex_count or (indices < 0).any():
        raise BadContainer(f"payload: triangles use {is_new.sum()} of {vertex_count} vertices, or a wrong one")
    return indices


def decode_normals(u, v):
    x, y = u / 127.5 - 1.0, v / 127.5 - 1.0
    z = 1.0 - abs(x) - abs(y)
    folded_x = numpy.where(z < 0, (1.0 - abs(y)) * numpy.where(x < 0, -1.0, 1.0), x)
    folded_y = numpy.where(z < 0, (1.0 - abs(x)) * numpy.where(y < 0, -1.0, 1.0), y)
    normals = numpy.stack([folded_x, folded_y, z], axis=1)
    return normals / numpy.sqrt((normals * normals).sum(axis=1, keepdims=True))


def decode_node(container, index):
    """World positions, normals, colours and triangles of one node."""
    return DECODERS[container.scheme](container, index)


def decode_cube(container, index):
    """Without the vertices that only parent maps name: they come last."""
    node, cube = container.nodes[index], decode_cube_payload(container.payload(index))
    if (len(cube["positions"]), len(cube["triangles"])) != (node["vertices"], node["triangles"]):
        raise BadContainer(f"node {index}: expected {node['vertices']} vertices, {node['triangles']} triangles")
    if (cube["flags"] & HAS_PARENTS != 0) != (node["level"] > 0):
        raise BadContainer(f"node {index}: expected parents at all levels but 0")
    used = cube["used"]
    world = container.origin + container.step * cube["positions"][:used]
    normals, colors = (None if values is None else values[:used] for values in (cube["normals"], cube["colors"]))
    return world, normals, colors, cube["triangles"]


def decode_diamond(container, index):
    """Its tetrahedra one after the other."""
    node = container.nodes[index]
    bits, flags, parts = decode_payload(container.payload(index))
    corners = diamond(int(node["level"]), node["center"], container.root_bits)
    positions, triangles, start = [], [], 0
    for part in parts:
        scaled = part["weights"] @ corners[part["place"]]  # exact: 64-bit integers, lattice position times 2^bits
        positions.append(container.origin + (container.step / 2**bits) * scaled)
        triangles.append(part["triangles"] + start)
        start += len(scaled)
    join = numpy.concatenate
    if sum(1 << part["place"] for part in parts) != node["tetra_mask"]:
        raise BadContainer(f"node {index}: expected tetrahedra {node['tetra_mask']:#x}")
    if start != node["vertices"] or sum(map(len, triangles)) != node["triangles"]:
        raise BadContainer(f"node {index}: expected {node['vertices']} vertices, {node['triangles']} triangles")
    return (join(positions) if parts else numpy.zeros((0, 3)),
            join([p["normals"] for p in parts]) if parts and flags & HAS_NORMALS else None,
            join([p["colors"] for p in parts]) if parts and flags & HAS_COLORS else None,
            join(triangles) if parts else numpy.zeros((0, 3), dtype=numpy.int64))


DECODERS = {"diamonds": decode_diamond, "blocks": decode_cube}


# --------------------------------------------------------------------------------------------------------- programs

def write_ply(path, meshes, attributes):
    fields = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
    if attributes & HAS_NORMALS:
        fields += [("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4")]
    if attributes & HAS_COLORS:
        fields += [(c, "u1") for c in ("red", "green", "blue", "alpha")]
    vertices = numpy.zeros(sum(len(m[0]) for m in meshes), dtype=fields)
    faces = numpy.zeros(sum(len(m[3]) for m in meshes), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    faces["count"] = 3
    v = f = 0
    for positions, normals, colors, triangles in meshes:
        part = vertices[v:v + len(positions)]
        for values, names in ((positions, "x y z"), (normals, "nx ny nz"), (colors, "red green blue alpha")):
            if values is not None:
                for column, name in enumerate(names.split()):
                    part[name] = values[:, column]
        faces["indices"][f:f + len(triangles)] = triangles + v
        v, f = v + len(positions), f + len(triangles)
    names = {"<f8": "double", "<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {v}"]
    header += [f"property {names[kind]} {name}" for name, kind in fields]
    header += [f"element face {f}", "property list uchar int vertex_indices", "end_header", ""]
    with open(path, "wb") as out:
        out.write("\n".join(header).encode())
        out.write(vertices.tobytes())
        out.write(faces.tobytes())


def list_levels(container):
    nodes = container.nodes
    print(f"schema {container.version[0]}.{container.version[1]}, scheme {container.scheme}, {len(nodes)} nodes, "
          f"origin {container.origin}, step {container.step}, root side 2^{container.root_bits}")
    for name, value in container.parameters.items():
        print(f"parameter {name} = {value:g}")
    print(f"{'level':>5} {'nodes':>8} {'leaves':>8} {'triangles':>12} {'vertices':>12} {'bytes':>14} {'error':>12}")
    for level in numpy.unique(nodes["level"]):
        of = nodes[nodes["level"] == level]
        leaves = (of["flags"] & IS_LEAF != 0).sum()
        print(f"{level:5d} {len(of):8d} {leaves:8d} {of['triangles'].sum(dtype='u8'):12d} "
              f"{of['vertices'].sum(dtype='u8'):12d} {of['stored_bytes'].sum():14d} {of['error'].max():12.6g}")


def list_nodes(container):
    for i, n in enumerate(container.nodes):
        print(f"{i:8d} level {n['level']:2d} centre {tuple(int(c) for c in n['center'])} triangles {n['triangles']} "
              f"vertices {n['vertices']} error {n['error']:.6g} bytes {n['stored_bytes']} at {n['offset']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("container")
    parser.add_argument("--nodes", action="store_true", help="list every node")
    parser.add_argument("--level", type=int, help="decode all nodes of this level")
    parser.add_argument("--finest", action="store_true", help="decode all leaf nodes")
    parser.add_argument("--node", type=int, action="append", default=[], help="decode this node (may be repeated)")
    parser.add_argument("-o", "--output", help="PLY file for what is decoded")
    options = parser.parse_args()
    container = Container(options.container)
    nodes = container.nodes
    chosen = list(options.node)
    if any(not 0 <= i < len(nodes) for i in chosen):
        parser.error(f"--node: expected 0 to {len(nodes) - 1}")
    if options.level is not None:
        chosen += numpy.flatnonzero(nodes["level"] == options.level).tolist()
    if options.finest:
        chosen += numpy.flatnonzero(nodes["flags"] & IS_LEAF).tolist()
    if not chosen:
        if options.level is not None or options.finest:
            parser.error("no such nodes in this container")
        (list_nodes if options.nodes else list_levels)(container)
        return 0
    meshes = [decode_node(container, i) for i in sorted(set(chosen))]
    print(f"{len(meshes)} nodes, {sum(len(m[0]) for m in meshes)} vertices, {sum(len(m[3]) for m in meshes)} triangles")
    if options.output:
        write_ply(options.output, meshes, container.attributes)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (BadContainer, zstandard.ZstdError) as error:
        print(f"read_container.py: {error}", file=sys.stderr)
        sys.exit(65)
