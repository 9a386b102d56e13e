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
import os
import sys

import h5py
import numpy
import zstandard

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import paper_codec  # noqa: E402
import predicted_payload  # noqa: E402

SCHEMA_MAJOR = 1
IS_LEAF = 1
HAS_NORMALS, HAS_COLORS, HAS_PARENTS, IS_CUBE = 1, 2, 4, 8


class BadContainer(Exception):
    pass


# ---------------------------------------------------------------------------------------------- file and node table

def is_container(group):
    return group.attrs.get("format") in (b"colossus", "colossus")


def find_container(path, file):
    """The root, or else the one group directly below it that is a container."""
    if is_container(file):
        return file
    links = [name for name in file if file.get(name, getlink=True, getclass=True) is h5py.HardLink]
    found = [name for name in links if isinstance(file[name], h5py.Group) and is_container(file[name])]
    if len(found) == 1:
        return file[found[0]]
    if found:
        raise BadContainer(f"{path}: expected one container, found the groups {', '.join(found)}")
    if "nodes" in links and "chunks" in links:
        raise BadContainer(f"{path}: has the objects of a Colossus container, but not the attributes of its root "
                           "group; copy the whole of it, with h5copy -s / -d /statue")
    raise BadContainer(f"{path}: is an HDF5 file, but no Colossus container")


class Container:
    def __init__(self, path):
        try:
            self.file = h5py.File(path, "r")
        except OSError as error:
            raise BadContainer(f"{path}: cannot open as an HDF5 file: {error}")
        self.group = find_container(path, self.file)
        root = self.group.attrs
        self.version = tuple(int(v) for v in root["schema_version"])
        if self.version[0] != SCHEMA_MAJOR:
            raise BadContainer(f"{path}: schema version {self.version}: this program reads {SCHEMA_MAJOR}.x")
        self.scheme = text(root["scheme"])
        if self.scheme not in DECODERS:
            raise BadContainer(f"{path}: scheme {self.scheme}: this program reads {' and '.join(DECODERS)}")
        self.producer = " ".join(text(root[name]) for name in ("producer", "producer_version") if name in root)
        self.attributes = int(root["attributes"])
        lattice = self.group["lattice"].attrs
        self.origin = numpy.array(lattice["origin"], dtype="<f8")
        self.step = float(lattice["step"])
        self.root_bits = int(lattice["root_bits"])
        self.parameters, self.measures = self.reals("parameters"), self.reals("measures")
        self.nodes = self.group["nodes"][:]
        self.raw = open(path, "rb")

    def reals(self, table):
        if table not in self.group:
            return {}
        return {row["name"].decode(): float(row["value"]) for row in self.group[table][:]}

    def payload(self, index):
        """The decoded chunk of a node: a plain byte range of the file, one zstd frame, cut to the payload's size.
        Where another program has copied the file, the chunk number chunk_index of the dataset of the node's class."""
        node = self.nodes[index]
        self.raw.seek(int(node["offset"]))
        frame = self.raw.read(int(node["stored_bytes"]))
        name, size = f"chunks/class_{node['chunk_class']}", int(node["payload_bytes"])
        if name not in self.group:
            raise BadContainer(f"node {index}: expected a dataset {name}, found none")
        dataset = self.group[name]
        capacity = dataset.chunks[0]
        start = int(node["chunk_index"]) * capacity
        mask, chunk = dataset.id.read_direct_chunk((start,))
        if chunk != frame:  # the offset does not hold
            frame = chunk
        if mask != 0:
            raise BadContainer(f"node {index}: expected filter mask 0, found {mask}")
        if len(frame) != node["stored_bytes"]:  # encoded anew: HDF5 decodes it, if it has the filter
            return dataset[start:start + size].tobytes()
        content = zstandard.ZstdDecompressor().decompress(frame)
        if len(content) != capacity or any(content[size:]):
            raise BadContainer(f"node {index}: expected {capacity} bytes, zeros behind {size}; found {len(content)}")
        return content[:size]


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


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


def narrowest(largest):
    return "<u1" if largest < 2**8 else "<u2" if largest < 2**16 else "<u4"


def decode_payload(data):
    """A dict: bits, is_cube, offset, and parts, a list of dicts: place, positions (n, 3), which are the first three
    weights of a tetrahedron, normals (n, 2), octahedral, colors (n, 4), parents (n), triangles (t, 3). None for what
    the node does not have."""
    # The last eight bytes are an XXH3-64, for which Debian's Python has no module.
    if len(data) < 8:
        raise BadContainer("payload: cut short")
    reader = Reader(data[:-8])
    codec, version, bits, flags, count = (int(v) for v in reader.take("<u1", 5))
    if (codec, version) not in CODECS:
        raise BadContainer(f"payload: codec {codec} version {version} is unknown; this program reads {list(CODECS)}")
    heads = reader.take("<u4", 3 * count).reshape(-1, 3).astype(numpy.int64)
    is_cube = flags & IS_CUBE != 0
    offset = reader.take("<i4", 3).astype(numpy.int64) if is_cube else None
    sizes = [int(size) for size in reader.take("<u4", len(SECTIONS))]
    sections = [reader.take("<u1", size).tobytes() for size in sizes]
    if reader.offset != len(data) - 8:
        raise BadContainer(f"payload: {len(data) - 8 - reader.offset} bytes left over")
    present = (True, True, flags & HAS_NORMALS, flags & HAS_COLORS, flags & HAS_PARENTS)
    if any(size and not has for size, has in zip(sizes, present)):
        raise BadContainer("payload: a section for what the node does not have")
    sections = [section if has else None for section, has in zip(sections, present)]
    arrays = CODECS[codec, version](sections, heads, bits, is_cube)
    parts = [{"place": int(heads[i, 0]) >> 24, **{k: None if v is None else v[i] for k, v in arrays.items()}}
             for i in range(count)]
    return {"bits": bits, "is_cube": is_cube, "offset": offset, "parts": parts}


def decode_packed(sections, heads, bits, is_cube):
    """Codec 3, "zstd": arrays as they are."""
    vertex_counts, triangle_counts = heads[:, 1].tolist(), heads[:, 2].tolist()
    readers = [None if section is None else Reader(section) for section in sections]
    connectivity, positions, normals, colors, parents = readers
    coordinate = narrowest(2**bits - is_cube)

    def planes(reader, dtype, width):
        if reader is None:
            return None
        return [numpy.stack([reader.take(dtype, n) for _ in range(width)], axis=1) for n in vertex_counts]

    def decode_parents(n):
        size = int(parents.take("<u1")[0])
        if size not in (1, 2, 4):
            raise BadContainer(f"payload: {size} bytes per parent")
        return parents.take(f"<u{size}", n).astype(numpy.int64)

    arrays = {"positions": [p.astype(numpy.int64) for p in planes(positions, coordinate, 3)],
              "normals": planes(normals, "<u1", 2), "colors": planes(colors, "<u1", 4),
              "parents": None if parents is None else [decode_parents(n) for n in vertex_counts],
              "triangles": [decode_corners(connectivity.take(narrowest(n), 3 * t), n).reshape(-1, 3)
                            for n, t in zip(vertex_counts, triangle_counts)]}
    for reader in readers:
        if reader is not None and reader.offset != len(reader.data):
            raise BadContainer(f"payload: {len(reader.data) - reader.offset} bytes left over in a section")
    return arrays


def decode_paper(sections, heads, bits, is_cube):
    """Codec 4, "paper"."""
    try:
        return paper_codec.decode_sections(sections, heads[:, 1].tolist(), heads[:, 2].tolist(), bits, is_cube)
    except paper_codec.BadSection as error:
        raise BadContainer(f"payload: {error}")


def decode_predicted(sections, heads, bits, is_cube, version=2):
    """Codec 5, "predict", which looks at the parts' frames, too."""
    parts = []
    for word, n, t in heads.tolist():
        digits = [(word & 0xffffff) // 5**(8 - i) % 5 - 2 for i in range(9)]
        parts.append({"vertices": n, "triangle_count": t, "frame": [digits[0:3], digits[3:6], digits[6:9]]})
    names = dict(zip(("normals", "colors", "parents"), sections[2:]))
    head = {"bits": bits, "is_cube": is_cube, "parts": parts,
            **{f"has_{name}": section is not None for name, section in names.items()}}
    try:
        predicted_payload.decode_sections(head, [section or b"" for section in sections], version)
    except predicted_payload.BadSections as error:
        raise BadContainer(f"payload: {error}") from error

    def arrays(name, width, dtype):
        return [numpy.array(part[name], dtype=dtype).reshape(-1, width) for part in parts]

    result = {"positions": [p[:, :3] for p in arrays("positions", 4, numpy.int64)],
              "triangles": arrays("triangles", 3, numpy.int64), "normals": None, "colors": None, "parents": None}
    for name, width, dtype in (("normals", 2, numpy.uint8), ("colors", 4, numpy.uint8)):
        if names[name] is not None:
            result[name] = arrays(name, width, dtype)
    if names["parents"] is not None:
        result["parents"] = [numpy.array(part["parents"], dtype=numpy.int64) for part in parts]
    return result


CODECS = {(3, 1): decode_packed, (4, 1): decode_paper, (5, 2): decode_predicted,
          (5, 1): lambda *node: decode_predicted(*node, version=1)}
SECTIONS = ("connectivity", "positions", "normals", "colors", "parents")


def decode_corners(codes, vertex_count):
    """A code is high water minus index; each 0 names the next new vertex and lifts the high water by one."""
    codes = codes.astype(numpy.int64)
    is_new = (codes == 0).astype(numpy.int64)
    indices = numpy.cumsum(is_new) - is_new - codes
    if is_new.sum() > vertex_count or (indices < 0).any():
        raise BadContainer(f"payload: triangles use {is_new.sum()} of {vertex_count} vertices, or a wrong one")
    return indices


def used_vertices(triangles):
    """How many vertices the triangles use; these must come first."""
    return int(triangles.max()) + 1 if triangles.size else 0


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
    node, payload = container.nodes[index], decode_payload(container.payload(index))
    if not payload["is_cube"] or len(payload["parts"]) != 1:
        raise BadContainer(f"node {index}: expected a cube")
    part = payload["parts"][0]
    if (len(part["positions"]), len(part["triangles"])) != (node["vertices"], node["triangles"]):
        raise BadContainer(f"node {index}: expected {node['vertices']} vertices, {node['triangles']} triangles")
    if (part["parents"] is not None) != (node["level"] > 0):
        raise BadContainer(f"node {index}: expected parents at all levels but 0")
    positions = payload["offset"] + part["positions"]
    if len(positions) and positions.max() >= 2**31:
        raise BadContainer(f"node {index}: a coordinate is out of range")
    used = used_vertices(part["triangles"])
    world = container.origin + container.step * positions[:used]
    normals = None if part["normals"] is None else decode_normals(*part["normals"][:used].T)
    return world, normals, None if part["colors"] is None else part["colors"][:used], part["triangles"]


def decode_diamond(container, index):
    """Its tetrahedra one after the other."""
    node, payload = container.nodes[index], decode_payload(container.payload(index))
    bits, parts = payload["bits"], payload["parts"]
    if payload["is_cube"]:
        raise BadContainer(f"node {index}: expected tetrahedra, found a cube")
    corners = diamond(int(node["level"]), node["center"], container.root_bits)
    positions, triangles, start = [], [], 0
    for part in parts:
        last = 2**bits - part["positions"].sum(axis=1, keepdims=True)
        if (last < 0).any():
            raise BadContainer(f"node {index}: weights at place {part['place']} sum to more than 2^{bits}")
        if used_vertices(part["triangles"]) != len(last):
            raise BadContainer(f"node {index}: a vertex at place {part['place']} is used by no triangle")
        # Exact: 64-bit integers, lattice position times 2^bits.
        scaled = numpy.hstack([part["positions"], last]) @ corners[part["place"]]
        positions.append(container.origin + (container.step / 2**bits) * scaled)
        triangles.append(part["triangles"] + start)
        start += len(scaled)
    join = numpy.concatenate
    if sum(1 << part["place"] for part in parts) != node["tetra_mask"]:
        raise BadContainer(f"node {index}: expected tetrahedra {node['tetra_mask']:#x}")
    if start != node["vertices"] or sum(map(len, triangles)) != node["triangles"]:
        raise BadContainer(f"node {index}: expected {node['vertices']} vertices, {node['triangles']} triangles")
    has_normals = parts and parts[0]["normals"] is not None
    has_colors = parts and parts[0]["colors"] is not None
    return (join(positions) if parts else numpy.zeros((0, 3)),
            join([decode_normals(*p["normals"].T) for p in parts]) if has_normals else None,
            join([p["colors"] for p in parts]) if has_colors else None,
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
    if container.producer:
        print(f"made by {container.producer}")
    for name, value in container.parameters.items():
        print(f"parameter {name} = {value:g}")
    for name, value in container.measures.items():
        print(f"measure {name} = {value:g}")
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
