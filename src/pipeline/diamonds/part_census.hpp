// What a container says of the edges and the area of a tetrahedron's mesh, so that its readers can check it.
#pragma once

#include "codec/quantization/quantize.hpp"

namespace colossus::pipeline::diamonds {

// Edges by place, as a reader welds them.
struct PartCensus {
  std::uint64_t inconsistent_edges = 0;  // two triangles, both in the same direction
  // Of edges that lie in no face of the tetrahedron:
  std::uint64_t border_edges = 0;       // one triangle
  std::uint64_t nonmanifold_edges = 0;  // more than two
};

// Where no vertices share a place, all but edges with as many triangles on either side are told from these by
// a sum: each edge, with a sign for its direction, has a weight. The sum has 128 bits of products of random
// numbers, and it is zero for others once in about 2^64. Only of the finest level, `is_finest`, edges with
// two triangles on either side are told from those with one. A clipped mesh may have them although the input
// has none: where cuts of two sheets fall together. Linear.
PartCensus take_census(const codec::quantization::Quantized& stored, bool is_finest);

// Sum over the triangles, square lattice units.
double area_of(const codec::coded::CodedPart& part, const hierarchy::Tetrahedron& tetrahedron,
               int position_bits);

}  // namespace colossus::pipeline::diamonds
