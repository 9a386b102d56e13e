// Private to this folder: the texts by which a container explains itself, as attributes that h5dump -A
// prints. They say in short what schemas/container.md says; which names are described is not part of the
// schema.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "container/hdf5/support.hpp"
#include "container/schema.hpp"
#include "container/table.hpp"

namespace colossus::container {

// Makes room for more attributes in an object's header than HDF5 would put there: a simpler place than the
// heap and the B-tree that it uses else. For the properties that the object is created with.
void keep_attributes_in_header(const hdf5::Blame& blame, hid_t properties);

void write_text_attribute(const hdf5::Blame& blame, hid_t object, const std::string& name,
                          const std::string& text);

// What a field of a table means, or a row of the tables of names and values; empty for what is not known.
std::string_view field_meaning(std::string_view table, std::string_view field);
std::string_view row_meaning(std::string_view table, std::string_view row);

// Title, description and units of an object: "/", "lattice", "chunks", or a table.
void describe(const hdf5::Blame& blame, hid_t object, std::string_view name);
// Those of a table, its fields (attributes field_<name>) and rows (row_<name>); of rows that are not known
// here what `meanings` says.
void describe_table(const hdf5::Blame& blame, hid_t object, std::string_view table,
                    const std::vector<Field>& fields, const std::vector<std::string>& rows = {},
                    const std::vector<NamedText>& meanings = {});
// Of a dataset of chunks.
void describe_chunks(const hdf5::Blame& blame, hid_t object, std::uint32_t capacity_class);
// Who made the file, and where it is described.
void describe_file(const hdf5::Blame& blame, hid_t root);

}  // namespace colossus::container
