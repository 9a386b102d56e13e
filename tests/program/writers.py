"""Writers of PLY, OBJ, OFF and STL that say which bytes they write; what is odd about a file is an argument. All return bytes."""
import struct

import numpy as np

TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
         "double": "f8"}
RGB = ("red", "green", "blue")


def word(value):
    if isinstance(value, str):
        return value
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(int(value))


def columns(names, kind, values):
    """Columns of a PLY element: (name, type, values)."""
    return [(name, kind, list(values[:, k]) if isinstance(values, np.ndarray) else [row[k] for row in values])
            for k, name in enumerate(names)]


def ply(mesh, text=False, vertex=(), face=(), faces=None, position="double", count="uchar", index="int", order="<",
        header=(),
        vertex_tail="", face_tail="", tail=b"", rows_behind=b""):
    """`vertex`, `face`: further columns, of words too if `text`. `header`: lines behind the format. The tails are put behind
    each row of a text; `rows_behind` are bytes of elements that `header` names."""
    lists = np.asarray(mesh.triangles).tolist() if faces is None else faces
    vertex = columns("xyz", position, mesh.points) + list(vertex)
    kind = "ascii" if text else "binary_little_endian" if order == "<" else "binary_big_endian"
    lines = ["ply", f"format {kind} 1.0", *header, f"element vertex {len(mesh.points)}"]
    lines += [f"property {kind} {name}" for name, kind, _ in vertex]
    lines += [f"element face {len(lists)}", f"property list {count} {index} vertex_indices"]
    lines += [f"property {kind} {name}" for name, kind, _ in face]
    head = "\n".join(lines + ["end_header"]) + "\n"
    if text:
        body = "".join(" ".join(map(word, row)) + vertex_tail + "\n" for row in zip(*(values for _, _, values in vertex)))
        cast = float if index in ("float", "double") else int
        for i, corners in enumerate(lists):
            row = [cast(x) for x in (len(corners), *corners)] + [values[i] for _, _, values in face]
            body += " ".join(map(word, row)) + face_tail + "\n"
        return (head + body).encode() + rows_behind + tail
    rows = np.zeros(len(mesh.points), [(name, order + TYPES[kind]) for name, kind, _ in vertex])
    for name, _, values in vertex:
        rows[name] = values
    body = bytearray(rows.tobytes())
    for i, corners in enumerate(lists):
        body += np.array([len(corners)], order + TYPES[count]).tobytes() + np.array(corners, order + TYPES[index]).tobytes()
        body += b"".join(np.array([values[i]], order + TYPES[kind]).tobytes() for _, kind, values in face)
    return head.encode() + bytes(body) + rows_behind + tail


def obj(mesh, faces=None, behind=lambda i: "", before="", between="", after=""):
    """`behind`: what stands behind the coordinates of vertex i."""
    lists = np.asarray(mesh.triangles).tolist() if faces is None else faces
    vertices = "".join("v " + " ".join(map(word, p)) + behind(i) + "\n" for i, p in enumerate(mesh.points))
    return (before + vertices + between + "".join("f " + " ".join(str(v + 1) for v in f) + "\n" for f in lists) + after).encode()


def off(mesh, keyword="OFF\n", faces=None, behind=lambda i: "", face_behind=lambda i: "", cast=int):
    lists = np.asarray(mesh.triangles).tolist() if faces is None else faces
    text = f"{keyword}{len(mesh.points)} {len(lists)} 0\n"
    text += "".join(" ".join(map(word, p)) + behind(i) + "\n" for i, p in enumerate(mesh.points))
    for i, corners in enumerate(lists):
        text += " ".join(word(cast(x)) for x in (len(corners), *corners)) + face_behind(i) + "\n"
    return text.encode()


def stl_text(mesh, name=" part", normal="0.6 0.0 -0.8"):
    lines = [f"solid{name}"]
    for corners in np.asarray(mesh.points)[mesh.triangles]:
        lines += [f"  facet normal {normal}", "    outer loop"]
        lines += ["      vertex " + " ".join(map(word, np.float32(p).astype(float))) for p in corners]
        lines += ["    endloop", "  endfacet"]
    return ("\n".join(lines + [f"endsolid{name}"]) + "\n").encode()


def stl_binary(mesh, header=b"", attributes=0, count=None, normal=(0, 0, 0), tail=b""):
    rows = np.zeros(len(mesh.triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["normal"], rows["corners"], rows["attribute"] = normal, mesh.points[mesh.triangles], attributes
    return header.ljust(80, b" ") + struct.pack("<I", len(rows) if count is None else count) + rows.tobytes() + tail
