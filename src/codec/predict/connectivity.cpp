#include "codec/predict/connectivity.hpp"

#include <bit>

#include "codec/predict/sizes.hpp"
#include "core/error.hpp"

namespace colossus::codec::predict {
namespace {

std::uint32_t next_half(std::uint32_t half) { return half % 3 == 2 ? half - 2 : half + 1; }

// For each half-edge (three per triangle, each from its corner to the next) the one on the other side, or
// kNone where there is not exactly one, of another triangle, that runs the other way. Linear: half-edges are
// sorted by their lesser vertex, and those of one such vertex are matched through its neighbours.
std::vector<std::uint32_t> find_mates(const std::vector<mesh::Triangle>& triangles,
                                      std::size_t vertex_count) {
  struct Side {
    std::uint32_t half;
    std::uint32_t greater;
  };
  const auto half_count = static_cast<std::uint32_t>(3 * triangles.size());
  const std::uint32_t* corners = triangles.empty() ? nullptr : triangles.front().data();
  std::vector<std::uint32_t> ends(vertex_count + 1);
  for (std::uint32_t h = 0; h < half_count; ++h) ++ends[std::min(corners[h], corners[next_half(h)])];
  std::uint32_t sum = 0;
  for (auto& end : ends) {
    const std::uint32_t count = end;
    end = sum;
    sum += count;
  }
  std::vector<Side> sides(half_count);
  for (std::uint32_t h = 0; h < half_count; ++h) {
    const std::uint32_t a = corners[h];
    const std::uint32_t b = corners[next_half(h)];
    sides[ends[std::min(a, b)]++] = {h, std::max(a, b)};
  }
  struct Edge {
    std::uint32_t vertex = kNone;  // the lesser one of which this is an edge
    std::uint32_t count = 0;
    std::uint32_t first = 0;
  };
  std::vector<Edge> edges(vertex_count);
  std::vector<std::uint32_t> mates(half_count, kNone);
  std::uint32_t begin = 0;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    for (std::uint32_t i = begin; i < ends[v]; ++i) {
      const auto [half, greater] = sides[i];
      Edge& edge = edges[greater];
      if (edge.vertex != v) edge = {v, 0, half};
      ++edge.count;
      const std::uint32_t other = edge.first;
      if (edge.count == 2 && half / 3 != other / 3 && corners[half] != corners[other]) {
        mates[half] = other;
        mates[other] = half;
      } else if (edge.count == 3 && mates[other] != kNone) {
        mates[mates[other]] = kNone;
        mates[other] = kNone;
      }
    }
    begin = ends[v];
  }
  return mates;
}

// A mesh as a source of the traversal.
class MeshSource {
 public:
  MeshSource(const std::vector<mesh::Triangle>& triangles, std::size_t vertex_count)
      : triangles_(triangles),
        mates_(find_mates(triangles, vertex_count)),
        numbers_(vertex_count, kNone),
        is_done_(triangles.size()) {
    before_.reserve(vertex_count);
    halves_.reserve(2 * triangles.size());
  }

  static constexpr bool kNeedsEnds = true;

  std::array<std::uint32_t, 3> seed(std::uint32_t) {
    while (is_done_[next_seed_]) ++next_seed_;
    half_ = 3 * next_seed_;
    is_done_[next_seed_] = true;
    std::array<std::uint32_t, 3> numbers{};
    for (std::size_t k = 0; k < 3; ++k) numbers[k] = number_of(triangles_[next_seed_][k]);
    return numbers;
  }

  Symbol step(const Situation& at, std::uint32_t) {
    const std::uint32_t half = mates_[halves_[at.gate]];
    if (half == kNone || is_done_[half / 3]) return Symbol::kBorder;
    is_done_[half / 3] = true;
    half_ = half;
    const std::uint32_t third = triangles_[half / 3][(half + 2) % 3];
    const bool is_new = numbers_[third] == kNone;
    third_ = number_of(third);
    if (is_new) return Symbol::kNew;
    if (at.can_be_last() && third_ == at.right) return Symbol::kLast;
    if (at.can_be_right() && third_ == at.right) return Symbol::kRight;
    if (at.can_be_left() && third_ == at.left) return Symbol::kLeft;
    return Symbol::kKnown;
  }
  std::uint32_t known_vertex(std::uint32_t) const { return third_; }

  void opened(std::uint32_t, GateOrigin origin) {
    std::uint32_t half = half_;
    if (origin == GateOrigin::kSeed1 || origin == GateOrigin::kSecondToThird) half = next_half(half);
    if (origin == GateOrigin::kSeed2 || origin == GateOrigin::kThirdToFirst)
      half = next_half(next_half(half));
    halves_.push_back(half);
  }

  // For each number the vertex that has it.
  const std::vector<std::uint32_t>& before() const { return before_; }

 private:
  std::uint32_t number_of(std::uint32_t vertex) {
    if (numbers_[vertex] == kNone) {
      numbers_[vertex] = static_cast<std::uint32_t>(before_.size());
      before_.push_back(vertex);
    }
    return numbers_[vertex];
  }

  const std::vector<mesh::Triangle>& triangles_;
  std::vector<std::uint32_t> mates_;
  std::vector<std::uint32_t> numbers_;
  std::vector<std::uint32_t> before_;
  std::vector<std::uint8_t> is_done_;
  std::vector<std::uint32_t> halves_;  // of the gates, on the inside
  std::uint32_t next_seed_ = 0;
  std::uint32_t half_ = 0;   // of the latest triangle, on the gate that led to it
  std::uint32_t third_ = 0;  // its third vertex
};

constexpr std::size_t kContexts = 5 * 16 * 4 * 8;

// What differs most comes first: contexts that share a table are neighbours. Valences beyond the greatest
// start again, since nothing should come between a valence and its symbol that takes time.
std::uint32_t context_of(const Situation& at) {
  return static_cast<std::uint32_t>(at.sides) << 9 | (at.valence_b & 15) << 5 | at.latest << 3 |
         (at.valence_a & 7);
}

constexpr std::size_t kSymbols = 6;
// None of them.
constexpr std::uint32_t kEnd = kSymbols;

}  // namespace

// A mesh that writes down what it answers.
class EncodingSource : public MeshSource {
 public:
  EncodingSource(ConnectivityEncoder& encoder, const coded::CodedPart& part)
      : MeshSource(part.triangles, part.positions.size()), encoder_(encoder) {}
  std::array<std::uint32_t, 3> seed(std::uint32_t known) {
    const auto seed = MeshSource::seed(known);
    encoder_.seeds_.put(encoder_.bits_, seed, known);
    return seed;
  }
  Symbol step(const Situation& at, std::uint32_t known) {
    const Symbol symbol = MeshSource::step(at, known);
    encoder_.symbols_.push_back({static_cast<std::uint16_t>(context_of(at)), symbol});
    return symbol;
  }
  std::uint32_t known_vertex(std::uint32_t known) {
    const std::uint32_t vertex = MeshSource::known_vertex(known);
    encoder_.bits_.encode_bits(vertex, std::bit_width(known));
    return vertex;
  }

 private:
  ConnectivityEncoder& encoder_;
};

class DecodingSource {
 public:
  static constexpr bool kNeedsEnds = false;

  explicit DecodingSource(ConnectivityDecoder& decoder)
      : decoder_(decoder), tables_(decoder.tables_.data()), sequences_(decoder.sequences_.data()) {}
  std::array<std::uint32_t, 3> seed(std::uint32_t known) {
    return decoder_.seeds_.get(decoder_.bits_, known);
  }
  Symbol step(const Situation& at, std::uint32_t) {
    auto& sequence = sequences_[tables_[context_of(at)]];
    const std::uint32_t symbol = sequence.symbol;
    sequence.symbol = *sequence.next++;
    return static_cast<Symbol>(symbol);
  }
  std::uint32_t known_vertex(std::uint32_t known) {
    return decoder_.bits_.decode_bits(std::bit_width(known));
  }
  void opened(std::uint32_t, GateOrigin) {}

 private:
  ConnectivityDecoder& decoder_;
  const std::uint8_t* tables_;
  ConnectivityDecoder::Sequence* sequences_;
};

void SeedModel::put(entropy::RangeEncoder& encoder, const std::array<std::uint32_t, 3>& seed,
                    std::uint32_t known) {
  for (std::size_t k = 0; k < 3; ++k) {
    encoder.encode(seed[k] != known, is_known_[k]);
    if (seed[k] != known)
      encoder.encode_bits(seed[k], std::bit_width(known));
    else
      ++known;
  }
}

std::array<std::uint32_t, 3> SeedModel::get(entropy::RangeDecoder& decoder, std::uint32_t known) {
  std::array<std::uint32_t, 3> seed{};
  for (std::size_t k = 0; k < 3; ++k)
    seed[k] = decoder.decode(is_known_[k]) ? decoder.decode_bits(std::bit_width(known)) : known++;
  return seed;
}

void order_by_traversal(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count) {
  MeshSource source(triangles, vertex_count);
  std::vector<mesh::Triangle> ordered(triangles.size());
  LinkStore store(vertex_count);
  COLOSSUS_CHECK(traverse(source, std::span(ordered), vertex_count, store), "{} triangles", triangles.size());
  for (mesh::Triangle& t : ordered)
    for (auto& v : t) v = source.before()[v];
  triangles = std::move(ordered);
}

void ConnectivityEncoder::encode(const coded::CodedPart& part, LinkStore& store) {
  EncodingSource source(*this, part);
  std::vector<mesh::Triangle> triangles(part.triangles.size());
  COLOSSUS_CHECK(
      traverse(source, std::span(triangles), part.positions.size(), store) && triangles == part.triangles,
      "triangles are not in the codec's order, or vertices are not in order of first use");
}

core::Bytes ConnectivityEncoder::finish() {
  std::vector<std::uint32_t> counts(kContexts * kSymbols);
  for (const Occurrence& o : symbols_) ++counts[o.context * kSymbols + static_cast<std::size_t>(o.symbol)];
  const TableRuns runs = TableRuns::of(counts, kSymbols);
  std::vector<std::vector<Occurrence>> by_table(runs.table_count());
  for (const Occurrence& o : symbols_) by_table[runs.tables()[o.context]].push_back(o);
  ValueEncoder values(kContexts, kSymbols);
  core::ByteWriter sizes;
  for (const auto& symbols : by_table) {
    for (const Occurrence& o : symbols) values.put(o.context, static_cast<std::uint32_t>(o.symbol));
    values.end_batch();
    put_size(sizes, symbols.size());
  }
  const core::Bytes value_bytes = values.finish();
  core::ByteWriter writer;
  put_size(writer, value_bytes.size());
  writer.put_bytes(value_bytes);
  writer.put_bytes(sizes.bytes());
  writer.put_bytes(bits_.finish_without_zeros());
  return writer.take();
}

ConnectivityDecoder::ConnectivityDecoder(std::span<const std::byte> bytes, std::size_t triangle_count)
    : bits_({}) {
  core::ByteReader reader(bytes);
  const std::size_t size = get_size(reader);
  ValueDecoder values(reader.get_bytes(size), kContexts, TableLayout::kRuns);
  tables_ = values.tables();
  // Gates, of which a triangle opens three at most, are served once.
  std::size_t room = 3 * triangle_count;
  std::vector<std::size_t> counts(values.table_count());
  for (auto& count : counts) {
    count = std::min(get_size(reader), room + 1);
    is_valid_ = is_valid_ && count <= room;
    room -= std::min(count, room);
  }
  if (counts.empty()) counts.push_back(0);
  bits_ = entropy::RangeDecoder(reader.get_bytes(reader.remaining()));
  symbols_ = std::make_unique_for_overwrite<std::uint32_t[]>(3 * triangle_count - room + 2 * counts.size());
  std::uint32_t* next = symbols_.get();
  for (std::size_t i = 0; is_valid_ && i < counts.size(); ++i) {
    values.get_of_table(std::span(next, counts[i]), i);
    // One for the symbol that is none, and one for what is read after it.
    next[counts[i]] = next[counts[i] + 1] = kEnd;
    sequences_.push_back({next + 1, next[0]});
    next += counts[i] + 2;
  }
  is_valid_ = is_valid_ && !reader.failed() && values.is_done();
}

bool ConnectivityDecoder::decode(coded::CodedPart& part, LinkStore& store) {
  if (!is_valid_) return false;
  DecodingSource source(*this);
  return traverse(source, std::span(part.triangles), part.positions.size(), store);
}

bool ConnectivityDecoder::is_done() const {
  // What is left of each sequence is its end.
  return is_valid_ && std::all_of(sequences_.begin(), sequences_.end(),
                                  [](const Sequence& sequence) { return sequence.symbol == kEnd; });
}

}  // namespace colossus::codec::predict
