#include "container/metadata_io.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "container/descriptions.hpp"
#include "container/table.hpp"

namespace colossus::container {
namespace {

using core::Status;
using hdf5::Blame;
using hdf5::Handle;

constexpr std::uint8_t kHasNormals = 1;
constexpr std::uint8_t kHasColors = 2;

void put_text(core::ByteWriter& writer, const std::string& text, std::uint32_t bytes) {
  COLOSSUS_CHECK(text.size() <= bytes && text.find('\0') == std::string::npos, "text '{}'", text);
  core::Bytes padded(bytes);
  std::memcpy(padded.data(), text.data(), text.size());
  writer.put_bytes(padded);
}

// HDF5 has no texts of zero bytes.
template <typename Entry>
std::uint32_t widest(const std::vector<Entry>& entries, std::string Entry::*member) {
  std::size_t bytes = 1;
  for (const Entry& entry : entries) bytes = std::max(bytes, (entry.*member).size());
  return static_cast<std::uint32_t>(bytes);
}

// The names of a table's rows, for their descriptions.
template <typename Entry>
std::vector<std::string> names_of(const std::vector<Entry>& entries) {
  std::vector<std::string> names;
  names.reserve(entries.size());
  for (const Entry& entry : entries) names.push_back(entry.name);
  return names;
}

// A table of names and values.
void write_named(const Blame& blame, hid_t file, const std::string& name, const std::vector<Field>& fields,
                 const std::vector<std::string>& row_names, std::span<const std::byte> rows,
                 const std::vector<NamedText>& meanings = {}) {
  const Handle table = create_table(blame, file, name, fields, row_names.size());
  write_table(blame, table, rows);
  describe_table(blame, table.get(), name, fields, row_names, meanings);
}

void write_options(const Blame& blame, hid_t file, const Metadata& metadata) {
  const std::vector<NamedText>& options = metadata.options;
  const std::vector<Field> fields = {{"name", FieldType::kText, widest(options, &NamedText::name)},
                                     {"value", FieldType::kText, widest(options, &NamedText::value)}};
  core::ByteWriter rows;
  for (const NamedText& option : options) {
    put_text(rows, option.name, fields[0].count);
    put_text(rows, option.value, fields[1].count);
  }
  write_named(blame, file, "options", fields, names_of(options), rows.bytes(), metadata.option_meanings);
}

// No table where there are none: containers of schema 1.0 have no parameters, those of 1.1 no measures.
void write_reals(const Blame& blame, hid_t file, const std::string& name,
                 const std::vector<NamedReal>& reals) {
  if (reals.empty()) return;
  const std::vector<Field> fields = {{"name", FieldType::kText, widest(reals, &NamedReal::name)},
                                     {"value", FieldType::kF64}};
  core::ByteWriter rows;
  for (const NamedReal& real : reals) {
    put_text(rows, real.name, fields[0].count);
    rows.put(real.value);
  }
  write_named(blame, file, name, fields, names_of(reals), rows.bytes());
}

void write_inputs(const Blame& blame, hid_t file, const std::vector<InputInfo>& inputs) {
  const std::vector<Field> fields = {{"name", FieldType::kText, widest(inputs, &InputInfo::name)},
                                     {"bytes", FieldType::kU64},
                                     {"hash", FieldType::kText, widest(inputs, &InputInfo::hash)}};
  core::ByteWriter rows;
  for (const InputInfo& input : inputs) {
    put_text(rows, input.name, fields[0].count);
    rows.put(input.bytes);
    put_text(rows, input.hash, fields[2].count);
  }
  const Handle table = create_table(blame, file, "inputs", fields, inputs.size());
  write_table(blame, table, rows.bytes());
  describe_table(blame, table.get(), "inputs", fields);
}

void write_counts(const Blame& blame, hid_t file, const std::vector<NamedCount>& counts) {
  const std::vector<Field> fields = {{"name", FieldType::kText, widest(counts, &NamedCount::name)},
                                     {"value", FieldType::kU64}};
  core::ByteWriter rows;
  for (const NamedCount& count : counts) {
    put_text(rows, count.name, fields[0].count);
    rows.put(count.value);
  }
  write_named(blame, file, "counts", fields, names_of(counts), rows.bytes());
}

std::size_t column_length(const LevelColumn& column) {
  return std::visit([](const auto& values) { return values.size(); }, column.values);
}

// A compound type needs a field, so a container without statistics has no such table.
void write_levels(const Blame& blame, hid_t file, const std::vector<LevelColumn>& levels) {
  if (levels.empty()) return;
  const std::size_t level_count = column_length(levels.front());
  std::vector<Field> fields;
  for (const LevelColumn& column : levels) {
    COLOSSUS_CHECK(column_length(column) == level_count, "column {} has {} values, the first {}", column.name,
                   column_length(column), level_count);
    const bool is_real = std::holds_alternative<std::vector<double>>(column.values);
    fields.push_back({column.name, is_real ? FieldType::kF64 : FieldType::kU64});
  }
  core::ByteWriter rows;
  for (std::size_t level = 0; level < level_count; ++level)
    for (const LevelColumn& column : levels)
      std::visit([&](const auto& values) { rows.put(values[level]); }, column.values);
  const Handle table = create_table(blame, file, "levels", fields, level_count);
  write_table(blame, table, rows.bytes());
  describe_table(blame, table.get(), "levels", fields);
}

void write_lattice(const Blame& blame, hid_t file, const Metadata& metadata) {
  const std::string what = "cannot create group /lattice";
  const Handle properties = blame.own(H5Pcreate(H5P_GROUP_CREATE), &H5Pclose, what);
  blame.check(H5Pset_obj_track_times(properties.get(), false), what);
  const Handle group =
      blame.own(H5Gcreate2(file, "lattice", H5P_DEFAULT, properties.get(), H5P_DEFAULT), &H5Gclose, what);
  const auto root_bits = static_cast<std::uint32_t>(metadata.lattice.root_bits);
  const auto position_bits = static_cast<std::uint32_t>(metadata.position_bits);
  write_attribute(blame, group.get(), "origin", FieldType::kF64, 3, metadata.lattice.origin.data());
  write_attribute(blame, group.get(), "step", FieldType::kF64, 1, &metadata.lattice.step);
  write_attribute(blame, group.get(), "root_bits", FieldType::kU32, 1, &root_bits);
  write_attribute(blame, group.get(), "position_bits", FieldType::kU32, 1, &position_bits);
  describe(blame, group.get(), "lattice");
}

void read_lattice(const Blame& blame, hid_t file, Metadata& metadata) {
  H5L_info_t link{};
  if (H5Lget_info(file, "lattice", &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(blame.status, "{}: expected a group, found none", blame.place("/lattice"));
  const Handle group =
      blame.own(H5Gopen2(file, "lattice", H5P_DEFAULT), &H5Gclose, "cannot open group /lattice");
  std::uint32_t root_bits = 0;
  std::uint32_t position_bits = 0;
  LatticeInfo& lattice = metadata.lattice;
  read_attribute(blame, group.get(), "/lattice", "origin", FieldType::kF64, 3, lattice.origin.data());
  read_attribute(blame, group.get(), "/lattice", "step", FieldType::kF64, 1, &lattice.step);
  read_attribute(blame, group.get(), "/lattice", "root_bits", FieldType::kU32, 1, &root_bits);
  read_attribute(blame, group.get(), "/lattice", "position_bits", FieldType::kU32, 1, &position_bits);
  for (const double origin : lattice.origin)
    if (!std::isfinite(origin))
      core::fail(blame.status, "{}: origin: expected finite numbers, found {}", blame.place("/lattice"),
                 origin);
  if (!std::isfinite(lattice.step) || lattice.step <= 0)
    core::fail(blame.status, "{}: step: expected a positive number, found {}", blame.place("/lattice"),
               lattice.step);
  if (root_bits < 1 || root_bits > 30)
    core::fail(blame.status, "{}: root_bits: expected 1 to 30, found {}", blame.place("/lattice"), root_bits);
  if (position_bits < 8 || position_bits > 16)
    core::fail(blame.status, "{}: position_bits: expected 8 to 16, found {}", blame.place("/lattice"),
               position_bits);
  lattice.root_bits = static_cast<int>(root_bits);
  metadata.position_bits = static_cast<int>(position_bits);
}

// Can this program read it? Asked before anything else is looked at.
void read_version(const Blame& blame, hid_t file, Metadata& metadata) {
  std::uint32_t version[2] = {};
  read_attribute(blame, file, "/", "schema_version", FieldType::kU32, 2, version);
  if (version[0] != kSchemaMajor)
    core::fail(blame.status, "{}: has schema version {}.{}: expected {}.x; {}", blame.file, version[0],
               version[1], kSchemaMajor,
               version[0] > kSchemaMajor ? "read it with a newer Colossus" : "build it again");
  metadata.schema_major = version[0];
  metadata.schema_minor = version[1];
  for (const auto& [name, value] : {std::pair("producer", &metadata.producer),
                                    std::pair("producer_version", &metadata.producer_version)}) {
    value->clear();
    if (H5Aexists(file, name) > 0) *value = read_text_attribute(blame, file, "/", name);
  }
  metadata.scheme = read_text_attribute(blame, file, "/", "scheme");
}

std::vector<NamedReal> read_reals(const Blame& blame, hid_t file, const core::File& bytes,
                                  const std::string& table_name) {
  std::vector<NamedReal> reals;
  if (H5Lexists(file, table_name.c_str(), H5P_DEFAULT) <= 0) return reals;
  const Table table = read_table(blame, file, bytes, table_name);
  const Field& name = table.field("name", FieldType::kText);
  const Field& value = table.field("value", FieldType::kF64);
  for (std::uint64_t i = 0; i < table.row_count; ++i) {
    NamedReal real{table.text(i, name), 0};
    std::memcpy(&real.value, table.at(i, value), sizeof(double));
    if (!std::isfinite(real.value))
      core::fail(blame.status, "{}: row {}: {}: expected a finite number, found {}", table.place, i,
                 real.name, real.value);
    reals.push_back(std::move(real));
  }
  return reals;
}

void read_levels(const Blame& blame, hid_t file, const core::File& bytes, Metadata& metadata) {
  if (H5Lexists(file, "levels", H5P_DEFAULT) <= 0) return;
  const Table table = read_table(blame, file, bytes, "levels");
  for (const Field& field : table.fields) {
    LevelColumn column{field.name, {}};
    if (field.type == FieldType::kU64 && field.count == 1) {
      std::vector<std::uint64_t> values(table.row_count);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = table.u64(i, field);
      column.values = std::move(values);
    } else if (field.type == FieldType::kF64 && field.count == 1) {
      std::vector<double> values(table.row_count);
      for (std::size_t i = 0; i < values.size(); ++i)
        std::memcpy(&values[i], table.at(i, field), sizeof(double));
      column.values = std::move(values);
    } else {
      core::fail(blame.status, "{}: field {}: expected u64 or f64", table.place, field.name);
    }
    metadata.levels.push_back(std::move(column));
  }
}

}  // namespace

void write_metadata(const Blame& blame, hid_t file, const Metadata& metadata) {
  const std::uint32_t version[2] = {kSchemaMajor, kSchemaMinor};
  const auto attributes = static_cast<std::uint8_t>((metadata.has_normals ? kHasNormals : 0) |
                                                    (metadata.has_colors ? kHasColors : 0));
  write_text_attribute(blame, file, "format", kFormatName);
  write_attribute(blame, file, "schema_version", FieldType::kU32, 2, version);
  write_text_attribute(blame, file, "scheme", metadata.scheme);
  write_attribute(blame, file, "attributes", FieldType::kU8, 1, &attributes);
  describe_file(blame, file);
  write_lattice(blame, file, metadata);
  write_options(blame, file, metadata);
  write_reals(blame, file, "parameters", metadata.parameters);
  write_reals(blame, file, "measures", metadata.measures);
  write_inputs(blame, file, metadata.inputs);
  write_counts(blame, file, metadata.counts);
  write_levels(blame, file, metadata.levels);
}

Metadata read_metadata(const Blame& blame, hid_t file, const core::File& bytes) {
  Metadata metadata;
  read_version(blame, file, metadata);
  read_lattice(blame, file, metadata);
  std::uint8_t attributes = 0;
  read_attribute(blame, file, "/", "attributes", FieldType::kU8, 1, &attributes);
  metadata.has_normals = (attributes & kHasNormals) != 0;
  metadata.has_colors = (attributes & kHasColors) != 0;

  const Table options = read_table(blame, file, bytes, "options");
  const Field& option_name = options.field("name", FieldType::kText);
  const Field& option_value = options.field("value", FieldType::kText);
  for (std::uint64_t i = 0; i < options.row_count; ++i)
    metadata.options.push_back({options.text(i, option_name), options.text(i, option_value)});

  metadata.parameters = read_reals(blame, file, bytes, "parameters");
  metadata.measures = read_reals(blame, file, bytes, "measures");

  const Table inputs = read_table(blame, file, bytes, "inputs");
  const Field& input_name = inputs.field("name", FieldType::kText);
  const Field& input_bytes = inputs.field("bytes", FieldType::kU64);
  const Field& input_hash = inputs.field("hash", FieldType::kText);
  for (std::uint64_t i = 0; i < inputs.row_count; ++i)
    metadata.inputs.push_back(
        {inputs.text(i, input_name), inputs.u64(i, input_bytes), inputs.text(i, input_hash)});

  const Table counts = read_table(blame, file, bytes, "counts");
  const Field& count_name = counts.field("name", FieldType::kText);
  const Field& count_value = counts.field("value", FieldType::kU64);
  for (std::uint64_t i = 0; i < counts.row_count; ++i)
    metadata.counts.push_back({counts.text(i, count_name), counts.u64(i, count_value)});

  read_levels(blame, file, bytes, metadata);
  return metadata;
}

}  // namespace colossus::container
