// Makes a node's row and chunk of its coded mesh: what no scheme does in a way of its own.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "codec/payload.hpp"
#include "container/schema.hpp"
#include "geometry/point.hpp"
#include "mesh/mesh.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::nodes {

// Integers to world positions as readers take them, so that bounds are what a reader computes, to the bit.
struct StoredLattice {
  std::array<double, 3> origin{};
  double step = 0.0;
};

// Sum over the triangles, square units of the positions'.
double area_of(std::span<const geometry::Point> positions, std::span<const mesh::Triangle> triangles);

// Packs a payload, appends it to scratch as the node's chunk, and says so in the node. Not collective.
void store_chunk(const run::Workspace& workspace, const codec::Codec& codec, const codec::Payload& payload,
                 facts::FinishedNode& node);

class NodeBuilder {
 public:
  // `center` is the node's in the node table, in units of the container's lattice. A node without vertices
  // has its bounds there: `empty_at` is the same place on the stored lattice.
  NodeBuilder(const StoredLattice& lattice, std::uint32_t level, const geometry::Point& center,
              const std::array<std::int64_t, 3>& empty_at);

  NodeBuilder(const NodeBuilder&) = delete;
  NodeBuilder& operator=(const NodeBuilder&) = delete;

  // What only the scheme knows: the row's error and flags, statistics, area, displacement.
  facts::FinishedNode& node() { return node_; }

  // Each vertex of the mesh, where it will be stored, on the stored lattice.
  void add_position(const std::array<std::int64_t, 3>& position);
  // The angles of a mesh that goes into the node, before it is quantised.
  void count_angles(const mesh::Mesh& mesh);

  // Completes the row with the mesh's counts and places, and with bounds; encodes and packs the mesh, and
  // appends the chunk to scratch; once. The mesh is as codec::encode() wants it. Not collective.
  facts::FinishedNode store(const run::Workspace& workspace, const codec::coded::CodedNode& mesh,
                            const codec::Codec& codec) &&;

 private:
  void set_bounds();

  StoredLattice lattice_;
  facts::FinishedNode node_;
  std::uint64_t positions_ = 0;  // that were added
  std::array<std::int64_t, 3> empty_at_;
  std::array<std::int64_t, 3> low_;
  std::array<std::int64_t, 3> high_;
};

}  // namespace colossus::pipeline::nodes
