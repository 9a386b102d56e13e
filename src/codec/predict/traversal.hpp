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

#include <array>
#include <cstdint>
#include <optional>
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
};

inline constexpr std::size_t kMostRelations = 3;
inline constexpr std::size_t kMostNeighbors = 4;

// All numbers are less than the vertex's own.
struct VertexLinks {
  std::array<Relation, kMostRelations> relations;
  std::array<std::uint32_t, kMostNeighbors> neighbors;
  std::uint8_t relation_count = 0;
  std::uint8_t neighbor_count = 0;
  bool is_border = false;
};

// What is known when a gate is served; the gate runs from a to b.
struct Situation {
  std::uint32_t gate = 0;
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t left = 0;    // where the gate before begins
  std::uint32_t right = 0;   // where the next gate ends
  bool can_be_left = false;  // the gate before is not on a border
  bool can_be_right = false;
  bool can_be_last = false;
  std::uint32_t valence_a = 0;  // triangles so far
  std::uint32_t valence_b = 0;
  Symbol before = Symbol::kBorder;  // the latest symbol but for borders
};

struct Step {
  Symbol symbol = Symbol::kBorder;
  std::uint32_t vertex = 0;  // of kKnown
};

// Which of a triangle's edges a new gate lies on.
enum class GateOrigin : std::uint8_t { kSeed0, kSeed1, kSeed2, kSecondToThird, kThirdToFirst };

// The machine; Source is a mesh to be encoded or a stream of symbols. It has
//   std::optional<std::array<std::uint32_t, 3>> seed(std::uint32_t known): the next seed's vertices, new ones
//     numbered from `known` on by first use; none ends the run,
//   std::optional<Step> step(const Situation&): likewise,
//   void opened(std::uint32_t gate, GateOrigin): for each new gate, in ascending order; of the latest
//   triangle.
template <typename Source>
class Traversal {
 public:
  Traversal(Source& source, std::size_t vertex_count, std::size_t triangle_count)
      : source_(source), vertex_count_(vertex_count), triangle_count_(triangle_count) {
    links_.resize(vertex_count);
    gate_from_.assign(vertex_count, kNone);
    valence_.resize(vertex_count);
    triangles_.reserve(triangle_count);
    gates_.reserve(triangle_count + triangle_count / 2);
  }

  // Whether the source had all the triangles.
  bool run() {
    while (triangles_.size() < triangle_count_) {
      if (served_ == gates_.size()) {
        if (!begin()) return false;
      } else if (gates_[served_].state == State::kOpen) {
        if (!serve(served_)) return false;
        ++served_;
      } else {
        ++served_;
      }
    }
    for (; served_ < gates_.size(); ++served_)
      if (gates_[served_].state == State::kOpen) mark_border(gates_[served_]);
    return true;
  }

  std::vector<VertexLinks> take_links() { return std::move(links_); }
  std::vector<mesh::Triangle>& triangles() { return triangles_; }

 private:
  enum class State : std::uint8_t { kOpen, kBorder, kDone };
  struct Gate {
    std::uint32_t from;
    std::uint32_t opposite;  // third vertex of the triangle on this side
    std::uint32_t next;
    std::uint32_t before;
    State state;
  };

  std::uint32_t open(std::uint32_t from, std::uint32_t opposite, GateOrigin origin) {
    const auto gate = static_cast<std::uint32_t>(gates_.size());
    gates_.push_back({from, opposite, gate, gate, State::kOpen});
    gate_from_[from] = gate;
    source_.opened(gate, origin);
    return gate;
  }
  void link(std::uint32_t before, std::uint32_t next) {
    gates_[before].next = next;
    gates_[next].before = before;
  }

  bool begin() {
    const auto seed = source_.seed(known_);
    if (!seed) return false;
    for (const std::uint32_t v : *seed) {
      if (v > known_ || v >= vertex_count_) return false;
      if (v == known_) ++known_;
    }
    const auto [p, q, r] = *seed;
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

  bool serve(std::uint32_t gate) {
    const Gate g = gates_[gate];
    const Gate next = gates_[g.next];
    const Gate before = gates_[g.before];
    Situation at;
    at.gate = gate;
    at.a = g.from;
    at.b = next.from;
    at.left = before.from;
    at.right = gates_[next.next].from;
    // A gate that is its own neighbour is no neighbour.
    at.can_be_right = next.state == State::kOpen && g.next != gate;
    at.can_be_left = before.state == State::kOpen && g.before != gate;
    at.can_be_last = at.can_be_left && at.can_be_right && next.next == g.before && g.next != g.before;
    at.valence_a = valence_[at.a];
    at.valence_b = valence_[at.b];
    at.before = last_;
    const std::optional<Step> step = source_.step(at);
    if (!step) return false;
    if (step->symbol == Symbol::kBorder) {
      gates_[gate].state = State::kBorder;
      mark_border(g);
      return true;
    }
    last_ = step->symbol;
    return attach(at, g, *step);
  }

  bool attach(const Situation& at, const Gate& g, const Step& step) {
    std::uint32_t third = step.vertex;
    if (step.symbol == Symbol::kNew) {
      if (known_ >= vertex_count_) return false;
      third = known_++;
    } else if (step.symbol == Symbol::kLeft) {
      third = at.left;
    } else if (step.symbol != Symbol::kKnown) {
      third = at.right;
    } else if (third >= known_) {
      return false;
    }
    emit(at.a, at.b, third);
    relate(at.a, at.b, g.opposite, third);
    gates_[at.gate].state = State::kDone;
    if (step.symbol == Symbol::kRight || step.symbol == Symbol::kLast) {
      relate(at.b, third, gates_[g.next].opposite, at.a);
      gates_[g.next].state = State::kDone;
    }
    if (step.symbol == Symbol::kLeft || step.symbol == Symbol::kLast) {
      relate(third, at.a, gates_[g.before].opposite, at.b);
      gates_[g.before].state = State::kDone;
    }
    switch (step.symbol) {
      case Symbol::kLast:
        break;
      case Symbol::kRight: {
        const std::uint32_t after = gates_[g.next].next;
        connect(at.a, third);
        const std::uint32_t left = open(at.a, at.b, GateOrigin::kThirdToFirst);
        link(g.before, left);
        link(left, after);
        // Of a loop of two gates both are gone, and the new one is alone.
        if (after == at.gate) link(left, left);
        break;
      }
      case Symbol::kLeft: {
        const std::uint32_t after = gates_[g.before].before;
        connect(at.b, third);
        const std::uint32_t right = open(third, at.a, GateOrigin::kSecondToThird);
        link(after, right);
        link(right, g.next);
        if (after == at.gate) link(right, right);
        break;
      }
      default:
        split(at, g, third, step.symbol == Symbol::kNew);
    }
    return true;
  }

  void split(const Situation& at, const Gate& g, std::uint32_t third, bool is_new) {
    const std::uint32_t other = is_new ? kNone : gate_from_[third];
    connect(third, at.a);
    connect(third, at.b);
    const std::uint32_t left = open(at.a, at.b, GateOrigin::kThirdToFirst);
    const std::uint32_t right = open(third, at.a, GateOrigin::kSecondToThird);
    const bool is_alone = g.next == at.gate;
    link(is_alone ? right : g.before, left);
    link(right, is_alone ? left : g.next);
    if (other != kNone && other != at.gate && gates_[other].state != State::kDone) {
      const std::uint32_t before = gates_[other].before;
      link(left, other);
      link(before, right);
    } else {
      link(left, right);
    }
  }

  void mark_border(const Gate& g) {
    links_[g.from].is_border = true;
    links_[gates_[g.next].from].is_border = true;
  }

  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles_.push_back({a, b, c});
    for (const std::uint32_t v : {a, b, c}) ++valence_[v];
  }

  void connect(std::uint32_t v, std::uint32_t w) {
    if (v == w) return;
    VertexLinks& links = links_[std::max(v, w)];
    if (links.neighbor_count < kMostNeighbors) links.neighbors[links.neighbor_count++] = std::min(v, w);
  }

  // Two triangles share the edge pq and have third vertices r and s.
  void relate(std::uint32_t p, std::uint32_t q, std::uint32_t r, std::uint32_t s) {
    if (p > q) std::swap(p, q);
    if (r > s) std::swap(r, s);
    if (s > q) {
      if (s > r) add_relation(s, {p, q, r});
    } else if (q > p && q > s) {
      add_relation(q, {r, s, p});
    }
  }
  void add_relation(std::uint32_t v, const Relation& relation) {
    VertexLinks& links = links_[v];
    if (links.relation_count < kMostRelations) links.relations[links.relation_count++] = relation;
  }

  Source& source_;
  std::size_t vertex_count_;
  std::size_t triangle_count_;
  std::vector<VertexLinks> links_;
  std::vector<mesh::Triangle> triangles_;
  std::vector<Gate> gates_;
  std::vector<std::uint32_t> gate_from_;  // the latest from each vertex
  std::vector<std::uint32_t> valence_;
  std::uint32_t served_ = 0;
  std::uint32_t known_ = 0;
  Symbol last_ = Symbol::kBorder;
};

}  // namespace colossus::codec::predict
