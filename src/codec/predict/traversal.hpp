// The order in which triangles are stored, and what it says about vertices before any attribute is known.
//
// A cut-border machine (Gumhold and Strasser, Real time compression of triangle mesh connectivity, 1998; the
// symbols are those of Edgebreaker, Rossignac 1999): from a seed triangle on, the border of what is done so
// far is a set of loops of gates, and each gate in turn says which triangle lies behind it. Gates are served
// first come, first served, not depth first: the fronts then meet side by side, most vertices have two
// parallelograms when they come, and meetings that split a loop, which need a vertex number, are rare.
//
// Any triangles will do: an edge of other than two triangles, or of two that turn differently, is a border,
// and what a gate does not lead to gets a seed of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mesh/mesh.hpp"

namespace colossus::codec::predict {

enum class Symbol : std::uint8_t {
  kNew,     // the third vertex is new
  kRight,   // it is the far end of the next gate, which is done as well
  kLeft,    // it is the near end of the gate before, which is done as well
  kBorder,  // there is no triangle
  kLast,    // both: the loop has three gates and ends
  kKnown    // any other vertex: loops split or join, or touch themselves
};

inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

// A vertex continues the parallelogram of three that come before it: first + second - opposite.
struct Relation {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t opposite;

  // Field by field, and so are other small structs that are written here and read soon: compilers copy whole
  // ones in wide pieces, which then wait for the narrow stores that they are made of.
  void set(std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    first = p;
    second = q;
    opposite = r;
  }
};

inline constexpr std::size_t kMostRelations = 3;
inline constexpr std::size_t kMostNeighbors = 4;

// Numbers of vertices that come before it, as many as its kind says. Where there is at least one relation or
// neighbour, the places of those that are missing hold copies of others, so that a mean needs no branch: one
// relation stands three times, the second of two twice; of neighbours a come a a a a, of a, b come a b a b,
// of a, b, c come a b c b.
struct VertexLinks {
  std::array<Relation, kMostRelations> relations;
  std::array<std::uint32_t, kMostNeighbors> neighbors;
};

// How many relations a vertex has in bits 0 and 1, how many neighbours in 2 to 4, and whether it is on a
// border in 5.
using Kind = std::uint8_t;
inline constexpr Kind kRelation = 1;
inline constexpr Kind kNeighbor = 4;
inline constexpr Kind kOnBorder = 32;
constexpr std::uint32_t relations_of(Kind kind) { return kind & 3U; }
constexpr std::uint32_t neighbors_of(Kind kind) { return kind >> 2 & 7U; }
constexpr bool is_border(Kind kind) { return kind >= kOnBorder; }

// What the traversal tells of the vertices of a part.
struct Links {
  std::span<const VertexLinks> of;
  std::span<const Kind> kinds;
};

// Memory for it, used again for one part after the other.
class LinkStore {
 public:
  explicit LinkStore(std::size_t most_vertices)
      : links_(std::make_unique_for_overwrite<VertexLinks[]>(most_vertices)),
        kinds_(std::make_unique_for_overwrite<Kind[]>(most_vertices)) {}
  VertexLinks* links() { return links_.get(); }
  Kind* kinds() { return kinds_.get(); }
  Links first(std::size_t count) const { return {{links_.get(), count}, {kinds_.get(), count}}; }

 private:
  std::unique_ptr<VertexLinks[]> links_;
  std::unique_ptr<Kind[]> kinds_;
};

// Which of the gates beside a gate are other gates and not on a border; or that both are, and end the loop.
enum class Sides : std::uint8_t { kNeither, kLeft, kRight, kBoth, kLoop };

// What is known when a gate is served; the gate runs from a to b.
struct Situation {
  std::uint32_t gate = 0;
  std::uint32_t left = 0;   // where the gate before begins
  std::uint32_t right = 0;  // where the next gate ends
  Sides sides = Sides::kNeither;
  std::uint32_t valence_a = 0;  // triangles so far
  std::uint32_t valence_b = 0;
  std::uint32_t latest = 0;  // symbol but for borders: 0 for new, as at the start, 1 for right, 2 for others

  bool can_be_left() const { return sides == Sides::kLeft || sides >= Sides::kBoth; }
  bool can_be_right() const { return sides >= Sides::kRight; }
  bool can_be_last() const { return sides == Sides::kLoop; }
};

// Which of a triangle's edges a new gate lies on.
enum class GateOrigin : std::uint8_t { kSeed0, kSeed1, kSeed2, kSecondToThird, kThirdToFirst };

// The machine; Source is a mesh to be encoded or a stream of symbols. It has
//   std::array<std::uint32_t, 3> seed(std::uint32_t known): the next seed's vertices, new ones numbered from
//     `known` on by first use,
//   Symbol step(const Situation&, std::uint32_t known),
//   std::uint32_t known_vertex(std::uint32_t known): after kKnown, which,
//   void opened(std::uint32_t gate, GateOrigin): for each new gate, in ascending order; of the latest
//   triangle.
//
// Decoders spend a third of their time here, at some hundred instructions per triangle: what is rare stands
// apart, and what every triangle does is written so that it takes few.
template <typename Source>
class Traversal {
 public:
  // As many triangles as there is room for, written as they come; links for all vertices, less than 2^31.
  Traversal(Source& source, std::span<mesh::Triangle> triangles, std::size_t vertex_count, LinkStore& store)
      : source_(source),
        triangle_(triangles.data()),
        last_triangle_(triangles.data() + triangles.size()),
        vertex_count_(static_cast<std::uint32_t>(vertex_count)),
        links_(store.links()),
        kinds_(store.kinds()),
        // A triangle opens three gates at most.
        gates_(std::make_unique_for_overwrite<Gate[]>(3 * triangles.size())),
        vertices_(std::make_unique_for_overwrite<Vertex[]>(vertex_count)) {}

  // Whether the source made sense.
  bool run() {
    while (triangle_ != last_triangle_) {
      while (served_ != gate_count_ && !is_open(served_)) ++served_;
      if (served_ == gate_count_ ? !begin() : !serve(served_++)) return false;
    }
    for (; served_ < gate_count_; ++served_)
      if (is_open(served_)) mark_border(served_);
    for (std::uint32_t v = known_; v < vertex_count_; ++v) {
      links_[v] = {};
      kinds_[v] = 0;
    }
    return true;
  }

 private:
  struct Gate {
    std::uint32_t from;
    std::uint32_t opposite;  // third vertex of the triangle on this side, or a state
    std::uint32_t next;
    std::uint32_t before;
  };
  // States but open.
  static constexpr std::uint32_t kDone = ~std::uint32_t{0};
  static constexpr std::uint32_t kBorder = kDone - 1;
  struct Vertex {
    std::uint32_t gate;  // the latest from here, or kNone
    std::uint32_t valence;
  };

  bool is_open(std::uint32_t gate) const { return static_cast<std::int32_t>(gates_[gate].opposite) >= 0; }

  std::uint32_t open(std::uint32_t from, std::uint32_t opposite, std::uint32_t before, std::uint32_t next,
                     GateOrigin origin) {
    const std::uint32_t gate = gate_count_++;
    gates_[gate].from = from;
    gates_[gate].opposite = opposite;
    gates_[gate].next = next;
    gates_[gate].before = before;
    vertices_[from].gate = gate;
    source_.opened(gate, origin);
    return gate;
  }
  void link(std::uint32_t before, std::uint32_t next) {
    gates_[before].next = next;
    gates_[next].before = before;
  }

  bool begin() {
    const auto [p, q, r] = source_.seed(known_);
    for (const std::uint32_t v : {p, q, r}) {
      if (v > known_ || v >= vertex_count_) return false;
      if (v < known_) continue;
      vertices_[v] = {kNone, 0};
      links_[v] = {};
      kinds_[v] = 0;
      ++known_;
    }
    emit(p, q, r);
    connect(p, q);
    connect(q, r);
    connect(r, p);
    // Seen from outside, edges run the other way.
    const std::uint32_t first = gate_count_;
    open(q, r, first + 1, first + 2, GateOrigin::kSeed0);
    open(r, p, first + 2, first, GateOrigin::kSeed1);
    open(p, q, first, first + 1, GateOrigin::kSeed2);
    return true;
  }

  // Gates are read field by field: whole ones would wait for the stores of their fields.
  bool serve(std::uint32_t gate) {
    const std::uint32_t next = gates_[gate].next;
    const std::uint32_t before = gates_[gate].before;
    const std::uint32_t a = gates_[gate].from;
    const std::uint32_t b = gates_[next].from;
    const std::uint32_t opposite = gates_[gate].opposite;
    // First, so that a gate that is its own neighbour does not seem to have an open one.
    gates_[gate].opposite = kDone;
    Situation at;
    at.gate = gate;
    std::uint32_t sides = (is_open(before) ? 1U : 0U) + (is_open(next) ? 2U : 0U);
    if (sides == 3 && gates_[next].next == before) sides = 4;
    at.sides = static_cast<Sides>(sides);
    at.valence_a = vertices_[a].valence;
    at.valence_b = vertices_[b].valence;
    at.latest = latest_;
    if constexpr (Source::kNeedsEnds) {
      at.left = gates_[before].from;
      at.right = gates_[gates_[next].next].from;
    }
    const Symbol symbol = source_.step(at, known_);
    if (symbol == Symbol::kNew) {
      if (known_ >= vertex_count_) return false;
      attach_new(a, b, opposite, before, next, gate);
      latest_ = 0;
    } else if (symbol == Symbol::kRight) {
      if (!at.can_be_right()) return false;
      attach_side<false>(a, b, opposite, before, next);
      latest_ = 1;
    } else if (symbol == Symbol::kLeft) {
      if (!at.can_be_left()) return false;
      attach_side<true>(a, b, opposite, before, next);
      latest_ = 2;
    } else if (symbol == Symbol::kBorder) {
      mark_border(gate);
    } else {
      latest_ = 2;
      return serve_rarely(symbol, at, {a, b, opposite}, before, next);
    }
    return true;
  }

  bool serve_rarely(Symbol symbol, const Situation& at, const Relation& behind, std::uint32_t before,
                    std::uint32_t next) {
    const auto [a, b, opposite] = behind;
    if (symbol == Symbol::kLast && at.can_be_last()) {
      attach_last(a, b, opposite, before, next);
      return true;
    }
    if (symbol != Symbol::kKnown) return false;
    const std::uint32_t third = source_.known_vertex(known_);
    if (third >= known_) return false;
    attach_known(a, b, opposite, before, next, at.gate, third);
    return true;
  }

  void attach_new(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                  std::uint32_t next, std::uint32_t gate) {
    const std::uint32_t third = known_++;
    vertices_[third].valence = 0;
    emit(a, b, third);
    VertexLinks& links = links_[third];
    for (Relation& relation : links.relations) relation.set(a, b, opposite);
    links.neighbors[0] = links.neighbors[2] = a;
    links.neighbors[1] = links.neighbors[3] = b;
    kinds_[third] = kRelation + 2 * kNeighbor;
    open_two(a, b, third, before, next, gate);
  }

  // From a to the third vertex and on, in the place of the gate.
  void open_two(std::uint32_t a, std::uint32_t b, std::uint32_t third, std::uint32_t before,
                std::uint32_t next, std::uint32_t gate) {
    const std::uint32_t left = gate_count_;
    const std::uint32_t right = left + 1;
    open(a, b, before, right, GateOrigin::kThirdToFirst);
    open(third, a, left, next, GateOrigin::kSecondToThird);
    gates_[before].next = left;
    gates_[next].before = right;
    // It was alone in its loop.
    if (next == gate) link(right, left);
  }

  // With the next gate, or on the left with the gate before. Twice in the program, since the symbol's branch
  // is shorter than choosing each value.
  template <bool kIsLeft>
  void attach_side(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                   std::uint32_t next) {
    const std::uint32_t side = kIsLeft ? before : next;
    const std::uint32_t after = kIsLeft ? gates_[side].before : gates_[side].next;
    const std::uint32_t third = kIsLeft ? gates_[side].from : gates_[after].from;
    const std::uint32_t near = kIsLeft ? a : b;
    const std::uint32_t far = kIsLeft ? b : a;
    emit(a, b, third);
    attach_corner({a, b, opposite}, {gates_[side].opposite, far, near}, third, far);
    gates_[side].opposite = kDone;
    const std::uint32_t gate_before = kIsLeft ? after : before;
    const std::uint32_t gate_after = kIsLeft ? next : after;
    const std::uint32_t gate = open(kIsLeft ? third : a, near, gate_before, gate_after,
                                    kIsLeft ? GateOrigin::kSecondToThird : GateOrigin::kThirdToFirst);
    gates_[gate_before].next = gate;
    gates_[gate_after].before = gate;
    // A loop of two gates is replaced by one of one.
    if (before == next) link(gate, gate);
  }

  void attach_last(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                   std::uint32_t next) {
    const std::uint32_t third = gates_[before].from;
    emit(a, b, third);
    relate(a, b, opposite, third);
    relate(b, third, gates_[next].opposite, a);
    relate(third, a, gates_[before].opposite, b);
    gates_[next].opposite = kDone;
    gates_[before].opposite = kDone;
  }

  // Of the loop and that of the other vertex's gate become one, or of one loop two.
  void attach_known(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                    std::uint32_t next, std::uint32_t gate, std::uint32_t third) {
    emit(a, b, third);
    relate(a, b, opposite, third);
    connect(third, a);
    connect(third, b);
    const std::uint32_t other = vertices_[third].gate;
    const std::uint32_t left = gate_count_;
    open_two(a, b, third, before, next, gate);
    if (other == kNone || gates_[other].opposite == kDone) return;
    const std::uint32_t other_before = gates_[other].before;
    link(left, other);
    link(other_before, left + 1);
  }

  void mark_border(std::uint32_t gate) {
    gates_[gate].opposite = kBorder;
    kinds_[gates_[gate].from] |= kOnBorder;
    kinds_[gates_[gates_[gate].next].from] |= kOnBorder;
  }

  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t third) {
    mesh::Triangle& triangle = *triangle_++;
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = third;
    ++vertices_[a].valence;
    ++vertices_[b].valence;
    ++vertices_[third].valence;
  }

  // A triangle closes the corner between two gates: its third vertex continues the parallelograms behind
  // both, and gets the far end as a neighbour. Nearly always that vertex is the latest of all and has only
  // what came with it, or all relations already.
  void attach_corner(const Relation& behind_gate, const Relation& behind_other, std::uint32_t third,
                     std::uint32_t end) {
    const std::uint32_t latest =
        std::max({behind_gate.first, behind_gate.second, behind_gate.opposite, behind_other.first});
    const Kind kind = kinds_[third];
    if (third > latest && (kind & (kOnBorder - 1)) == kRelation + 2 * kNeighbor) {
      VertexLinks& links = links_[third];
      links.relations[1].set(behind_gate.first, behind_gate.second, behind_gate.opposite);
      links.relations[2].set(behind_other.first, behind_other.second, behind_other.opposite);
      links.neighbors[2] = end;
      kinds_[third] = static_cast<Kind>(kind + 2 * kRelation + kNeighbor);
      return;
    }
    if (third > latest && relations_of(kind) == kMostRelations) {
      connect(end, third);
      return;
    }
    relate(behind_gate.first, behind_gate.second, behind_gate.opposite, third);
    relate(behind_other.opposite, third, behind_other.first, end);
    connect(end, third);
  }

  void connect(std::uint32_t v, std::uint32_t w) {
    if (v == w) return;
    const std::uint32_t later = std::max(v, w);
    auto& neighbors = links_[later].neighbors;
    const std::uint32_t count = neighbors_of(kinds_[later]);
    if (count == kMostNeighbors) return;
    if (count == 0) neighbors.fill(std::min(v, w));
    if (count == 1) neighbors[3] = std::min(v, w);
    neighbors[count] = std::min(v, w);
    kinds_[later] = static_cast<Kind>(kinds_[later] + kNeighbor);
  }

  // Two triangles share the edge pq and have third vertices r and s.
  void relate(std::uint32_t p, std::uint32_t q, std::uint32_t r, std::uint32_t s) {
    const std::uint32_t end = std::max(p, q);
    const std::uint32_t tip = std::max(r, s);
    if (tip > end && r != s)
      add_relation(tip, {p, q, std::min(r, s)});
    else if (end > tip && p != q)
      add_relation(end, {r, s, std::min(p, q)});
  }
  void add_relation(std::uint32_t v, const Relation& relation) {
    const std::uint32_t count = relations_of(kinds_[v]);
    if (count == kMostRelations) return;
    for (std::size_t k = count; k < kMostRelations; ++k)
      links_[v].relations[k].set(relation.first, relation.second, relation.opposite);
    kinds_[v] = static_cast<Kind>(kinds_[v] + kRelation);
  }

  Source& source_;
  mesh::Triangle* triangle_;  // the next to be written
  mesh::Triangle* last_triangle_;
  std::uint32_t vertex_count_;
  VertexLinks* links_;
  Kind* kinds_;
  std::unique_ptr<Gate[]> gates_;
  std::unique_ptr<Vertex[]> vertices_;
  std::uint32_t gate_count_ = 0;
  std::uint32_t served_ = 0;
  std::uint32_t known_ = 0;
  std::uint32_t latest_ = 0;
};

// Runs it. All in one function, so that the machine is not an object in memory but registers.
template <typename Source>
[[gnu::flatten]] bool traverse(Source& source, std::span<mesh::Triangle> triangles, std::size_t vertex_count,
                               LinkStore& store) {
  return Traversal(source, triangles, vertex_count, store).run();
}

}  // namespace colossus::codec::predict
