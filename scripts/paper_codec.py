"""Decodes the sections of a payload of codec 4 ("paper"), following schemas/container.md: slowly, to be read."""
import numpy

MAX_BITS = 33
BYTE, CHROMA = (8, 128), (9, 0)  # bits of a number, and what is added to make it unsigned
INDICES_PER_TRIANGLE = 6


class BadSection(Exception):
    pass


class RangeDecoder:
    def __init__(self, data):
        self.data, self.offset = data, 0
        self.code, self.range = 0, 0xFFFFFFFF
        for _ in range(4):
            self.code = self.code << 8 | self.next_byte()

    def next_byte(self):
        self.offset += 1
        return self.data[self.offset - 1] if self.offset <= len(self.data) else 0

    def bit(self, model):
        """A model is a list of two averages, a fast and a slow one, of 2^16 times the probability of a 0."""
        bound = (self.range >> 14) * ((model[0] + model[1]) >> 3)
        bit = self.code >= bound
        if bit:
            self.code -= bound
            self.range -= bound
            model[0] -= model[0] >> 4
            model[1] -= model[1] >> 7
        else:
            self.range = bound
            model[0] += (0xFFFF - model[0]) >> 4
            model[1] += (0xFFFF - model[1]) >> 7
        while self.range < 1 << 24:
            self.range <<= 8
            self.code = (self.code << 8 | self.next_byte()) & 0xFFFFFFFF
        return bit

    def finish(self):
        if self.offset != len(self.data):
            raise BadSection(f"a section has {len(self.data)} bytes, expected {self.offset}")


class NumberModel:
    def __init__(self):
        self.nonzero = [0x8000, 0x8000]
        self.greater = [[0x8000, 0x8000] for _ in range(MAX_BITS)]
        self.negative = [[0x8000, 0x8000] for _ in range(MAX_BITS)]
        self.mantissa = [[[0x8000, 0x8000] for _ in range(exponent)] for exponent in range(MAX_BITS)]

    def decode(self, decoder, bits):
        if not decoder.bit(self.nonzero):
            return 0
        exponent = 0
        while exponent < bits - 1 and decoder.bit(self.greater[exponent]):
            exponent += 1
        value = 1
        for i in reversed(range(exponent)):
            value = 2 * value + decoder.bit(self.mantissa[exponent][i])
        if decoder.bit(self.negative[exponent]):
            value = -value
        half = 1 << (bits - 1)
        return value if -half <= value < half else -half


def haar_inverse(low, high):
    if low < 0 and low <= high < -low:
        high = high - 1 if high > low else -low - 1
    if low >= 0 and -low <= high <= low:
        return (low, low - high) if high >= 0 else (low + high, low)
    if low < 0 and low <= high <= -low - 2:
        return (low, low - high - 1) if high < -1 else (low + high + 1, low)
    if high >= 0:
        return (low + high + 1, -high - 1) if low < -1 else (high, low - high)
    return (low + high, -high - 1) if low >= 0 else (high, low - high - 1)


def decode_stream(decoder, model, count, bits, middle):
    values = [0] * count
    if count:
        values[0] = model.decode(decoder, bits)
    step = 1 << (count - 1).bit_length() >> 1 if count > 1 else 0
    while step:
        for i in range(0, count - step, 2 * step):
            values[i], values[i + step] = haar_inverse(values[i], model.decode(decoder, bits))
        step //= 2
    return numpy.array(values, dtype=numpy.int64) + middle


def unsigned(bits):
    return bits, 1 << (bits - 1)


def decode_planes(data, ranges, counts):
    """For each part an array (count, len(ranges)): plane after plane, of each plane all parts."""
    decoder = RangeDecoder(data)
    planes = []
    for bits, middle in ranges:
        model = NumberModel()
        planes.append([decode_stream(decoder, model, n, bits, middle) for n in counts])
    decoder.finish()
    return [numpy.stack([plane[i] for plane in planes], axis=1) for i in range(len(counts))]


def decode_colors(planes):
    y, co, cg, alpha = planes.T
    t = y - (cg >> 1)
    blue = t - (co >> 1)
    return numpy.stack([blue + co, cg + t, blue, alpha], axis=1).astype("u1")


def decode_parents(data, counts):
    decoder, widths, model, parts = RangeDecoder(data), NumberModel(), NumberModel(), []
    for n in counts:
        bits = widths.decode(decoder, 7)
        if not 1 <= bits <= 32:
            raise BadSection("the width of parents is out of range")
        parts.append(decode_stream(decoder, model, n, *unsigned(bits)))
    decoder.finish()
    return parts


def triangles_of_strip(indices):
    triangles = []
    for k in range(len(indices) - 2):
        a, b, c = indices[k:k + 3]
        if len({a, b, c}) == 3:
            triangles.append((b, a, c) if k % 2 else (a, b, c))
    return triangles


def decode_triangles(data, vertex_counts, triangle_counts):
    decoder, parts = RangeDecoder(data), []
    strip_sizes, listed_counts, model = NumberModel(), NumberModel(), NumberModel()
    for n, t in zip(vertex_counts, triangle_counts):
        size = strip_sizes.decode(decoder, MAX_BITS)
        listed = listed_counts.decode(decoder, MAX_BITS)
        if not (0 <= listed <= t and 0 <= size <= INDICES_PER_TRIANGLE * t):
            raise BadSection("a strip is too long for its triangles")
        bits = max(1, (max(n, 1) - 1).bit_length())
        indices = decode_stream(decoder, model, size + 3 * listed, *unsigned(bits)).tolist()
        if any(v >= n for v in indices):
            raise BadSection("a vertex index is out of range")
        triangles = triangles_of_strip(indices[:size])
        if len(triangles) != t - listed:
            raise BadSection("a strip has not as many triangles as it should")
        triangles += [tuple(indices[i:i + 3]) for i in range(size, len(indices), 3)]
        parts.append(numpy.array(triangles, dtype=numpy.int64).reshape(-1, 3))
    decoder.finish()
    return parts


def decode_sections(sections, vertex_counts, triangle_counts, position_bits, is_cube):
    """`sections`: of connectivity, positions, normals, colours, parents, with None for what a node does not have. A
    dict of the same five, each None or a list with an array per part: triangles (t, 3), coordinates (n, 3), which are
    the first three weights of a tetrahedron, octahedral normals (n, 2), colours (n, 4), parents (n)."""
    connectivity, positions, normals, colors, parents = sections
    if not vertex_counts:
        if any(sections):
            raise BadSection("a section should be empty")
        return {"triangles": [], "positions": [], "normals": [], "colors": [], "parents": []}
    coordinate = unsigned(max(1, position_bits) if is_cube else position_bits + 1)
    result = {"normals": None, "colors": None, "parents": None}
    result["triangles"] = decode_triangles(connectivity, vertex_counts, triangle_counts)
    result["positions"] = decode_planes(positions, [coordinate] * 3, vertex_counts)
    if normals is not None:
        result["normals"] = decode_planes(normals, [BYTE] * 2, vertex_counts)
    if colors is not None:
        planes = decode_planes(colors, [BYTE, CHROMA, CHROMA, BYTE], vertex_counts)
        result["colors"] = [decode_colors(p) for p in planes]
    if parents is not None:
        result["parents"] = decode_parents(parents, vertex_counts)
    return result
