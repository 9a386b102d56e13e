// A container of the blocks scheme opened for reading: its node table as an octree of cubes, and its nodes
// decoded one by one.
//
// A row is a cube with geometry, or with vertices that its children's vertices have as parents. Lengths are
// in lattice units; the conditions with sigma0 are in sides of the root cube, in the maximum norm.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "codec/coded/lattice_node.hpp"
#include "hierarchy/octree.hpp"
#include "reader/access/node_cache.hpp"
#include "reader/access/statue.hpp"

namespace colossus::reader::blocks {

class Statue final : public access::Statue {
 public:
  // Throws Error(kBadData) when the container is damaged, lacks sigma0 or block_size or has impossible ones,
  // or when a row's centre is no cube's centre of the row's level. What the rows say about each other is
  // checked by verify() only; everything here is total whatever they say. Not collective.
  explicit Statue(const std::filesystem::path& path, const access::StatueOptions& options = {});
  explicit Statue(container::ContainerReader container, const access::StatueOptions& options = {});

  access::Extraction extract(const access::CutRequest& request) const override;
  std::string_view name_of_parts() const override { return "cubes"; }
  double lattice_error() const override { return std::sqrt(3.0) / 2.0 * metadata().lattice.step; }
  std::string_view position_bits_meaning() const override { return "bits per side of the finest cubes"; }

  // Above 0. At level l a vertex is at most sigma0 * 2^-(l+1) from its parent, and edges are at most
  // sigma0 * 2^-l long.
  double sigma0() const { return sigma0_; }
  // Cubes along a block.
  int block_size() const { return block_size_; }
  int root_bits() const { return metadata().lattice.root_bits; }
  // The same lengths in lattice units; exact but for the rounding of sigma0 itself.
  double longest_parent_distance(int level) const { return std::ldexp(sigma0_, root_bits() - level - 1); }
  double longest_edge(int level) const { return std::ldexp(sigma0_, root_bits() - level); }

  hierarchy::CubeId cube(access::RowIndex row) const;
  // log n.
  access::RowIndex find(const hierarchy::CubeId& cube) const;
  access::RowIndex parent(access::RowIndex row) const;
  // By octant.
  std::array<access::RowIndex, 8> children(access::RowIndex row) const;

  // Reads, checks and decodes a node. Throws Error(kBadData) that names file, level and centre when its bytes
  // are damaged or are not what the row and the metadata say (attributes, parents, counts, positions within
  // the root cube), Error(kIo) when the device fails. That parents are in range is checked by who has the
  // parent. Keeps nothing. Thread-safe.
  codec::coded::CodedNode load(access::RowIndex index) const;
  // The same through the cache. Thread-safe.
  std::shared_ptr<const codec::coded::CodedNode> node(access::RowIndex row) const;

  // The world position of one on the lattice; the only rounding is that of the last addition where the step
  // is a power of two.
  std::array<double, 3> world(const std::array<double, 3>& position) const {
    const container::LatticeInfo& lattice = metadata().lattice;
    std::array<double, 3> result{};
    // + 0.0 turns a negative zero into a positive one: equal points are bit-equal.
    for (std::size_t axis = 0; axis < 3; ++axis)
      result[axis] = lattice.origin[axis] + lattice.step * position[axis] + 0.0;
    return result;
  }
  std::array<double, 3> world(const geometry::Point& p) const {
    return world(
        std::array<double, 3>{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
  }

 private:
  double sigma0_ = 0.0;
  int block_size_ = 0;
  mutable access::NodeCache<codec::coded::CodedNode> cache_;
};

}  // namespace colossus::reader::blocks
