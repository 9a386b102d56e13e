// Private to this folder: tables of fixed-size rows, each a contiguous one-dimensional dataset of a packed
// little-endian compound type, with the XXH3-64 of its bytes in the attribute "xxh3". Their bytes are read
// with plain reads, so HDF5 converts nothing and a foreign type can do no harm; where another program has
// copied a table into another layout, HDF5 reads them in the file's own type, so that it converts nothing
// either.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "container/hdf5/support.hpp"
#include "core/bytes.hpp"
#include "core/file.hpp"

namespace colossus::container {

enum class FieldType { kU8, kU32, kI32, kU64, kF64, kText };

struct Field {
  std::string name;
  FieldType type = FieldType::kU8;
  std::uint32_t count = 1;  // elements of an array, or bytes of a zero-padded text; 1 is a scalar
  std::size_t offset = 0;   // in the row; set by pack_fields() or read_table()
};

// Sets the offsets of fields without gaps and returns the bytes of a row.
std::size_t pack_fields(std::vector<Field>& fields);

std::size_t field_bytes(const Field& field);

// Creates and allocates the dataset `name` in `file`, and its attribute. The rows are written by
// write_table().
hdf5::Handle create_table(const hdf5::Blame& blame, hid_t file, const std::string& name,
                          std::vector<Field> fields, std::uint64_t row_count);

// Writes all rows (packed as the fields say) and their checksum.
void write_table(const hdf5::Blame& blame, const hdf5::Handle& table, std::span<const std::byte> rows);

struct Table {
  std::string place;  // file and dataset, for messages
  std::vector<Field> fields;
  std::size_t row_bytes = 0;
  std::uint64_t row_count = 0;
  std::uint64_t offset = 0;  // of the rows in the file; 0 where they do not lie in it as they are
  core::Bytes rows;

  // The field of that name; throws Error(kBadData) when it is missing or of another type. A text may have any
  // size, everything else must have `count` elements.
  const Field& field(const std::string& name, FieldType type, std::uint32_t count = 1) const;
  const std::byte* at(std::uint64_t row, const Field& field) const {
    return rows.data() + row * row_bytes + field.offset;
  }
  std::string text(std::uint64_t row, const Field& field) const;
  std::uint64_t u64(std::uint64_t row, const Field& field) const;
};

// Reads the dataset `name` of the container's group. Throws Error(kBadData) unless it is a table whose bytes
// match their checksum. Allocates no more than the file's size; for a table that is not contiguous (which
// only other programs write) sixteen times that, or 64 MiB, and what its filters decode to.
Table read_table(const hdf5::Blame& blame, hid_t group, const core::File& bytes, const std::string& name);

// Attributes of the three kinds in use. `place` names the object in messages; reading throws Error(kBadData)
// when the attribute is missing or of another type or size.
void write_attribute(const hdf5::Blame& blame, hid_t object, const std::string& name, FieldType type,
                     std::uint32_t count, const void* values);
void read_attribute(const hdf5::Blame& blame, hid_t object, const std::string& place, const std::string& name,
                    FieldType type, std::uint32_t count, void* values);
std::string read_text_attribute(const hdf5::Blame& blame, hid_t object, const std::string& place,
                                const std::string& name);

}  // namespace colossus::container
