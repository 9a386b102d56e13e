#include "pipeline/nodes/store_node.hpp"

#include "container/chunk.hpp"
#include "pipeline/facts/catalog.hpp"

namespace colossus::pipeline::nodes {

void store_node(const run::Workspace& workspace, const codec::Codec& codec, const codec::Payload& payload,
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
