#include "verify/diamonds/held_error.hpp"

#include <algorithm>
#include <numbers>

namespace colossus::verify::diamonds {
namespace {

double side(const geometry::Plane& plane, const measure::WorldPoint& q) {
  return plane.normal[0] * q[0] + plane.normal[1] * q[1] + plane.normal[2] * q[2] -
         static_cast<double>(plane.offset);
}

struct Root {
  std::uint8_t place = 0;
  hierarchy::Tetrahedron tetrahedron;
  std::array<geometry::Plane, 4> faces;
};

std::vector<Root> all_roots() {
  const hierarchy::Diamond diamond = hierarchy::Diamond::at(hierarchy::root_center());
  std::vector<Root> roots;
  for (std::uint8_t place = 0; place < diamond.place_count; ++place) {
    Root root{place, diamond.tetrahedra[place], {}};
    for (int corner = 0; corner < 4; ++corner)
      root.faces[static_cast<std::size_t>(corner)] = root.tetrahedron.face_plane(corner);
    roots.push_back(root);
  }
  return roots;
}

// Walks down to the tetrahedra of a cut that come near a point.
class Descent {
 public:
  Descent(const reader::diamonds::Statue& statue, std::uint32_t level, const measure::WorldPoint& q,
          const std::vector<bool>& is_damaged, bool counts_errors)
      : statue_(statue), level_(level), q_(q), is_damaged_(is_damaged), counts_errors_(counts_errors) {}

  measure::HeldError run() {
    const reader::access::RowIndex row = statue_.find(hierarchy::root_center());
    if (row == reader::access::kNoRow) return held_;
    static const std::vector<Root> roots = all_roots();
    for (const Root& root : roots)
      if (std::all_of(root.faces.begin(), root.faces.end(),
                      [&](const geometry::Plane& face) { return side(face, q_) >= -reach(row); }))
        visit({row, root.place}, root.tetrahedron);
    return held_;
  }

 private:
  // As far as plane values tell, whose normals are up to sqrt(2) long.
  double reach(reader::access::RowIndex row) const {
    const double error = counts_errors_ ? statue_.rows()[row].error / statue_.lattice().step : 0.0;
    return std::numbers::sqrt2 * (error + measure::kRounding);
  }

  void visit(reader::diamonds::TetrahedronRef ref, const hierarchy::Tetrahedron& tetrahedron) {
    if (statue_.is_leaf(ref.row) || statue_.rows()[ref.row].level >= level_) {
      consider(statue_, ref.row, is_damaged_, held_);
      return;
    }
    const double at = side(tetrahedron.bisector(), q_);
    for (int end = 0; end < 2; ++end) {
      const reader::diamonds::TetrahedronRef half = statue_.child(ref, end);
      if (half.exists() && (end == 0 ? at : -at) >= -reach(half.row)) visit(half, tetrahedron.child(end));
    }
  }

  const reader::diamonds::Statue& statue_;
  const std::uint32_t level_;
  const measure::WorldPoint& q_;
  const std::vector<bool>& is_damaged_;
  const bool counts_errors_;
  measure::HeldError held_;
};

}  // namespace

measure::HeldError held_error(const reader::diamonds::Statue& statue, std::uint32_t level,
                              const measure::WorldPoint& p, const std::vector<bool>& is_damaged) {
  const measure::WorldPoint q = measure::lattice_position(statue.metadata().lattice, p);
  const measure::HeldError held = Descent(statue, level, q, is_damaged, false).run();
  return held.row != reader::access::kNoRow ? held : Descent(statue, level, q, is_damaged, true).run();
}

}  // namespace colossus::verify::diamonds
