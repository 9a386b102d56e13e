#include "container/table.hpp"

#include <algorithm>
#include <cstring>

#include "container/descriptions.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using core::Status;
using hdf5::Blame;
using hdf5::Handle;

constexpr char kChecksumName[] = "xxh3";
constexpr std::uint32_t kMaxTextBytes = 1 << 16;
// What a table that is not contiguous may take in memory: of its file's size, or this.
constexpr std::uint64_t kMostExpansion = 16;
constexpr std::uint64_t kMostFilteredBytes = std::uint64_t{64} << 20;

hid_t scalar_type(FieldType type) {
  switch (type) {
    case FieldType::kU8:
      return H5T_STD_U8LE;
    case FieldType::kU32:
      return H5T_STD_U32LE;
    case FieldType::kI32:
      return H5T_STD_I32LE;
    case FieldType::kU64:
      return H5T_STD_U64LE;
    case FieldType::kF64:
      return H5T_IEEE_F64LE;
    case FieldType::kText:
      break;
  }
  COLOSSUS_CHECK(false, "a text has no scalar type");
}

const char* type_name(FieldType type) {
  switch (type) {
    case FieldType::kU8:
      return "u8";
    case FieldType::kU32:
      return "u32";
    case FieldType::kI32:
      return "i32";
    case FieldType::kU64:
      return "u64";
    case FieldType::kF64:
      return "f64";
    case FieldType::kText:
      return "text";
  }
  return "?";
}

std::string describe(FieldType type, std::uint32_t count) {
  return count == 1 ? type_name(type) : fmt::format("{}[{}]", type_name(type), count);
}

Handle make_type(const Blame& blame, const Field& field) {
  const std::string what = "cannot make the type of " + field.name;
  if (field.type == FieldType::kText) {
    Handle type = blame.own(H5Tcopy(H5T_C_S1), &H5Tclose, what);
    blame.check(H5Tset_size(type.get(), field.count), what);
    blame.check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), what);
    blame.check(H5Tset_cset(type.get(), H5T_CSET_UTF8), what);
    return type;
  }
  if (field.count == 1) return blame.own(H5Tcopy(scalar_type(field.type)), &H5Tclose, what);
  const hsize_t count = field.count;
  return blame.own(H5Tarray_create2(scalar_type(field.type), 1, &count), &H5Tclose, what);
}

// Type and count of a member's HDF5 type; false when it is none of ours (variable length, other byte order
// ...).
bool recognise(hid_t type, Field& field) {
  const H5T_class_t kind = H5Tget_class(type);
  if (kind == H5T_STRING) {
    const std::size_t size = H5Tget_size(type);
    if (H5Tis_variable_str(type) != 0 || size == 0 || size > kMaxTextBytes) return false;
    field.type = FieldType::kText;
    field.count = static_cast<std::uint32_t>(size);
    return true;
  }
  Handle base;
  field.count = 1;
  if (kind == H5T_ARRAY) {
    hsize_t count = 0;
    if (H5Tget_array_ndims(type) != 1 || H5Tget_array_dims2(type, &count) < 0 || count > kMaxTextBytes)
      return false;
    field.count = static_cast<std::uint32_t>(count);
    base = Handle(H5Tget_super(type), &H5Tclose);
    type = base.get();
  }
  for (const FieldType candidate :
       {FieldType::kU8, FieldType::kU32, FieldType::kI32, FieldType::kU64, FieldType::kF64}) {
    if (H5Tequal(type, scalar_type(candidate)) > 0) {
      field.type = candidate;
      return true;
    }
  }
  return false;
}

void read_fields(const Blame& blame, hid_t type, Table& table) {
  if (H5Tget_class(type) != H5T_COMPOUND)
    core::fail(blame.status, "{}: expected a compound type", table.place);
  table.row_bytes = H5Tget_size(type);
  const int count = H5Tget_nmembers(type);
  for (unsigned i = 0; static_cast<int>(i) < count; ++i) {
    Field field;
    char* name = H5Tget_member_name(type, i);
    if (name == nullptr) blame.fail(fmt::format("cannot read the name of field {}", i));
    field.name = name;
    H5free_memory(name);
    field.offset = H5Tget_member_offset(type, i);
    const Handle member =
        blame.own(H5Tget_member_type(type, i), &H5Tclose, "cannot read the type of " + field.name);
    if (!recognise(member.get(), field))
      core::fail(blame.status,
                 "{}: field {}: expected a little-endian number, an array of them or a fixed text",
                 table.place, field.name);
    if (field.offset > table.row_bytes || field_bytes(field) > table.row_bytes - field.offset)
      core::fail(blame.status, "{}: field {}: expected it within the row's {} bytes, found {} bytes at {}",
                 table.place, field.name, table.row_bytes, field_bytes(field), field.offset);
    table.fields.push_back(std::move(field));
  }
}

// Only a hard link: others may lead to other files.
Handle open_dataset(const Blame& blame, hid_t group, const Table& table, const std::string& name) {
  H5L_info_t link{};
  if (H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(blame.status, "{}: expected a dataset, found none", table.place);
  return blame.own(H5Dopen2(group, name.c_str(), H5P_DEFAULT), &H5Dclose, "cannot open dataset /" + name);
}

// As our writer lays them out: the bytes are where they are. Nothing is allocated before it is known that
// they are there.
void read_contiguous(const Blame& blame, hid_t dataset, const core::File& bytes, Table& table) {
  const haddr_t offset = H5Dget_offset(dataset);
  const std::uint64_t size = bytes.size();
  if (offset == HADDR_UNDEF || offset > size || table.row_count > (size - offset) / table.row_bytes)
    core::fail(blame.status,
               "{}: expected {} rows of {} bytes within the file's {} bytes, found them beyond its end",
               table.place, table.row_count, table.row_bytes, size);
  table.rows.resize(table.row_count * table.row_bytes);
  bytes.read_at(offset, table.rows);
  table.offset = offset;
}

// As other programs lay them out that copy a container: chunked, with or without filters, or compact. A
// compressed table may claim to be any size, but a container has a frame, and thus bytes, for each of its
// rows.
void read_filtered(const Blame& blame, hid_t dataset, const core::File& bytes, const Handle& properties,
                   Table& table) {
  const std::uint64_t most = std::max(kMostFilteredBytes, kMostExpansion * bytes.size()) / table.row_bytes;
  hsize_t chunk = 0;
  if (H5Pget_layout(properties.get()) == H5D_CHUNKED && H5Pget_chunk(properties.get(), 1, &chunk) != 1)
    blame.fail("cannot read the chunks' size of " + table.place);
  if (table.row_count > most || chunk > most)
    core::fail(blame.status, "{}: expected at most {} rows in a file of {} bytes, found {} in chunks of {}",
               table.place, most, bytes.size(), table.row_count, chunk);
  table.rows.resize(table.row_count * table.row_bytes);
  const Handle type = blame.own(H5Dget_type(dataset), &H5Tclose, "cannot read the type of " + table.place);
  blame.check(H5Dread(dataset, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, table.rows.data()),
              "cannot read " + table.place);
}

void read_rows(const Blame& blame, hid_t dataset, const core::File& bytes, Table& table) {
  const Handle properties =
      blame.own(H5Dget_create_plist(dataset), &H5Pclose, "cannot read the layout of " + table.place);
  const H5D_layout_t layout = H5Pget_layout(properties.get());
  const bool is_known = layout == H5D_CONTIGUOUS || layout == H5D_CHUNKED || layout == H5D_COMPACT;
  if (!is_known || H5Pget_external_count(properties.get()) != 0)
    core::fail(blame.status, "{}: expected rows within this file, found a virtual or external dataset",
               table.place);
  if (table.row_count == 0) return;
  if (layout == H5D_CONTIGUOUS)
    read_contiguous(blame, dataset, bytes, table);
  else
    read_filtered(blame, dataset, bytes, properties, table);
}

}  // namespace

std::size_t field_bytes(const Field& field) {
  switch (field.type) {
    case FieldType::kU8:
    case FieldType::kText:
      return field.count;
    case FieldType::kU32:
    case FieldType::kI32:
      return std::size_t{4} * field.count;
    case FieldType::kU64:
    case FieldType::kF64:
      break;
  }
  return std::size_t{8} * field.count;
}

std::size_t pack_fields(std::vector<Field>& fields) {
  std::size_t offset = 0;
  for (Field& field : fields) {
    field.offset = offset;
    offset += field_bytes(field);
  }
  return offset;
}

Handle create_table(const Blame& blame, hid_t file, const std::string& name, std::vector<Field> fields,
                    std::uint64_t row_count) {
  const std::string what = "cannot create dataset /" + name;
  const std::size_t row_bytes = pack_fields(fields);
  const Handle type = blame.own(H5Tcreate(H5T_COMPOUND, row_bytes), &H5Tclose, what);
  for (const Field& field : fields)
    blame.check(H5Tinsert(type.get(), field.name.c_str(), field.offset, make_type(blame, field).get()), what);
  const hsize_t extent = row_count;
  const Handle space = blame.own(H5Screate_simple(1, &extent, nullptr), &H5Sclose, what);
  const Handle properties = blame.own(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose, what);
  blame.check(H5Pset_layout(properties.get(), H5D_CONTIGUOUS), what);
  blame.check(H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY), what);
  blame.check(H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER), what);
  blame.check(H5Pset_obj_track_times(properties.get(), false), what);
  keep_attributes_in_header(blame, properties.get());
  Handle dataset = blame.own(
      H5Dcreate2(file, name.c_str(), type.get(), space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
      &H5Dclose, what);
  const std::uint64_t checksum = 0;
  write_attribute(blame, dataset.get(), kChecksumName, FieldType::kU64, 1, &checksum);
  return dataset;
}

void write_table(const Blame& blame, const Handle& table, std::span<const std::byte> rows) {
  const std::string what = "cannot write a table";
  const Handle type = blame.own(H5Dget_type(table.get()), &H5Tclose, what);
  const Handle space = blame.own(H5Dget_space(table.get()), &H5Sclose, what);
  const std::size_t expected =
      H5Tget_size(type.get()) * static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
  COLOSSUS_CHECK(rows.size() == expected, "{} bytes of rows for a table of {}", rows.size(), expected);
  if (!rows.empty())
    blame.check(H5Dwrite(table.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), what);
  const std::uint64_t checksum = core::hash64(rows);
  const Handle attribute = blame.own(H5Aopen(table.get(), kChecksumName, H5P_DEFAULT), &H5Aclose, what);
  blame.check(H5Awrite(attribute.get(), H5T_STD_U64LE, &checksum), what);
}

const Field& Table::field(const std::string& name, FieldType type, std::uint32_t count) const {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  if (found == fields.end())
    core::fail(Status::kBadData, "{}: field {}: expected {}, found none", place, name, describe(type, count));
  if (found->type != type || (type != FieldType::kText && found->count != count))
    core::fail(Status::kBadData, "{}: field {}: expected {}, found {}", place, name, describe(type, count),
               describe(found->type, found->count));
  return *found;
}

std::string Table::text(std::uint64_t row, const Field& field) const {
  const char* begin = reinterpret_cast<const char*>(at(row, field));
  return std::string(begin, std::find(begin, begin + field.count, '\0'));
}

std::uint64_t Table::u64(std::uint64_t row, const Field& field) const {
  std::uint64_t value = 0;
  std::memcpy(&value, at(row, field), sizeof(value));
  return value;
}

Table read_table(const Blame& blame, hid_t group, const core::File& bytes, const std::string& name) {
  Table table;
  table.place = blame.place("/" + name);
  const Handle dataset = open_dataset(blame, group, table, name);
  const Handle type = blame.own(H5Dget_type(dataset.get()), &H5Tclose, "cannot read the type of /" + name);
  read_fields(blame, type.get(), table);
  const Handle space =
      blame.own(H5Dget_space(dataset.get()), &H5Sclose, "cannot read the extent of /" + name);
  hsize_t extent = 0;
  if (H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Sget_simple_extent_dims(space.get(), &extent, nullptr) != 1)
    core::fail(blame.status, "{}: expected one dimension", table.place);
  table.row_count = extent;
  read_rows(blame, dataset.get(), bytes, table);
  std::uint64_t checksum = 0;
  read_attribute(blame, dataset.get(), "/" + name, kChecksumName, FieldType::kU64, 1, &checksum);
  if (const std::uint64_t found = core::hash64(table.rows); found != checksum)
    core::fail(blame.status, "{}: expected checksum {:016x}, found {:016x}; the file is damaged", table.place,
               checksum, found);
  return table;
}

void write_attribute(const Blame& blame, hid_t object, const std::string& name, FieldType type,
                     std::uint32_t count, const void* values) {
  const std::string what = "cannot write attribute " + name;
  const bool is_text = type == FieldType::kText;
  const Handle stored =
      is_text ? make_type(blame, Field{name, type, count}) : make_type(blame, Field{name, type, 1});
  const hsize_t extent = count;
  const Handle space = blame.own(
      is_text || count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, nullptr), &H5Sclose, what);
  const Handle attribute = blame.own(
      H5Acreate2(object, name.c_str(), stored.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), &H5Aclose, what);
  blame.check(H5Awrite(attribute.get(), stored.get(), values), what);
}

void read_attribute(const Blame& blame, hid_t object, const std::string& place, const std::string& name,
                    FieldType type, std::uint32_t count, void* values) {
  const std::string where = fmt::format("{}: attribute {}", blame.place(place), name);
  if (H5Aexists(object, name.c_str()) <= 0)
    core::fail(blame.status, "{}: expected {}, found none", where, describe(type, count));
  const Handle attribute =
      blame.own(H5Aopen(object, name.c_str(), H5P_DEFAULT), &H5Aclose, "cannot read " + name);
  const Handle stored = blame.own(H5Aget_type(attribute.get()), &H5Tclose, "cannot read " + name);
  const Handle space = blame.own(H5Aget_space(attribute.get()), &H5Sclose, "cannot read " + name);
  if (H5Tequal(stored.get(), scalar_type(type)) <= 0 || H5Sget_simple_extent_npoints(space.get()) != count)
    core::fail(blame.status, "{}: expected {}, found another type or size", where, describe(type, count));
  blame.check(H5Aread(attribute.get(), stored.get(), values), "cannot read attribute " + name);
}

std::string read_text_attribute(const Blame& blame, hid_t object, const std::string& place,
                                const std::string& name) {
  const std::string where = fmt::format("{}: attribute {}", blame.place(place), name);
  if (H5Aexists(object, name.c_str()) <= 0)
    core::fail(blame.status, "{}: expected a text, found none", where);
  const Handle attribute =
      blame.own(H5Aopen(object, name.c_str(), H5P_DEFAULT), &H5Aclose, "cannot read " + name);
  const Handle stored = blame.own(H5Aget_type(attribute.get()), &H5Tclose, "cannot read " + name);
  const Handle space = blame.own(H5Aget_space(attribute.get()), &H5Sclose, "cannot read " + name);
  Field field;
  if (!recognise(stored.get(), field) || field.type != FieldType::kText ||
      H5Sget_simple_extent_npoints(space.get()) != 1)
    core::fail(blame.status, "{}: expected a text of fixed length, found another type", where);
  std::string text(field.count, '\0');
  blame.check(H5Aread(attribute.get(), stored.get(), text.data()), "cannot read attribute " + name);
  return text.substr(0, text.find('\0'));
}

}  // namespace colossus::container
