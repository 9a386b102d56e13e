// Private to this folder: the dataset /nodes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "container/chunk.hpp"
#include "container/schema.hpp"
#include "container/table.hpp"

namespace colossus::container {

std::vector<Field> node_fields();

// The rows' bytes, packed as node_fields() says.
core::Bytes encode_rows(const std::vector<NodeRow>& rows);

// Rows of the table, each checked by itself and against its neighbours: order, ranges by the metadata's
// scheme and lattice, chunk numbers; but not where the frames lie. Throws Error(kBadData) that names the row.
// chunk_counts() then gives the chunks per class.
std::vector<NodeRow> decode_rows(const Table& table, const Metadata& metadata);

// Chunks per capacity class.
std::array<std::uint64_t, kCapacityClassCount> chunk_counts(std::span<const NodeRow> rows);

// Where a row's chunk lies in the file.
struct FramePlace {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

// Where the rows say that it lies.
std::vector<FramePlace> stated_places(std::span<const NodeRow> rows);

// What is wrong with the places, one per row: the first row whose chunk does not lie within the file, or
// overlaps another one. Nothing when they are sound.
std::optional<std::string> place_defect(const std::vector<FramePlace>& places, std::uint64_t file_bytes);

}  // namespace colossus::container
