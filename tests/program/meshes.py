"""Generated inputs, and a PLY writer. A mesh is (points, triangles), two arrays."""
import numpy as np

from check_closed import Mesh


def grid(cells, a, b, origin=(0, 0, 0)):
    """The parallelogram origin, a, b in cells x cells squares of two triangles, facing a x b."""
    u = np.linspace(0.0, 1.0, cells + 1)
    y, x = np.meshgrid(u, u, indexing="ij")
    points = np.asarray(origin, float) + x[..., None] * np.asarray(a, float) + y[..., None] * np.asarray(b, float)
    i = (np.arange(cells)[None] + (cells + 1) * np.arange(cells)[:, None]).ravel()
    return Mesh(points, np.concatenate([np.stack([i, i + 1, i + cells + 2], 1),
                                        np.stack([i, i + cells + 2, i + cells + 1], 1)]))


def join(*meshes):
    offsets = np.cumsum([0] + [len(m.points) for m in meshes])
    return Mesh(np.concatenate([m.points for m in meshes]),
                np.concatenate([m.triangles + offset for m, offset in zip(meshes, offsets)]))


def box(cells, low, high):
    """A closed axis-parallel box; its sides' common points are equal, but not yet welded."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    x, y, z = np.diag(high - low)
    return snapped(join(grid(cells, y, x, low), grid(cells, x, y, low + z), grid(cells, x, z, low),
                        grid(cells, z, x, low + y), grid(cells, z, y, low), grid(cells, y, z, low + x)))


def snapped(mesh):
    """Points that differ in their last bits only become one: multiples of 2^-30."""
    points, index = np.unique(np.round(mesh.points * 2.0**30) / 2.0**30, axis=0, return_inverse=True)
    return Mesh(points, index.reshape(-1)[mesh.triangles])


def tube(around, along, radius=1.0, inner=0.4, noise=0.0, seed=1):
    """A torus, closed; with noise along the normal."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(along) * 2 * np.pi / along, indexing="ij")
    r = inner * (1.0 + noise * np.random.default_rng(seed).standard_normal(u.shape))
    points = np.stack([(radius + r * np.cos(v)) * np.cos(u), (radius + r * np.cos(v)) * np.sin(u), r * np.sin(v)], -1)
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    at = lambda a, b: ((a % around) * along + b % along).ravel()
    return Mesh(points, np.concatenate([np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1)], 1),
                                        np.stack([at(i, j), at(i + 1, j + 1), at(i, j + 1)], 1)]))


def tetrahedra(count, size, seed=1):
    """Separate tetrahedra in the unit cube, facing outward; irregular, but none flat."""
    random = np.random.default_rng(seed)
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 2.0
    corners = random.random((count, 1, 3)) + size * (regular + 0.2 * random.random((count, 4, 3)))
    sides = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    return Mesh(corners, sides[None] + 4 * np.arange(count)[:, None, None])


def fan(count):
    """`count` triangles around one vertex: a wavy disc."""
    t = np.arange(count) * 2 * np.pi / count
    i = np.arange(count)
    return Mesh(np.concatenate([[[0, 0, 0]], np.stack([np.cos(t), np.sin(t), 0.1 * np.sin(7 * t)], 1)]),
                np.stack([0 * i, 1 + i, 1 + (i + 1) % count], 1))


def write_ply(path, mesh, position="double", order="little", text=False, faces=None):
    """`faces`: lists of corners instead of the mesh's triangles. Text is written with all digits."""
    lists = mesh.triangles if faces is None else faces
    kind = "ascii" if text else f"binary_{order}_endian"
    header = (f"ply\nformat {kind} 1.0\nelement vertex {len(mesh.points)}\n"
              + "".join(f"property {position} {axis}\n" for axis in "xyz")
              + f"element face {len(lists)}\nproperty list uchar int vertex_indices\nend_header\n")
    if text:
        body = ("".join("%.17g %.17g %.17g\n" % tuple(p) for p in mesh.points)
                + "".join(f"{len(f)} {' '.join(map(str, f))}\n" for f in lists)).encode()
    else:
        sign = "<" if order == "little" else ">"
        body = mesh.points.astype(sign + ("f8" if position == "double" else "f4")).tobytes()
        if faces is None:
            rows = np.zeros(len(lists), [("count", "u1"), ("corners", sign + "i4", 3)])
            rows["count"], rows["corners"] = 3, lists
            body += rows.tobytes()
        else:
            body += b"".join(bytes([len(f)]) + np.array(f, sign + "i4").tobytes() for f in lists)
    with open(path, "wb") as file:
        file.write(header.encode() + body)
    return path
