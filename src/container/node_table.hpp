// Private to this folder: the dataset /nodes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "container/chunk.hpp"
#include "container/schema.hpp"
#include "container/table.hpp"

namespace colossus::container {

std::vector<Field> node_fields();

// The rows' bytes, packed as node_fields() says.
core::Bytes encode_rows(const std::vector<NodeRow>& rows);

// Rows of the table, each checked by itself and against its neighbours: order, ranges by the metadata's
// scheme and lattice, places in the file, chunk numbers. Throws Error(kBadData) that names the row.
// chunk_counts() then gives the chunks per class.
std::vector<NodeRow> decode_rows(const Table& table, const Metadata& metadata, std::uint64_t file_bytes);

// Chunks per capacity class.
std::array<std::uint64_t, kCapacityClassCount> chunk_counts(const std::vector<NodeRow>& rows);

}  // namespace colossus::container
