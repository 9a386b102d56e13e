#include "codec/predict/connectivity.hpp"

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

  Step step(const Situation& at, std::uint32_t) {
    const std::uint32_t half = mates_[halves_[at.gate]];
    if (half == kNone || is_done_[half / 3]) return {};
    is_done_[half / 3] = true;
    half_ = half;
    const std::uint32_t third = triangles_[half / 3][(half + 2) % 3];
    if (numbers_[third] == kNone) return {Symbol::kNew, number_of(third)};
    const std::uint32_t number = numbers_[third];
    if (at.can_be_last && number == at.right) return {Symbol::kLast, number};
    if (at.can_be_right && number == at.right) return {Symbol::kRight, number};
    if (at.can_be_left && number == at.left) return {Symbol::kLeft, number};
    return {Symbol::kKnown, number};
  }

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
  std::uint32_t half_ = 0;  // of the latest triangle, on the gate that led to it
};

// A mesh that writes down what it answers.
class EncodingSource : public MeshSource {
 public:
  EncodingSource(BitEncoder& encoder, SymbolModel& model, const CodedPart& part)
      : MeshSource(part.triangles, part.positions.size()), encoder_(encoder), model_(model) {}
  std::array<std::uint32_t, 3> seed(std::uint32_t known) {
    const auto seed = MeshSource::seed(known);
    model_.put_seed(encoder_, seed, known);
    return seed;
  }
  Step step(const Situation& at, std::uint32_t known) {
    const Step step = MeshSource::step(at, known);
    model_.put(encoder_, at, step, known);
    return step;
  }

 private:
  BitEncoder& encoder_;
  SymbolModel& model_;
};

class DecodingSource {
 public:
  static constexpr bool kNeedsEnds = false;

  DecodingSource(const BitDecoder& decoder, SymbolModel& model) : decoder_(decoder), model_(model) {}
  std::array<std::uint32_t, 3> seed(std::uint32_t known) { return model_.get_seed(decoder_, known); }
  Step step(const Situation& at, std::uint32_t known) { return model_.get(decoder_, at, known); }
  void opened(std::uint32_t, GateOrigin) {}
  const BitDecoder& decoder() const { return decoder_; }

 private:
  // A copy, which nothing else can point to: so it stays in registers.
  BitDecoder decoder_;
  SymbolModel& model_;
};

}  // namespace

void SymbolModel::put(BitEncoder& encoder, const Situation& at, const Step& step, std::uint32_t known) {
  const Symbol symbol = step.symbol;
  if (at.can_be_last) {
    encoder.put(is_last_, symbol == Symbol::kLast);
    if (symbol == Symbol::kLast) return;
  }
  Models& m = models(at);
  encoder.put(m.is_new, symbol != Symbol::kNew);
  if (symbol == Symbol::kNew) return;
  if (at.can_be_right) {
    encoder.put(m.is_right, symbol != Symbol::kRight);
    if (symbol == Symbol::kRight) return;
  }
  if (at.can_be_left) {
    encoder.put(m.is_left, symbol != Symbol::kLeft);
    if (symbol == Symbol::kLeft) return;
  }
  encoder.put(m.is_border, symbol != Symbol::kBorder);
  if (symbol != Symbol::kBorder) encoder.put_bits(step.vertex, std::bit_width(known));
}

void SymbolModel::put_seed(BitEncoder& encoder, const std::array<std::uint32_t, 3>& seed,
                           std::uint32_t known) {
  for (std::size_t k = 0; k < 3; ++k) {
    encoder.put(is_seed_new_[k], seed[k] != known);
    if (seed[k] != known)
      encoder.put_bits(seed[k], std::bit_width(known));
    else
      ++known;
  }
}

std::array<std::uint32_t, 3> SymbolModel::get_seed(BitDecoder& decoder, std::uint32_t known) {
  std::array<std::uint32_t, 3> seed{};
  for (std::size_t k = 0; k < 3; ++k)
    seed[k] = decoder.get(is_seed_new_[k]) ? decoder.get_bits(std::bit_width(known)) : known++;
  return seed;
}

void order_by_traversal(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count) {
  MeshSource source(triangles, vertex_count);
  std::vector<mesh::Triangle> ordered(triangles.size());
  std::vector<VertexLinks> links(vertex_count);
  COLOSSUS_CHECK(Traversal(source, std::span(ordered), std::span(links)).run(), "{} triangles",
                 triangles.size());
  for (mesh::Triangle& t : ordered)
    for (auto& v : t) v = source.before()[v];
  triangles = std::move(ordered);
}

void encode_connectivity(BitEncoder& encoder, SymbolModel& model, const CodedPart& part,
                         std::span<VertexLinks> links) {
  EncodingSource source(encoder, model, part);
  std::vector<mesh::Triangle> triangles(part.triangles.size());
  COLOSSUS_CHECK(Traversal(source, std::span(triangles), links).run() && triangles == part.triangles,
                 "triangles are not in the codec's order, or vertices are not in order of first use");
}

bool decode_connectivity(BitDecoder& decoder, SymbolModel& model, CodedPart& part,
                         std::span<VertexLinks> links) {
  DecodingSource source(decoder, model);
  const bool is_valid = Traversal(source, std::span(part.triangles), links).run();
  decoder = source.decoder();
  return is_valid;
}

}  // namespace colossus::codec::predict
