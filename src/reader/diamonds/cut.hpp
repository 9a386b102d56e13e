// Cuts: which diamonds are split. The surface of a cut consists of the tetrahedra that exist in it and are
// not split.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reader/access/eye.hpp"
#include "reader/diamonds/statue.hpp"

namespace colossus::reader::diamonds {

// A set of split rows, closed under Statue::parents(). Then its tetrahedra are conforming, and the surface is
// closed where the input was.
struct Cut {
  std::vector<bool> is_split;  // per row
  std::string warning;         // why the cut is not quite what was asked for; empty when it is

  // Bit p: the tetrahedron at place p exists in the cut, is not split, and carries geometry.
  std::uint8_t active_places(const Statue& statue, access::RowIndex row) const;
  bool is_active(const Statue& statue, TetrahedronRef tetrahedron) const {
    return (active_places(statue, tetrahedron.row) >> tetrahedron.place & 1) != 0;
  }
  // The row is in the cut: such a tetrahedron, or one below it, carries geometry.
  bool has_row(const Statue& statue, access::RowIndex row) const;
};

// Every tetrahedron of this level, or the leaf above it; beyond the deepest level that is the finest cut.
Cut cut_at_level(const Statue& statue, std::uint32_t level);

// The coarsest cut all of whose nodes have an error of at most `error` (world units). Leaves whose own error
// is larger stay, with a warning.
Cut cut_with_error(const Statue& statue, double error);

// One order of refinement, the same for every N: from the root on, of all nodes in the cut that are not
// leaves, the one with the largest error is split, ties by level, then centre; parents that are not yet split
// go first, each a step of its own. The cut is what the last step leaves before the first that exceeds N
// triangles; the root when that has more, with a warning. Triangles are counted as stored, so the extracted
// cut never has more. Decodes the nodes it meets (Statue::triangle_counts()); throws like Statue::load().
Cut cut_with_triangles(const Statue& statue, std::uint64_t triangles);

// The view-dependent cut: a diamond in the cut is split while the distance of the eye to its bounds, in the
// maximum norm, is less than kappa times the side of a cube at its level (root side / 2^(level / 3)). Every
// kappa above 0 gives a conforming cut; others, and eyes that are not finite, throw Error(kUsage).
Cut cut_at_eye(const Statue& statue, const access::Eye& eye);

// How many tetrahedra of each level the cut draws, from the root on.
std::vector<std::uint64_t> parts_by_level(const Statue& statue, const Cut& cut);

// Triangles of a cut, as stored. Throws like Statue::load().
std::uint64_t triangle_count(const Statue& statue, const Cut& cut);

}  // namespace colossus::reader::diamonds
