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

// All numbers are less than the vertex's own. Where there is at least one relation or neighbour, the places
// of those that are missing hold copies of others, so that a mean needs no branch: one relation stands three
// times, the second of two twice; of neighbours a come a a a a, of a, b come a b a b, of a, b, c come a b c
// b.
struct VertexLinks {
  std::array<Relation, kMostRelations> relations;
  std::array<std::uint32_t, kMostNeighbors> neighbors;
  std::uint8_t relation_count = 0;
  std::uint8_t neighbor_count = 0;
  bool is_border = false;

  // What contexts are made of, in a byte of its own: relations in bits 0 and 1, neighbours in 2 to 4, border
  // in 5.
  std::uint8_t kind() const {
    return static_cast<std::uint8_t>(relation_count | neighbor_count << 2 | (is_border ? 32 : 0));
  }

  void add_relation(std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    if (relation_count == kMostRelations) return;
    for (std::size_t k = relation_count++; k < kMostRelations; ++k) relations[k].set(p, q, r);
  }
  void add_neighbor(std::uint32_t neighbor) {
    if (neighbor_count == kMostNeighbors) return;
    if (neighbor_count == 0) neighbors.fill(neighbor);
    if (neighbor_count == 1) neighbors[3] = neighbor;
    neighbors[neighbor_count++] = neighbor;
  }
};

// VertexLinks::kind(), taken apart.
constexpr std::uint32_t relations_of(std::uint8_t kind) { return kind & 3U; }
constexpr std::uint32_t neighbors_of(std::uint8_t kind) { return kind >> 2 & 7U; }
constexpr bool is_border(std::uint8_t kind) { return kind >= 32; }

// What the traversal tells of the vertices of a part.
struct Links {
  std::span<const VertexLinks> of;
  std::span<const std::uint8_t> kinds;
};

// Memory for it, used again for one part after the other.
class LinkStore {
 public:
  explicit LinkStore(std::size_t most_vertices)
      : links_(std::make_unique_for_overwrite<VertexLinks[]>(most_vertices)), kinds_(most_vertices) {}
  std::span<VertexLinks> links(std::size_t count) { return {links_.get(), count}; }
  // Of the links as they are now.
  Links finish(std::size_t count) {
    for (std::size_t v = 0; v < count; ++v) kinds_[v] = links_[v].kind();
    return {{links_.get(), count}, std::span(kinds_).first(count)};
  }

 private:
  std::unique_ptr<VertexLinks[]> links_;
  std::vector<std::uint8_t> kinds_;
};

// Triangles at a vertex so far, as far as they are counted.
inline constexpr std::uint8_t kMostValence = 9;

// What is known when a gate is served; the gate runs from a to b.
struct Situation {
  std::uint32_t gate = 0;
  std::uint32_t left = 0;    // where the gate before begins
  std::uint32_t right = 0;   // where the next gate ends
  bool can_be_left = false;  // the gate before is not on a border
  bool can_be_right = false;
  bool can_be_last = false;
  std::uint8_t valence_a = 0;
  std::uint8_t valence_b = 0;
  Symbol latest = Symbol::kNew;  // but for borders
};

struct Step {
  Symbol symbol = Symbol::kBorder;
  std::uint32_t vertex = 0;  // of kKnown
};

// Which of a triangle's edges a new gate lies on.
enum class GateOrigin : std::uint8_t { kSeed0, kSeed1, kSeed2, kSecondToThird, kThirdToFirst };

// The machine; Source is a mesh to be encoded or a stream of symbols. It has
//   std::array<std::uint32_t, 3> seed(std::uint32_t known): the next seed's vertices, new ones numbered from
//     `known` on by first use,
//   Step step(const Situation&, std::uint32_t known),
//   void opened(std::uint32_t gate, GateOrigin): for each new gate, in ascending order; of the latest
//   triangle.
template <typename Source>
class Traversal {
 public:
  // As many triangles as there is room for, written as they come; links for all vertices.
  Traversal(Source& source, std::span<mesh::Triangle> triangles, std::span<VertexLinks> links)
      : source_(source),
        triangles_(triangles),
        links_(links),
        // A triangle opens three gates at most.
        gates_(std::make_unique_for_overwrite<Gate[]>(3 * triangles.size())),
        vertices_(links.size()) {}

  // Whether the source made sense.
  bool run() {
    while (triangle_count_ < triangles_.size()) {
      if (served_ == gate_count_) {
        if (!begin()) return false;
      } else {
        if (gates_[served_].state == State::kOpen && !serve(served_)) return false;
        ++served_;
      }
    }
    for (; served_ < gate_count_; ++served_)
      if (gates_[served_].state == State::kOpen) mark_border(served_);
    std::fill(links_.begin() + known_, links_.end(), VertexLinks{});
    return true;
  }

 private:
  enum class State : std::uint8_t { kOpen, kBorder, kDone };
  struct Gate {
    std::uint32_t from;
    std::uint32_t opposite;  // third vertex of the triangle on this side
    std::uint32_t next;
    std::uint32_t before;
    State state;
  };
  struct Vertex {
    std::uint32_t gate = kNone;  // the latest from here
    std::uint8_t valence = 0;
  };

  std::uint32_t open(std::uint32_t from, std::uint32_t opposite, GateOrigin origin) {
    const std::uint32_t gate = gate_count_++;
    Gate& g = gates_[gate];
    g.from = from;
    g.opposite = opposite;
    g.next = gate;
    g.before = gate;
    g.state = State::kOpen;
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
      if (v > known_ || v >= vertices_.size()) return false;
      if (v == known_) links_[known_++] = {};
    }
    emit(p, q, r);
    connect(p, q);
    connect(q, r);
    connect(r, p);
    // Seen from outside, edges run the other way.
    const std::uint32_t g0 = open(q, r, GateOrigin::kSeed0);
    const std::uint32_t g1 = open(r, p, GateOrigin::kSeed1);
    const std::uint32_t g2 = open(p, q, GateOrigin::kSeed2);
    link(g0, g2);
    link(g2, g1);
    link(g1, g0);
    return true;
  }

  // Gates are read field by field: whole ones would wait for the stores of their fields.
  bool serve(std::uint32_t gate) {
    const std::uint32_t next = gates_[gate].next;
    const std::uint32_t before = gates_[gate].before;
    const std::uint32_t a = gates_[gate].from;
    const std::uint32_t b = gates_[next].from;
    Situation at;
    at.gate = gate;
    // A gate that is its own neighbour is no neighbour.
    at.can_be_right = gates_[next].state == State::kOpen && next != gate;
    at.can_be_left = gates_[before].state == State::kOpen && before != gate;
    at.can_be_last = at.can_be_left && at.can_be_right && gates_[next].next == before && next != before;
    at.valence_a = vertices_[a].valence;
    at.valence_b = vertices_[b].valence;
    at.latest = latest_;
    if constexpr (Source::kNeedsEnds) {
      at.left = gates_[before].from;
      at.right = gates_[gates_[next].next].from;
    }
    const Step step = source_.step(at, known_);
    if (step.symbol == Symbol::kBorder) {
      mark_border(gate);
      return true;
    }
    latest_ = step.symbol;
    gates_[gate].state = State::kDone;
    const std::uint32_t opposite = gates_[gate].opposite;
    switch (step.symbol) {
      case Symbol::kNew:
        if (known_ >= vertices_.size()) return false;
        attach_new(a, b, opposite, before, next, next == gate);
        return true;
      case Symbol::kRight:
        attach_right(a, b, opposite, before, next);
        return true;
      case Symbol::kLeft:
        attach_left(a, b, opposite, before, next);
        return true;
      case Symbol::kLast: {
        const std::uint32_t third = gates_[before].from;
        emit(a, b, third);
        relate(a, b, opposite, third);
        relate(b, third, gates_[next].opposite, a);
        relate(third, a, gates_[before].opposite, b);
        gates_[next].state = State::kDone;
        gates_[before].state = State::kDone;
        return true;
      }
      default:
        if (step.vertex >= known_) return false;
        attach_known(a, b, opposite, before, next, gate, step.vertex);
        return true;
    }
  }

  void attach_new(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                  std::uint32_t next, bool is_alone) {
    const std::uint32_t third = known_++;
    emit(a, b, third);
    VertexLinks& links = links_[third];
    for (Relation& relation : links.relations) relation.set(a, b, opposite);
    links.relation_count = 1;
    links.neighbors[0] = links.neighbors[2] = a;
    links.neighbors[1] = links.neighbors[3] = b;
    links.neighbor_count = 2;
    links.is_border = false;
    const std::uint32_t left = open(a, b, GateOrigin::kThirdToFirst);
    const std::uint32_t right = open(third, a, GateOrigin::kSecondToThird);
    link(left, right);
    link(is_alone ? right : before, left);
    link(right, is_alone ? left : next);
  }

  void attach_right(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                    std::uint32_t next) {
    const std::uint32_t after = gates_[next].next;
    const std::uint32_t third = gates_[after].from;
    emit(a, b, third);
    relate(a, b, opposite, third);
    relate(b, third, gates_[next].opposite, a);
    gates_[next].state = State::kDone;
    connect(a, third);
    const std::uint32_t left = open(a, b, GateOrigin::kThirdToFirst);
    // A loop of two gates is replaced by one of one.
    link(before == next ? left : before, left);
    link(left, before == next ? left : after);
  }

  void attach_left(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                   std::uint32_t next) {
    const std::uint32_t after = gates_[before].before;
    const std::uint32_t third = gates_[before].from;
    emit(a, b, third);
    relate(a, b, opposite, third);
    relate(third, a, gates_[before].opposite, b);
    gates_[before].state = State::kDone;
    connect(b, third);
    const std::uint32_t right = open(third, a, GateOrigin::kSecondToThird);
    link(before == next ? right : after, right);
    link(right, before == next ? right : next);
  }

  // Of the loop and that of the other vertex's gate become one, or of one loop two.
  void attach_known(std::uint32_t a, std::uint32_t b, std::uint32_t opposite, std::uint32_t before,
                    std::uint32_t next, std::uint32_t gate, std::uint32_t third) {
    emit(a, b, third);
    relate(a, b, opposite, third);
    connect(third, a);
    connect(third, b);
    const std::uint32_t other = vertices_[third].gate;
    const bool is_alone = next == gate;
    const std::uint32_t left = open(a, b, GateOrigin::kThirdToFirst);
    const std::uint32_t right = open(third, a, GateOrigin::kSecondToThird);
    link(is_alone ? right : before, left);
    link(right, is_alone ? left : next);
    if (other != kNone && gates_[other].state != State::kDone) {
      const std::uint32_t other_before = gates_[other].before;
      link(left, other);
      link(other_before, right);
    } else {
      link(left, right);
    }
  }

  void mark_border(std::uint32_t gate) {
    gates_[gate].state = State::kBorder;
    links_[gates_[gate].from].is_border = true;
    links_[gates_[gates_[gate].next].from].is_border = true;
  }

  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh::Triangle& triangle = triangles_[triangle_count_++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
    count_triangle(a);
    count_triangle(b);
    count_triangle(c);
  }
  void count_triangle(std::uint32_t v) {
    std::uint8_t& valence = vertices_[v].valence;
    valence = static_cast<std::uint8_t>(valence + (valence < kMostValence ? 1 : 0));
  }

  void connect(std::uint32_t v, std::uint32_t w) {
    if (v != w) links_[std::max(v, w)].add_neighbor(std::min(v, w));
  }

  // Two triangles share the edge pq and have third vertices r and s.
  void relate(std::uint32_t p, std::uint32_t q, std::uint32_t r, std::uint32_t s) {
    const std::uint32_t end = std::max(p, q);
    const std::uint32_t tip = std::max(r, s);
    if (tip > end) {
      if (r != s) links_[tip].add_relation(p, q, std::min(r, s));
    } else if (end > tip && p != q) {
      links_[end].add_relation(r, s, std::min(p, q));
    }
  }

  Source& source_;
  std::span<mesh::Triangle> triangles_;
  std::size_t triangle_count_ = 0;
  std::span<VertexLinks> links_;
  std::unique_ptr<Gate[]> gates_;
  std::uint32_t gate_count_ = 0;
  std::vector<Vertex> vertices_;
  std::uint32_t served_ = 0;
  std::uint32_t known_ = 0;
  Symbol latest_ = Symbol::kNew;
};

}  // namespace colossus::codec::predict
