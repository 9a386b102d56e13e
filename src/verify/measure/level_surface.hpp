// Private to this folder: the surface of a level's uniform cut, and the rows that its triangles come from.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reader/access/statue.hpp"
#include "verify/measure/distance.hpp"

namespace colossus::verify::measure {

// Some 12 bytes per triangle and 24 per vertex of the cut.
class LevelSurface {
 public:
  // Triangles are of these points. Leaves stay for the finer levels; they come before the nodes of this level
  // that do not.
  void add(reader::access::RowIndex row, std::span<const WorldPoint> points,
           std::span<const mesh::Triangle> triangles, bool is_leaf);
  // Completes the cut: nothing more is added to this level.
  void finish();
  // Leaves what stays.
  void start_next();

  Surface surface() const { return {whole_.points, whole_.triangles}; }
  bool is_empty() const { return whole_.triangles.empty(); }
  std::size_t part_count() const { return whole_.parts.size(); }
  // What one row has added.
  reader::access::RowIndex row(std::size_t part) const { return whole_.parts[part].row; }
  Surface surface(std::size_t part) const;
  // Of a triangle of surface(). log n.
  reader::access::RowIndex row_of(std::uint32_t triangle) const;

 private:
  struct Part {
    std::size_t first_triangle = 0;
    reader::access::RowIndex row = reader::access::kNoRow;
  };
  struct Parts {
    std::vector<WorldPoint> points;
    std::vector<mesh::Triangle> triangles;
    std::vector<Part> parts;
    void add(reader::access::RowIndex row, std::span<const WorldPoint> more,
             std::span<const mesh::Triangle> of_more);
  };
  Parts whole_;    // the leaves, and once finished all
  Parts passing_;  // of this level only
  std::size_t staying_points_ = 0;
  std::size_t staying_triangles_ = 0;
  std::size_t staying_parts_ = 0;
};

}  // namespace colossus::verify::measure
