// A container opened for reading: its node table as a hierarchy, and its nodes decoded one by one.
//
// A row is a diamond with geometry in at least one of its tetrahedra; a row is a leaf or it is split. A
// tetrahedron exists when its diamond is the root or the tetrahedron that it is a half of exists in a split
// diamond. Diamonds without any geometry have no row, and neither has anything below them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "codec/coded/weights.hpp"
#include "container/reader.hpp"
#include "geometry/lattice.hpp"
#include "hierarchy/diamond.hpp"
#include "reader/access/node_cache.hpp"
#include "reader/access/statue.hpp"

namespace colossus::reader::diamonds {

inline constexpr std::size_t kMaxPlaces = 8;

// A tetrahedron by its row and its place in the row's diamond.
struct TetrahedronRef {
  access::RowIndex row = access::kNoRow;
  std::uint8_t place = 0;
  bool exists() const { return row != access::kNoRow; }
  friend auto operator<=>(const TetrahedronRef&, const TetrahedronRef&) = default;
};

// A decoded node: for each entry of mesh.parts the corners are diamond.tetrahedra[place].
struct Node {
  hierarchy::Diamond diamond;
  codec::coded::CodedNode mesh;
  std::size_t memory_bytes() const { return sizeof(diamond) + codec::coded::memory_bytes(mesh); }
};

class Statue final : public access::Statue {
 public:
  // Throws Error(kBadData) when the container is damaged, or when a row's centre is no diamond's centre of
  // the row's level, a place of its mask lies outside the root cube, or its error or bounds are not finite.
  // What the rows say about each other is checked by verify() only; everything here is total whatever they
  // say. Memory: some 250 bytes per row. Cost: about 10 microseconds per row. Not collective.
  explicit Statue(const std::filesystem::path& path, const access::StatueOptions& options = {});
  explicit Statue(container::ContainerReader container, const access::StatueOptions& options = {});

  const geometry::Lattice& lattice() const { return lattice_; }
  access::Extraction extract(const access::CutRequest& request) const override;
  std::string_view name_of_parts() const override { return "tetrahedra"; }
  double lattice_error() const override { return lattice_.input_error(); }
  std::string_view position_bits_meaning() const override { return "bits per weight"; }

  hierarchy::Point center(access::RowIndex row) const;
  // The row of the diamond with this centre. log n.
  access::RowIndex find(const hierarchy::Point& center) const;
  // Rows of the diamonds whose splits make this one's tetrahedra; fewer than these diamonds where some have
  // no row.
  std::vector<access::RowIndex> parents(access::RowIndex row) const;
  // The half with end 0 or 1 of the long edge, when its diamond has a row. None for leaves.
  TetrahedronRef child(TetrahedronRef tetrahedron, int end) const;
  // The tetrahedron that this one is a half of, when its diamond has a row and is split.
  TetrahedronRef parent(TetrahedronRef tetrahedron) const;
  // Inside the root cube, and made by a split of a row (or of the root row's level).
  bool exists(TetrahedronRef tetrahedron) const;
  bool has_geometry(TetrahedronRef tetrahedron) const {
    return (rows()[tetrahedron.row].tetra_mask >> tetrahedron.place & 1) != 0;
  }
  // Bit p: the tetrahedron at place p or one below it carries geometry. Small parts vanish at coarse levels,
  // so this can be more than the row's mask.
  std::uint8_t places_with_geometry_below(access::RowIndex row) const { return below_[row]; }

  // Reads, checks and decodes a node. Throws Error(kBadData) that names file, level and centre when its bytes
  // are damaged or are not what the row and the metadata say (places, attributes, position bits, counts),
  // Error(kIo) when the device fails. Keeps nothing. Thread-safe.
  Node load(access::RowIndex index) const;
  // The same through the cache. Thread-safe.
  std::shared_ptr<const Node> node(access::RowIndex row) const;
  // Triangles per place as stored (with those that have two equal positions). The row says it for a node with
  // one tetrahedron; others are decoded once and remembered (36 bytes a node). Throws like load().
  // Thread-safe.
  std::array<std::uint32_t, kMaxPlaces> triangle_counts(access::RowIndex row) const;

  // The world position of a decoded one; the only rounding is that of the last addition.
  std::array<double, 3> world(const codec::coded::ScaledPosition& position) const {
    std::array<double, 3> result{};
    // + 0.0 turns a negative zero into a positive one: equal points are bit-equal.
    for (std::size_t axis = 0; axis < 3; ++axis)
      result[axis] = lattice_.origin[axis] + scaled_step_ * static_cast<double>(position[axis]) + 0.0;
    return result;
  }

 private:
  void check_row(access::RowIndex index) const;
  void link_children(access::RowIndex row);

  geometry::Lattice lattice_;
  double scaled_step_ = 1.0;
  std::vector<std::array<TetrahedronRef, 2 * kMaxPlaces>> children_;  // per row: 2 * place + end
  std::vector<std::array<TetrahedronRef, kMaxPlaces>> parents_;
  std::vector<std::uint8_t> below_;

  mutable access::NodeCache<Node> cache_;
  mutable std::mutex counts_mutex_;  // guards what follows
  mutable std::unordered_map<access::RowIndex, std::array<std::uint32_t, kMaxPlaces>> counts_;
};

}  // namespace colossus::reader::diamonds
