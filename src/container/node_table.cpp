#include "container/node_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <tuple>

namespace colossus::container {
namespace {

using core::Status;

// Calls visit(name, type, count, member) for each field in the order of the file.
template <typename Row, typename Visit>
void for_each_field(Row& row, Visit visit) {
  visit("level", FieldType::kU32, 1, row.level);
  visit("center", FieldType::kI32, 3, row.center);
  visit("tetra_mask", FieldType::kU8, 1, row.tetra_mask);
  visit("flags", FieldType::kU8, 1, row.flags);
  visit("vertices", FieldType::kU32, 1, row.vertices);
  visit("triangles", FieldType::kU32, 1, row.triangles);
  visit("error", FieldType::kF64, 1, row.error);
  visit("bounds", FieldType::kF64, 6, row.bounds);
  visit("chunk_class", FieldType::kU32, 1, row.capacity_class);
  visit("chunk_index", FieldType::kU32, 1, row.chunk_index);
  visit("offset", FieldType::kU64, 1, row.offset);
  visit("stored_bytes", FieldType::kU64, 1, row.stored_bytes);
  visit("payload_bytes", FieldType::kU64, 1, row.payload_bytes);
  visit("checksum", FieldType::kU64, 1, row.checksum);
}

template <typename Found>
[[noreturn]] void fail_row(const Table& table, std::size_t row, const std::string& expected,
                           const Found& found) {
  core::fail(Status::kBadData, "{}: row {}: expected {}, found {}", table.place, row, expected, found);
}

// What holds in every scheme; more is told when a statue of the scheme is opened.
void check_place(const Table& table, std::size_t i, const NodeRow& row, const LatticeInfo& lattice) {
  const std::int32_t side = std::int32_t{1} << lattice.root_bits;
  for (const std::int32_t c : row.center)
    if (c < 0 || c > side) fail_row(table, i, fmt::format("a centre within 0 and {}", side), c);
}

void check_values(const Table& table, std::size_t i, const NodeRow& row) {
  if (!std::isfinite(row.error) || row.error < 0) fail_row(table, i, "an error of 0 or more", row.error);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = row.bounds[axis];
    const double high = row.bounds[axis + 3];
    if (!std::isfinite(low) || !std::isfinite(high) || low > high)
      fail_row(table, i, "finite bounds, minimum before maximum", fmt::format("{} and {}", low, high));
  }
}

void check_chunk(const Table& table, std::size_t i, const NodeRow& row) {
  if (row.payload_bytes > kMaxPayloadBytes)
    fail_row(table, i, fmt::format("a payload of at most {} bytes", kMaxPayloadBytes), row.payload_bytes);
  if (row.capacity_class != class_for(row.payload_bytes))
    fail_row(table, i,
             fmt::format("chunk class {} for {} bytes", class_for(row.payload_bytes), row.payload_bytes),
             row.capacity_class);
  if (row.stored_bytes == 0) fail_row(table, i, "a chunk of at least one byte", row.stored_bytes);
}

}  // namespace

std::vector<Field> node_fields() {
  std::vector<Field> fields;
  const NodeRow row;
  for_each_field(row, [&](const char* name, FieldType type, std::uint32_t count, const auto&) {
    fields.push_back({name, type, count});
  });
  return fields;
}

core::Bytes encode_rows(const std::vector<NodeRow>& rows) {
  core::ByteWriter writer;
  for (const NodeRow& row : rows)
    for_each_field(row, [&](const char*, FieldType, std::uint32_t, const auto& value) { writer.put(value); });
  return writer.take();
}

std::array<std::uint64_t, kCapacityClassCount> chunk_counts(std::span<const NodeRow> rows) {
  std::array<std::uint64_t, kCapacityClassCount> counts{};
  for (const NodeRow& row : rows) ++counts.at(row.capacity_class);
  return counts;
}

std::vector<NodeRow> decode_rows(const Table& table, const Metadata& metadata) {
  std::vector<const Field*> fields;
  for (const Field& field : node_fields())
    fields.push_back(&table.field(field.name, field.type, field.count));
  std::vector<NodeRow> rows(table.row_count);
  std::array<std::uint32_t, kCapacityClassCount> next_chunk{};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    NodeRow& row = rows[i];
    std::size_t f = 0;
    for_each_field(row, [&](const char*, FieldType, std::uint32_t, auto& value) {
      std::memcpy(&value, table.at(i, *fields[f++]), sizeof(value));
    });
    check_place(table, i, row, metadata.lattice);
    check_values(table, i, row);
    check_chunk(table, i, row);
    if (row.chunk_index != next_chunk[row.capacity_class]++)
      fail_row(table, i, fmt::format("chunk {} of its class", next_chunk[row.capacity_class] - 1),
               row.chunk_index);
    if (i > 0 && std::tie(rows[i - 1].level, rows[i - 1].center) >= std::tie(row.level, row.center))
      fail_row(table, i, "rows ordered by level and centre, none twice",
               fmt::format("level {} centre ({}, {}, {})", row.level, row.center[0], row.center[1],
                           row.center[2]));
  }
  return rows;
}

std::vector<FramePlace> stated_places(std::span<const NodeRow> rows) {
  std::vector<FramePlace> places;
  places.reserve(rows.size());
  for (const NodeRow& row : rows) places.push_back({row.offset, row.stored_bytes});
  return places;
}

std::optional<std::string> place_defect(const std::vector<FramePlace>& places, std::uint64_t file_bytes) {
  for (std::size_t i = 0; i < places.size(); ++i)
    if (const auto [offset, bytes] = places[i]; offset > file_bytes || bytes > file_bytes - offset)
      return fmt::format("row {}: expected a chunk within the file's {} bytes, found {} bytes at {}", i,
                         file_bytes, bytes, offset);
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto by_offset = [&](std::size_t a, std::size_t b) { return places[a].offset < places[b].offset; };
  // Our own writer stores chunks in row order; then there is nothing to sort.
  if (!std::is_sorted(order.begin(), order.end(), by_offset))
    std::sort(order.begin(), order.end(), by_offset);
  for (std::size_t i = 1; i < order.size(); ++i) {
    const FramePlace& before = places[order[i - 1]];
    if (places[order[i]].offset < before.offset + before.bytes)
      return fmt::format("row {}: expected a chunk behind that of row {}, which ends at {}, found {}",
                         order[i], order[i - 1], before.offset + before.bytes, places[order[i]].offset);
  }
  return std::nullopt;
}

}  // namespace colossus::container
