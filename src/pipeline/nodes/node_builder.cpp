#include "pipeline/nodes/node_builder.hpp"

#include <algorithm>
#include <limits>

#include "codec/node_codec.hpp"
#include "container/chunk.hpp"
#include "geometry/vector.hpp"
#include "pipeline/facts/catalog.hpp"

namespace colossus::pipeline::nodes {

double area_of(std::span<const geometry::Point> positions, std::span<const mesh::Triangle> triangles) {
  double doubled = 0.0;
  for (const mesh::Triangle& t : triangles) {
    const geometry::Point &p = positions[t[0]], &q = positions[t[1]], &r = positions[t[2]];
    const geometry::Vec3 n = geometry::cross(geometry::to_vec3(q) - geometry::to_vec3(p),
                                             geometry::to_vec3(r) - geometry::to_vec3(p));
    doubled += geometry::length(n);
  }
  return 0.5 * doubled;
}

NodeBuilder::NodeBuilder(const StoredLattice& lattice, std::uint32_t level, const geometry::Point& center,
                         const std::array<std::int64_t, 3>& empty_at)
    : lattice_(lattice), empty_at_(empty_at) {
  low_.fill(std::numeric_limits<std::int64_t>::max());
  high_.fill(std::numeric_limits<std::int64_t>::min());
  node_.row.level = level;
  node_.row.center = {center.x, center.y, center.z};
}

void NodeBuilder::add_position(const std::array<std::int64_t, 3>& position) {
  ++positions_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low_[axis] = std::min(low_[axis], position[axis]);
    high_[axis] = std::max(high_[axis], position[axis]);
  }
}

void NodeBuilder::count_angles(const mesh::Mesh& mesh) {
  const simplify::AngleCounts angles = simplify::count_small_angles(mesh);
  node_.statistics.angles.below_5_degrees += angles.below_5_degrees;
  node_.statistics.angles.below_15_degrees += angles.below_15_degrees;
  node_.statistics.angles.below_30_degrees += angles.below_30_degrees;
}

facts::FinishedNode NodeBuilder::store(const run::Workspace& workspace, const codec::coded::CodedNode& mesh,
                                       const codec::Codec& codec) && {
  container::NodeRow& row = node_.row;
  for (const codec::coded::CodedPart& part : mesh.parts) {
    row.tetra_mask = static_cast<std::uint8_t>(row.tetra_mask | 1U << part.place);
    row.vertices += static_cast<std::uint32_t>(part.positions.size());
    row.triangles += static_cast<std::uint32_t>(part.triangles.size());
  }
  COLOSSUS_CHECK(positions_ == row.vertices, "{} positions of {} vertices", positions_, row.vertices);
  if (row.vertices == 0) add_position(empty_at_);
  set_bounds();
  store_chunk(workspace, codec, codec::encode(mesh, codec), node_);
  return node_;
}

void NodeBuilder::set_bounds() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node_.row.bounds[axis] = lattice_.origin[axis] + lattice_.step * static_cast<double>(low_[axis]);
    node_.row.bounds[axis + 3] = lattice_.origin[axis] + lattice_.step * static_cast<double>(high_[axis]);
  }
}

void store_chunk(const run::Workspace& workspace, const codec::Codec& codec, const codec::Payload& payload,
                 facts::FinishedNode& node) {
  const container::PackedChunk chunk = container::pack_chunk(payload.bytes, {codec.zstd_level, payload.cuts});
  container::NodeRow& row = node.row;
  row.capacity_class = chunk.capacity_class;
  row.payload_bytes = chunk.payload_bytes;
  row.stored_bytes = chunk.frame.size();
  row.checksum = chunk.checksum;
  // The first piece is the head.
  for (std::size_t i = 0; i < codec::coded::kComponentCount; ++i)
    node.component_bytes[i] = chunk.piece_bytes[i + 1];
  node.chunk =
      workspace.writer.append_kept(static_cast<std::uint32_t>(facts::RecordKind::kChunk), chunk.frame);
}

}  // namespace colossus::pipeline::nodes
