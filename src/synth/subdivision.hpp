// How synth cuts a base mesh into any number of triangles: which vertex lies where, and what the triangles'
// corners are. Positions play no part but in the choice of what is cut finer. Internal to
// src/synth.
//
// With k * k * F <= N < (k + 1) * (k + 1) * F for F base triangles, some of these are fine, cut into
// (k + 1) x (k + 1), and the others into k x k. An edge has k segments, or k + 1 if it is long, and it is
// long if a triangle at it is fine. So both sides of an edge agree on it, and one rule serves borders and
// non-manifold edges too. A triangle with one to three long edges that is not fine keeps the inner vertices
// of k x k; only the strip along a long edge holds one triangle more.
//
// Vertices are numbered: those of the base, then those on each edge from its lower end, then those inside
// each triangle, row by row from its first corner. Triangles are numbered by base triangle.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "synth/welded_base.hpp"

namespace colossus::synth {

// Memory: some 30 bytes per triangle of the base.
class SynthSubdivision {
 public:
  // Keeps a reference to `mesh`. The number of triangles is the base's if `triangles` is less. Else it is
  // `triangles` or one less as long as enough edges are not long: what is left when no more triangle can be
  // fine is made up by edges that are long alone, at a triangle for each side. Without enough of them (a tiny
  // base, or almost every triangle fine) it is off by at most k, or less than m, should all such edges have
  // at least m > 2 triangles.
  // Throws core::Error, kUsage, when more than kMaxSynthVertices were needed; `name` is for the message.
  SynthSubdivision(const WeldedBase& mesh, std::uint64_t triangles, const std::string& name);

  std::uint64_t vertex_count() const { return vertex_count_; }
  std::uint64_t triangle_count() const { return first_part_.back(); }

  // Vertices below this number are the base's, below the next on edges, and the rest inside triangles.
  std::uint64_t first_on_edges() const { return first_on_edge_.front(); }
  std::uint64_t first_inside() const { return first_on_edge_.back(); }

  // `step` of `segments` from the lower end.
  struct OnEdge {
    std::uint32_t edge, step, segments;
  };
  // In row 2..segments-1 from the first corner, column 1..row-1 from the side of the second: the weights of
  // the corners are segments - row, row - column and column.
  struct Inside {
    std::uint32_t triangle, row, column, segments;
  };
  // `near` speeds up calls for vertices near each other: an edge or triangle to look at first, 0 to begin
  // with; becomes the one found.
  OnEdge on_edge(std::uint32_t vertex, std::uint32_t& near) const;
  Inside inside(std::uint32_t vertex, std::uint32_t& near) const;

  // The corners of consecutive triangles from number `first` on, each in the sense of its base triangle.
  void triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const;
  // The same of the triangles with these numbers, as many as corners; fastest where the numbers ascend.
  void triangles_at(std::span<const std::uint64_t> numbers,
                    std::span<std::array<std::uint32_t, 3>> corners) const;

 private:
  // Which edges are long, and which triangles fine.
  struct Choice {
    std::vector<bool> is_long, is_fine;
  };
  // What is needed of a base triangle to tell its parts.
  struct Frame {
    std::array<std::uint32_t, 3> corners;
    std::array<std::uint32_t, 3> segments;       // of the edge from corner i to i + 1
    std::array<std::uint32_t, 3> first_on_edge;  // vertex
    std::array<bool, 3> ascends;                 // whether the edge's lower end is corner i
    std::uint32_t first_inside;                  // vertex
    std::uint64_t parts;

    // The vertex `step` segments from corner `side` towards the next.
    std::uint32_t vertex_on_side(std::size_t side, std::uint64_t step) const;
    std::uint32_t vertex_inside(std::uint64_t row, std::uint64_t column) const;  // as in Inside
  };
  Choice choose(std::uint64_t missing) const;
  void number(const Choice& choice, std::uint64_t wanted, const std::string& name);
  std::uint64_t triangle_of(std::uint64_t part) const;  // the base triangle
  Frame frame_of(std::uint64_t triangle) const;
  std::array<std::uint32_t, 3> part(const Frame& frame, std::uint64_t index) const;
  std::array<std::uint32_t, 3> mixed_part(const Frame& frame, std::uint64_t index) const;
  std::array<std::uint32_t, 3> strip_part(const Frame& frame, std::size_t side, std::uint64_t index) const;
  std::array<std::uint32_t, 3> small_part(const Frame& frame, std::uint64_t index) const;

  const WeldedBase& mesh_;
  std::uint64_t k_ = 1;
  std::uint64_t vertex_count_ = 0;
  std::vector<std::uint32_t> first_on_edge_;  // vertex, per edge, and the end
  std::vector<std::uint32_t> first_inside_;   // vertex, per triangle, and the end
  std::vector<std::uint64_t> first_part_;     // per triangle, and the end
  // Per 2^shift_ parts the triangle of the first; each of the others is in this one or the next, since
  // 2^shift_ is at most k * k.
  unsigned shift_ = 0;
  std::vector<std::uint32_t> triangle_of_part_;
};

}  // namespace colossus::synth
