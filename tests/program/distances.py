"""Distances from points to triangles and segments, brute force where few, by a grid where many. numpy alone."""
import numpy as np


def to_segments(points, a, b):
    """For each point the distance to the nearest of the segments a[i] b[i]. points x segments of memory."""
    best = np.full(len(points), np.inf)
    for start, end in zip(a, b):
        along = end - start
        length = float(along @ along)
        t = np.clip((points - start) @ along / length, 0.0, 1.0) if length > 0 else np.zeros(len(points))
        best = np.minimum(best, np.linalg.norm(points - start - t[:, None] * along, axis=1))
    return best


def to_triangle_pairs(p, a, b, c):
    """Distances of p[i] to the triangle a[i] b[i] c[i]: to the plane when the foot is inside, else to the nearest side."""
    normal = np.cross(b - a, c - a)
    squared = np.einsum("ij,ij->i", normal, normal)
    height = np.einsum("ij,ij->i", p - a, normal)
    is_inside = squared > 0
    best = np.full(len(p), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        is_inside &= np.einsum("ij,ij->i", np.cross(along, p - start), normal) >= 0
        length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        t = np.clip(np.einsum("ij,ij->i", p - start, along) / length, 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(p - start - t[:, None] * along, axis=1))
    to_plane = np.abs(height) / np.sqrt(np.maximum(squared, 1e-300))
    return np.where(is_inside, np.minimum(best, to_plane), best)


def to_mesh(points, mesh, reach):
    """For each point the distance to the mesh where that is at most `reach`; anything larger comes back as infinite.
    Triangles are entered into the cells of a grid that their boxes, grown by `reach`, meet."""
    corners = mesh.points[mesh.triangles]
    low, high = corners.min(axis=1) - reach, corners.max(axis=1) + reach
    side = max(float(np.median((high - low).max(axis=1))), 1e-300)
    origin = low.min(axis=0)
    first = np.floor((low - origin) / side).astype(np.int64)
    count = np.floor((high - origin) / side).astype(np.int64) - first + 1
    cells = count.prod(axis=1)
    triangle = np.repeat(np.arange(len(corners)), cells)
    step = np.arange(cells.sum()) - np.repeat(np.cumsum(cells) - cells, cells)
    ny, nz = count[triangle, 1], count[triangle, 2]
    cell = first[triangle] + np.stack([step // (ny * nz), step // nz % ny, step % nz], axis=1)
    where = np.floor((points - origin) / side).astype(np.int64)
    size = np.maximum(cell.max(axis=0), where.max(axis=0)) + 2
    where = np.clip(where, -1, size - 1)

    def key(c):
        return ((c[:, 0] + 1) * size[1] + c[:, 1] + 1) * size[2] + c[:, 2] + 1

    keys = key(cell)
    order = np.argsort(keys, kind="stable")
    keys, triangle = keys[order], triangle[order]
    begin, end = np.searchsorted(keys, key(where)), np.searchsorted(keys, key(where), side="right")
    best = np.full(len(points), np.inf)
    pairs = end - begin
    point = np.repeat(np.arange(len(points)), pairs)
    entry = np.arange(pairs.sum()) - np.repeat(np.cumsum(pairs) - pairs, pairs) + np.repeat(begin, pairs)
    for chunk in np.array_split(np.arange(len(point)), len(point) // 2_000_000 + 1):
        i, t = point[chunk], triangle[entry[chunk]]
        # Cells are much wider than boxes grown by a small reach: most pairs are too far apart.
        near = np.ones(len(i), bool)
        for axis in range(3):
            p = points[i, axis]
            near &= (low[t, axis] <= p) & (p <= high[t, axis])
        i, t = i[near], t[near]
        np.minimum.at(best, i, to_triangle_pairs(points[i], *(corners[t, k] for k in range(3))))
    return np.where(best <= reach, best, np.inf)
