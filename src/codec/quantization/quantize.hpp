// From lattice positions to barycentric weights (Balsa Rodríguez et al. 2013, section 4.3), without its
// epsilons: the plane
// values are exact integers, so a vertex on a face gets weight 0 for the opposite corner, and both sides of a
// face get the same weights for the same point, with no case distinction.
#pragma once

#include "codec/coded/weights.hpp"

namespace colossus::codec::quantization {

// The four face planes of a tetrahedron with the side of the opposite corner.
class Barycentric {
 public:
  explicit Barycentric(const hierarchy::Tetrahedron& tetrahedron);

  // floor(lambda_i * 2^bits), the remainder to the largest fractions, ties by corner order; a corner with
  // lambda_i > 0 gets at least 1, from the largest weight. So a weight is 0 exactly on the opposite face, and
  // vertices of different tetrahedra coincide only on common faces. `p` must lie in the closed tetrahedron;
  // anything else is a bug and ends the program.
  coded::Weights weights(const geometry::Point& p, int bits) const;

 private:
  std::array<geometry::Plane, 4> planes_;
  std::array<std::int64_t, 4> heights_;
  std::int64_t greatest_height_ = 0;
};

struct Quantized {
  coded::CodedPart tetrahedron;
  // Upper bound of the distance, in lattice units, by which storing moved the surface, in both directions:
  // the largest movement of a vertex, and how far the widest fin that was dropped reached.
  double displacement = 0.0;
  // False: no two vertices have equal weights. True: some have, or had on the way.
  bool has_shared_places = false;
};

struct QuantizeOptions {
  int position_bits = coded::kDefaultPositionBits;
  bool normals = false;
  bool colors = false;
};

// Triangles whose corners fall together are dropped and these vertices merged; where nothing else would be
// left of the surface, two triangles back to back stay for them (codec/quantization/lost.hpp). Of two
// opposite triangles over the same vertices both go where they are a fin thinner than a unit of weight, else both stay, apart
// from the rest. Vertices that fall together otherwise are a pinch, which is legal unless edges do so too:
// then vertices step aside or edges are split, so that quantisation makes no edge non-manifold. Triangles
// keep their order, vertices come out in order of first use. A mesh that is not empty does not come out
// empty.
Quantized quantize(mesh::Mesh mesh, const hierarchy::Tetrahedron& tetrahedron, std::uint8_t place,
                   const QuantizeOptions& options);

}  // namespace colossus::codec::quantization
