"""Decodes the sections of codec 5, predict, in both its versions, as schemas/container.md describes them. Slow and
plain: some thousand vertices a second."""

MASK32 = 2**32 - 1
TOKENS, SLOT_BITS, LANES = 128, 10, 4
NEW, RIGHT, LEFT, BORDER, LAST, KNOWN = range(6)
OPEN, AT_BORDER, DONE = range(3)


class BadSections(Exception):
    pass


# ------------------------------------------------------------------------------------------------- adaptive binary

class Bit:
    """Adaptive probability of a zero, in units of 2^-16."""

    def __init__(self):
        self.zero, self.count = 2**15, 0

    def update(self, bit):
        rate = 2**16 // (self.count + 2)
        self.zero += -(self.zero * rate >> 16) if bit else (2**16 - self.zero) * rate >> 16
        self.count = min(self.count + 1, 47)


class BitDecoder:
    def __init__(self, data):
        self.data, self.offset = data, 4
        self.range, self.code = MASK32, int.from_bytes((data[:4] + bytes(4))[:4], "big")

    def normalize(self):
        while self.range < 2**24:
            byte = self.data[self.offset] if self.offset < len(self.data) else 0
            self.offset += 1
            self.range, self.code = self.range << 8, (self.code << 8 | byte) & MASK32

    def get(self, model):
        bound = (self.range >> 16) * model.zero
        bit = self.code >= bound
        if bit:
            self.code, self.range = self.code - bound, self.range - bound
        else:
            self.range = bound
        model.update(bit)
        self.normalize()
        return bit

    def get_bits(self, count):
        value = 0
        for _ in range(count):
            self.range >>= 1
            bit = self.code >= self.range
            self.code -= self.range if bit else 0
            value = value << 1 | bit
            self.normalize()
        return value

    def get_tree(self, models, bits):
        at = 1
        for _ in range(bits):
            at = at << 1 | self.get(models[at])
        return at - 2**bits


def tree(bits):
    return [Bit() for _ in range(2**bits)]


# ---------------------------------------------------------------------------------------------------------- values

def to_signed(value):
    return -(value + 1 >> 1) if value & 1 else value >> 1


def wrap32(value):
    return (value + 2**31 & MASK32) - 2**31


def wrap8(value):
    return (value + 128 & 255) - 128


def weights_to_frequencies(weights):
    total, slots = sum(weights), 2**SLOT_BITS
    if total == 0:
        return weights
    frequencies = [max(1, w * slots // total) if w else 0 for w in weights]
    left = slots - sum(frequencies)
    while left:
        most = frequencies.index(max(frequencies))
        change = left if left > 0 else max(left, -(frequencies[most] // 2))
        frequencies[most] += change
        left -= change
    return frequencies


def get_size(data, offset):
    """A size of seven bits a byte, and where it ends."""
    size = shift = 0
    while True:
        if offset >= len(data) or shift > 28:
            raise BadSections("a size is cut short")
        size |= (data[offset] & 127) << shift
        shift, offset = shift + 7, offset + 1
        if data[offset - 1] < 128:
            return size, offset


def get_number(tables, widths):
    width = tables.get_tree(widths, 4)
    return width if width < 2 else 1 << (width - 1) | tables.get_bits(width - 1)


def read_runs(tables, contexts):
    """Which table each context has, and how many tables there are."""
    widths = tree(4)
    count = get_number(tables, widths)
    starts = [0]
    for _ in range(1, count):
        starts.append(starts[-1] + get_number(tables, widths))
    if count > 128 or starts[-1] >= contexts or len(set(starts)) < len(starts):
        raise BadSections("contexts have no tables of such runs")
    return [sum(context >= start for start in starts) - 1 for context in range(contexts)], count


class Values:
    """Interleaved rANS with a table for each run of contexts; in version 1 for each context."""

    def __init__(self, data, contexts, version):
        self.slots, self.table_of, self.words, self.raw, self.states = [], [0] * contexts, b"", 0, [2**16] * LANES
        self.word = 0
        if not data:
            return
        table_bytes, offset = get_size(data, 0)
        word_count, offset = get_size(data, offset)
        end = offset + table_bytes + 4 * LANES + 2 * word_count
        if end > len(data):
            raise BadSections("the values are cut short")
        tables = BitDecoder(data[offset:offset + table_bytes])
        offset += table_bytes
        self.states = [int.from_bytes(data[offset + 4 * i:offset + 4 * i + 4], "little") for i in range(LANES)]
        self.words = data[offset + 4 * LANES:end]
        self.raw = int.from_bytes(data[end:], "little")
        self.table_of, count = (list(range(contexts)), contexts) if version == 1 else read_runs(tables, contexts)
        ends, lengths = tree(8), [tree(4) for _ in range(16)]
        for _ in range(count):
            weights, before = [], 0
            for _ in range(min(tables.get_tree(ends, 8), TOKENS)):
                before = tables.get_tree(lengths[before], 4)
                shown = min(max(before - 1, 0), 2)
                weights.append((1 << shown | tables.get_bits(shown)) << (before - 1 - shown) if before else 0)
            slots, start = [], 0
            for token, frequency in enumerate(weights_to_frequencies(weights)):
                slots += [(token, frequency, start)] * frequency
                start += frequency
            self.slots.append(slots)

    def batch(self, contexts):
        """One value for each context; contexts may be a generator that looks at earlier batches."""
        return self.batch_of_tables(self.table_of[context] for context in contexts)

    def batch_of_tables(self, tables):
        tokens = []
        for i, table in enumerate(tables):
            state, slots = self.states[i % LANES], self.slots[table] if table < len(self.slots) else []
            if not slots:
                raise BadSections("a context has no values")
            slot = state & 2**SLOT_BITS - 1
            token, frequency, start = slots[slot]
            state = frequency * (state >> SLOT_BITS) + slot - start
            if state < 2**16:
                if self.word + 2 > len(self.words):
                    raise BadSections("the words are cut short")
                state = state << 16 | int.from_bytes(self.words[self.word:self.word + 2], "little")
                self.word += 2
            self.states[i % LANES] = state
            tokens.append(token)
        for i, token in enumerate(tokens):
            if token >= 16:
                bits = 2 + (token - 16) // 4
                tokens[i] = ((4 + token % 4) << bits) + (self.raw & 2**bits - 1)
                self.raw >>= bits
        return tokens

    def check_end(self):
        if self.word != len(self.words) or self.raw or any(state != 2**16 for state in self.states):
            raise BadSections("values are left over")


def class_of(value, *bounds):
    return sum(value >= bound for bound in bounds)


# ---------------------------------------------------------------------------------------------------- connectivity

class Gate:
    def __init__(self, number, start, opposite):
        self.start, self.opposite, self.state = start, opposite, OPEN
        self.next = self.before = number


class Vertex:
    def __init__(self):
        self.relations, self.neighbors, self.is_border, self.valence, self.gate = [], [], False, 0, None

    def four_neighbors(self):
        n = self.neighbors
        return {1: n * 4, 2: n * 2, 3: n + n[1:2], 4: n}[len(n)]

    def three_relations(self):
        r = self.relations
        return r + [r[-1]] * (3 - len(r))


class Symbols:
    """Those of each table in a sequence of its own."""

    def __init__(self, data):
        size, offset = get_size(data, 0)
        values = Values(data[offset:offset + size], 5 << 9, 2)
        offset += size
        counts = []
        for _ in values.slots:
            count, offset = get_size(data, offset)
            counts.append(count)
        self.table_of, self.seeds, self.bits = values.table_of, tree(2), BitDecoder(data[offset:])
        self.sequences = [iter(values.batch_of_tables([i] * count)) for i, count in enumerate(counts)]
        values.check_end()

    def symbol(self, can_left, can_right, can_last, valence_a, valence_b, latest):
        sides = can_left + 2 * can_right + can_last
        context = sides << 9 | (valence_b & 15) << 5 | latest << 3 | valence_a & 7
        symbol = next(self.sequences[self.table_of[context]], None) if self.sequences else None
        if symbol is None or symbol > KNOWN:
            raise BadSections("a symbol that is none")
        return symbol

    def check_end(self):
        if any(next(sequence, None) is not None for sequence in self.sequences):
            raise BadSections("symbols are left over")


class AdaptiveSymbols:
    """Of version 1: bits of one stream."""

    def __init__(self, data):
        self.bits, self.seeds, self.last, self.models = BitDecoder(data), tree(2), Bit(), {}

    def symbol(self, can_left, can_right, can_last, valence_a, valence_b, latest):
        get = self.bits.get
        if can_last and get(self.last):
            return LAST
        context = min(valence_b, 9), min(valence_a, 6), latest, can_left, can_right
        is_new, is_right, is_left, is_border = self.models.setdefault(context, tree(2))
        if not get(is_new):
            return NEW
        if can_right and not get(is_right):
            return RIGHT
        if can_left and not get(is_left):
            return LEFT
        return KNOWN if get(is_border) else BORDER

    def check_end(self):
        pass


class Traversal:
    def __init__(self, source, vertex_count, triangle_count):
        self.source, self.bits = source, source.bits
        self.vertices = [Vertex() for _ in range(vertex_count)]
        self.triangles, self.gates, self.known, self.latest = [], [], 0, NEW
        served = 0
        while len(self.triangles) < triangle_count:
            if served == len(self.gates):
                self.seed()
            else:
                if self.gates[served].state == OPEN:
                    self.serve(served)
                served += 1
        for number in range(served, len(self.gates)):
            if self.gates[number].state == OPEN:
                self.mark_border(number)

    def open(self, start, opposite):
        self.gates.append(Gate(len(self.gates), start, opposite))
        self.vertices[start].gate = len(self.gates) - 1
        return len(self.gates) - 1

    def link(self, before, after):
        self.gates[before].next, self.gates[after].before = after, before

    def emit(self, *corners):
        self.triangles.append(corners)
        for v in corners:
            self.vertices[v].valence += 1

    def connect(self, v, w):
        high = self.vertices[max(v, w)]
        if v != w and len(high.neighbors) < 4:
            high.neighbors.append(min(v, w))

    def relate(self, p, q, r, s):
        end, tip = max(p, q), max(r, s)
        if tip > end and r != s:
            high, relation = tip, (p, q, min(r, s))
        elif end > tip and p != q:
            high, relation = end, (r, s, min(p, q))
        else:
            return
        if len(self.vertices[high].relations) < 3:
            self.vertices[high].relations.append(relation)

    def mark_border(self, number):
        gate = self.gates[number]
        gate.state = AT_BORDER
        for v in (gate.start, self.gates[gate.next].start):
            self.vertices[v].is_border = True

    def new_vertex(self):
        if self.known >= len(self.vertices):
            raise BadSections("too many vertices")
        self.known += 1
        return self.known - 1

    def old_vertex(self):
        v = self.bits.get_bits(self.known.bit_length())
        if v >= self.known:
            raise BadSections("a vertex that is not known yet")
        return v

    def seed(self):
        p, q, r = (self.old_vertex() if self.bits.get(self.source.seeds[k]) else self.new_vertex() for k in range(3))
        self.emit(p, q, r)
        self.connect(p, q)
        self.connect(q, r)
        self.connect(r, p)
        g = [self.open(q, r), self.open(r, p), self.open(p, q)]
        self.link(g[0], g[2])
        self.link(g[2], g[1])
        self.link(g[1], g[0])

    def symbol(self, number, a, b):
        gates = self.gates
        gate = gates[number]
        can_right = gates[gate.next].state == OPEN and gate.next != number
        can_left = gates[gate.before].state == OPEN and gate.before != number
        can_last = can_left and can_right and gates[gate.next].next == gate.before and gate.next != gate.before
        valences = self.vertices[a].valence, self.vertices[b].valence
        symbol = self.source.symbol(can_left, can_right, can_last, *valences, min(self.latest, 2))
        if symbol == RIGHT and not can_right or symbol == LEFT and not can_left or symbol == LAST and not can_last:
            raise BadSections("a triangle where there is no room for it")
        return symbol

    def serve(self, number):
        gates = self.gates
        gate = gates[number]
        before, after = gate.before, gate.next
        a, b = gate.start, gates[after].start
        symbol = self.symbol(number, a, b)
        if symbol == BORDER:
            self.mark_border(number)
            return
        self.latest = symbol
        gate.state = DONE
        if symbol in (NEW, KNOWN):
            third = self.new_vertex() if symbol == NEW else self.old_vertex()
            other = self.vertices[third].gate
        else:
            third = gates[before].start if symbol == LEFT else gates[gates[after].next].start
        self.emit(a, b, third)
        self.relate(a, b, gate.opposite, third)
        if symbol in (RIGHT, LAST):
            self.relate(b, third, gates[after].opposite, a)
            gates[after].state = DONE
        if symbol in (LEFT, LAST):
            ends = (a, third) if symbol == LEFT else (third, a)
            self.relate(*ends, gates[before].opposite, b)
            gates[before].state = DONE
        if symbol == RIGHT:
            self.connect(a, third)
            far = gates[after].next
            left = self.open(a, b)
            self.link(left if before == after else before, left)
            self.link(left, left if before == after else far)
        elif symbol == LEFT:
            self.connect(b, third)
            far = gates[before].before
            right = self.open(third, a)
            self.link(right if before == after else far, right)
            self.link(right, right if before == after else after)
        elif symbol in (NEW, KNOWN):
            self.connect(third, a)
            self.connect(third, b)
            is_alone = after == number
            left, right = self.open(a, b), self.open(third, a)
            self.link(right if is_alone else before, left)
            self.link(right, left if is_alone else after)
            if symbol == KNOWN and other is not None and gates[other].state != DONE:
                other_before = gates[other].before
                self.link(left, other)
                self.link(other_before, right)
            else:
                self.link(left, right)


# ------------------------------------------------------------------------------------------------------- positions

def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def rounded_quotient(numerator, denominator):
    return (2 * numerator + denominator) // (2 * denominator)


def reduced(vector, bits):
    size = 0
    for x in vector:
        size |= ~x if x < 0 else x
    excess = max(0, size.bit_length() - bits)
    return [x >> excess for x in vector]


class Basis:
    def __init__(self, frame):
        candidates = []
        for number in range(14, 27):
            factors = [number % 3 - 1, number // 3 % 3 - 1, number // 9 - 1]
            direction = [sum(factors[row] * frame[row][axis] for row in range(3)) for axis in range(3)]
            candidates.append((dot(direction, direction), factors, direction))
        candidates.sort(key=lambda c: c[0])  # stable
        first, rest = candidates[0], candidates[1:]
        is_pair = [1 in map(abs, cross(first[1], c[1])) for c in rest]  # entries are -2 to 2: then they have no divisor
        second = rest[is_pair.index(True)]
        normal = cross(first[1], second[1])
        later = rest[is_pair.index(True) + 1:]
        third = [c for c in later + candidates if abs(dot(normal, c[1])) == 1][0]
        factors, directions = [[c[k] for c in (first, second, third)] for k in (1, 2)]
        sign = dot(normal, factors[2])
        self.to_weights = [[factors[j][i] for j in range(3)] for i in range(3)]
        self.from_weights = [[sign * x for x in cross(factors[(i + 1) % 3], factors[(i + 2) % 3])] for i in range(3)]
        products = [[dot(p, q) for q in directions] for p in directions]
        self.metric = [cross(products[(i + 1) % 3], products[(i + 2) % 3]) for i in range(3)]


class Positions:
    def __init__(self, part, vertices, bits, is_cube):
        self.basis, self.vertices, self.is_cube = Basis(part["frame"]), vertices, is_cube
        self.one, self.shift, self.points = 2**bits, max(0, bits - 18), []

    def weights_of(self, point):
        weights = [dot(row, point) for row in self.basis.to_weights]
        return [w & MASK32 for w in weights + [0 if self.is_cube else self.one - sum(weights)]]

    def predict(self, v):
        """The point, and the normal of the plane."""
        points, relations = self.points, self.vertices[v].relations
        if not relations:
            return points[v - 1] if v else [0, 0, 0], [0, 0, 0]
        ends = [[points[p][i] + points[q][i] - points[r][i] for i in range(3)]
                for p, q, r in self.vertices[v].three_relations()]
        point = [wrap32(2 * ends[0][i] + ends[1][i] + ends[2][i] + 2) >> 2 for i in range(3)]
        p, q, r = (points[k] for k in relations[0])
        normal = cross(*[[wrap32(x - y) >> self.shift for x, y in zip(to, p)] for to in (q, r)])
        return point, reduced(normal, 28)

    @staticmethod
    def steepest(normal):
        sizes = [abs(x) for x in normal]
        return sizes.index(max(sizes))

    def inside(self, v, first, second, last):
        point, normal = self.predict(v)
        m = self.steepest(normal)
        i, j = (m + 1) % 3, (m + 2) % 3
        height = 0
        if normal[m]:
            rise = normal[i] * first + normal[j] * second
            height = rounded_quotient(rise if normal[m] < 0 else -rise, abs(normal[m]))
        result = list(point)
        for axis, miss in ((i, first), (j, second), (m, last + height)):
            result[axis] = wrap32(result[axis] + miss)
        self.points.append(result)
        return self.weights_of(result)

    def on_face(self, v, face, first, second):
        point, normal = self.predict(v)
        normal, to, back = reduced(normal, 10), self.basis.to_weights, self.basis.from_weights
        gradient = to[face] if face < 3 else [-sum(row[i] for row in to) for i in range(3)]
        face_way, plane_way = ([dot(row, g) for row in self.basis.metric] for g in (gradient, normal))
        a, b, c = dot(gradient, face_way), dot(gradient, plane_way), dot(normal, plane_way)
        area, distance = a * c - b * b, wrap32(self.weights_of(point)[face])
        if area > 0:
            ways = [(y * b - x * c) * distance >> 2 for x, y in zip(face_way, plane_way)]
            point = [wrap32(x + rounded_quotient(way, (area >> 2) + 1)) for x, way in zip(point, ways)]
        start, free = self.weights_of(point), [i for i in range(4) if i != face]
        slopes = [sum(normal[i] * back[i][j] for i in range(3)) for j in range(3)] + [0]
        line = [slopes[free[(k + 1) % 3]] - slopes[free[(k + 2) % 3]] for k in range(3)]
        m = self.steepest(line)
        n = (m + 1) % 3
        if line[m]:
            second += rounded_quotient((-line[n] if line[m] < 0 else line[n]) * first, abs(line[m]))
        weights = [0] * 4
        weights[free[m]] = start[free[m]] + first & MASK32
        weights[free[n]] = start[free[n]] + second & MASK32
        weights[free[3 - m - n]] = self.one - weights[free[m]] - weights[free[n]] & MASK32
        self.points.append([wrap32(dot(row, weights[:3])) for row in back])
        return weights


def magnitude(value):
    return value + 1 >> 1


def decode_positions(bits, faces, values, part, vertices, position_bits, is_cube):
    face_of, marks = [], []
    for vertex in vertices:
        face, around = 4, 0
        if vertex.is_border and not is_cube:
            for n in vertex.neighbors:
                around |= marks[n]
            face = min(bits.get_tree(faces[around], 3), 4)
        face_of.append(face)
        marks.append(0 if face == 4 else 1 << face)
    inner = [len(v.relations) for v, face in zip(vertices, face_of) if face == 4]
    outer = [min(len(v.relations), 1) for v, face in zip(vertices, face_of) if face < 4]
    along = values.batch([c for c in inner for _ in range(2)])
    across = values.batch([4 + class_of(max(magnitude(along[2 * i]), magnitude(along[2 * i + 1])), 4, 12, 40)
                           for i in range(len(inner))])
    face_along = values.batch([8 + c for c in outer])
    face_across = values.batch([10 + class_of(magnitude(value), 4, 24) for value in face_along])
    inner_values = zip(along[0::2], along[1::2], across)
    face_values = zip(face_along, face_across)
    positions = Positions(part, vertices, position_bits, is_cube)
    result = []
    for v, face in enumerate(face_of):
        if face == 4:
            result.append(positions.inside(v, *map(to_signed, next(inner_values))))
        else:
            result.append(positions.on_face(v, face, *map(to_signed, next(face_values))))
    return result


# ------------------------------------------------------------------------------------- normals, colours and parents

def quotient_to_zero(numerator, denominator):
    return numerator // denominator if numerator >= 0 else -(-numerator // denominator)


def project(normal):
    """Cell, signs, and whether the square is folded over."""
    if not any(normal):
        return [128, 128], [1, 1], False
    normal = reduced(normal, 14)
    total = sum(map(abs, normal))
    scale = (255 << 23) // total
    fixed = [(x + total) * scale + 2**23 for x in normal[:2]]
    return [f >> 24 for f in fixed], [-1 if f & 2**24 - 1 < 2**23 else 1 for f in fixed], normal[2] < 0


def fold(cell):
    x, y = (2 * c - 255 for c in cell)
    return [((256 - abs(y)) * (-1 if x < 0 else 1) + 255) >> 1, ((256 - abs(x)) * (-1 if y < 0 else 1) + 255) >> 1]


def decode_normals(values, mode, part, vertices, position_bits):
    borders = [v.is_border for v in vertices]
    first = values.batch([int(b) for b in borders])
    second = values.batch([2 + 6 * b + class_of(u, 1, 3, 7, 15, 31) for b, u in zip(borders, first)])
    shift = max(0, position_bits - 16)
    points = [[dot([w[row] >> shift for row in range(3)], [part["frame"][row][axis] for row in range(3)])
               for axis in range(3)] for w in part["positions"]]
    sums = [[0, 0, 0] for _ in points]
    for t in part["triangles"]:
        p, q, r = (points[v] for v in t)
        n = cross([x - y for x, y in zip(q, p)], [x - y for x, y in zip(r, p)])
        for v in t:
            sums[v] = [x + y for x, y in zip(sums[v], n)]
    if mode >= 2:
        own, sums = sums, [[(8 if mode == 2 else 3) * x for x in n] for n in sums]
        for t in part["triangles"]:
            for v in t:
                sums[v] = [s + sum(own[w][i] for w in t) - own[v][i] for i, s in enumerate(sums[v])]
    normals, misses = [], []
    for v, vertex in enumerate(vertices):
        cell, signs, is_folded = project(sums[v])
        expected = [0, 0]
        if mode > 0 and vertex.neighbors:
            expected = [quotient_to_zero(sum(misses[n][k] for n in vertex.four_neighbors()), 8) for k in range(2)]
        left = [wrap8(to_signed(r[v])) for r in (first, second)]
        misses.append([wrap8(signs[k] * left[k] + expected[k]) for k in range(2)])
        cell = [cell[k] + misses[v][k] & 255 for k in range(2)]
        normals.append(fold(cell) if is_folded else cell)
    return normals


def decode_colors(values, vertices, version):
    lumas = values.batch([int(len(v.neighbors) > 2) for v in vertices])
    oranges = values.batch([2 + class_of(luma, 6, 18) for luma in lumas])
    greens = values.batch([5 + class_of(luma, 6, 18) for luma in lumas])
    opacities = values.batch([8] * len(vertices))
    colors = []
    for v, vertex in enumerate(vertices):
        if vertex.neighbors:
            mean = [(sum(colors[n][c] for n in vertex.four_neighbors()) + 2) >> 2 for c in range(4)]
        else:
            mean = colors[v - 1] if v else [0, 0, 0, 0 if version == 1 else 255]
        luma, orange, green, opacity = (to_signed(x[v]) for x in (lumas, oranges, greens, opacities))
        middle = luma - (green >> 1)
        blue = middle - (orange >> 1)
        miss = [blue + orange, middle + green, blue, opacity]
        colors.append([x + y & 255 for x, y in zip(mean, miss)])
    return colors


def decode_parents(values, vertices):
    choices = values.batch([int(len(v.neighbors) > 2) for v in vertices])
    others = iter(values.batch([2] * sum(c >= len(v.neighbors) for c, v in zip(choices, vertices))))
    parents = []
    for v, (choice, vertex) in enumerate(zip(choices, vertices)):
        n = vertex.neighbors
        if choice < len(n):
            parents.append(parents[n[choice]])
        else:
            base = parents[n[0]] if n else parents[v - 1] if v else 0
            parents.append(base + to_signed(next(others)) & MASK32)
    return parents


def decode_sections(head, sections, version):
    """Fills positions, normals, colors, parents and triangles of the head's parts, as lists."""
    symbols = (AdaptiveSymbols if version == 1 else Symbols)(sections[0])
    faces = [tree(3) for _ in range(16)]
    positions = Values(sections[1], 13, version)
    if head["has_normals"] and (not sections[2] or sections[2][-1] > 3):
        raise BadSections("the normals' mode is unknown")
    mode = sections[2][-1] if head["has_normals"] else 0
    normals, colors, parents = (Values(data, contexts, version) for data, contexts in (
        (sections[2][:-1], 14), (sections[3], 9), (sections[4], 3)))
    for part in head["parts"]:
        traversal = Traversal(symbols, part["vertices"], part["triangle_count"])
        vertices, part["triangles"] = traversal.vertices, traversal.triangles
        part["positions"] = decode_positions(symbols.bits, faces, positions, part, vertices, head["bits"],
                                             head["is_cube"])
        if head["has_normals"]:
            part["normals"] = decode_normals(normals, mode, part, vertices, head["bits"])
        if head["has_colors"]:
            part["colors"] = decode_colors(colors, vertices, version)
        if head["has_parents"]:
            part["parents"] = decode_parents(parents, vertices)
    for values in (symbols, positions, normals, colors, parents):
        values.check_end()
