#include "reader/info.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "codec/coded/coded_node.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"

namespace colossus::reader {
namespace {

struct LevelRow {
  std::uint32_t level = 0;
  std::uint64_t nodes = 0;
  std::uint64_t leaves = 0;
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t bytes = 0;
  double error = 0.0;
  double bits_per_vertex() const {
    return vertices == 0 ? 0.0 : 8.0 * static_cast<double>(bytes) / static_cast<double>(vertices);
  }
};

struct Summary {
  std::vector<LevelRow> levels;
  std::uint64_t above_limit = 0;
  double quantisation_error = 0.0;
};

Summary summarize(const access::Statue& statue) {
  Summary summary;
  for (access::RowIndex index = 0; index < statue.rows().size(); ++index) {
    const container::NodeRow& row = statue.rows()[index];
    if (summary.levels.empty() || summary.levels.back().level != row.level)
      summary.levels.push_back({.level = row.level});
    LevelRow& level = summary.levels.back();
    ++level.nodes;
    level.triangles += row.triangles;
    level.vertices += row.vertices;
    level.bytes += row.stored_bytes;
    level.error = std::max(level.error, row.error);
    if ((row.flags & container::kNodeIsAboveLimit) != 0) ++summary.above_limit;
    if (!statue.is_leaf(index)) continue;
    ++level.leaves;
    // A leaf is the input: its error is what the lattice and quantisation have moved, measured.
    summary.quantisation_error = std::max(summary.quantisation_error, row.error);
  }
  return summary;
}

std::size_t column_size(const container::LevelColumn& column) {
  return std::visit([](const auto& values) { return values.size(); }, column.values);
}

// The value of a stored column for a level, or a dash.
std::string cell(const container::LevelColumn& column, std::uint32_t level) {
  if (level >= column_size(column)) return "-";
  return std::visit(
      [&](const auto& values) { return fmt::format("{:.6g}", static_cast<double>(values[level])); },
      column.values);
}

std::string cell_exact(const container::LevelColumn& column, std::uint32_t level) {
  if (const auto* counts = std::get_if<std::vector<std::uint64_t>>(&column.values);
      counts && level < counts->size())
    return fmt::format("{}", (*counts)[level]);
  return cell(column, level);
}

// A share of two stored columns, for people: what the builder's counts mean.
struct Share {
  const char* title;
  const char* part;
  const char* whole;
};
constexpr std::array<Share, 6> kShares{{{"target", "target_triangles", "initial_triangles"},
                                        {"reached", "reached_triangles", "initial_triangles"},
                                        {"locked", "locked_vertices", "initial_vertices"},
                                        {"<5 deg", "angle_below_5", "triangles"},
                                        {"<15 deg", "angle_below_15", "triangles"},
                                        {"<30 deg", "angle_below_30", "triangles"}}};

// What of the bits per vertex is spent on what, by the builder's counts of stored bytes; head, checksum and
// frame are the rest.
struct Part {
  const char* title;
  const char* name;  // in JSON
  const char* bytes;
};
constexpr const auto& kColumns = codec::coded::kComponentColumns;
constexpr std::array<Part, codec::coded::kComponentCount> kParts{{{"topology", "connectivity", kColumns[0]},
                                                                  {"position", "positions", kColumns[1]},
                                                                  {"normal", "normals", kColumns[2]},
                                                                  {"colour", "colors", kColumns[3]},
                                                                  {"parent", "parents", kColumns[4]}}};

const container::LevelColumn* find_column(const container::Metadata& meta, std::string_view name) {
  for (const auto& column : meta.levels)
    if (column.name == name) return &column;
  return nullptr;
}

std::optional<double> value_of(const container::Metadata& meta, std::string_view name, std::uint32_t level) {
  const container::LevelColumn* column = find_column(meta, name);
  if (column == nullptr || level >= column_size(*column)) return std::nullopt;
  return std::visit([&](const auto& values) { return static_cast<double>(values[level]); }, column->values);
}

std::string share_cell(const container::Metadata& meta, const Share& share, std::uint32_t level) {
  const auto part = value_of(meta, share.part, level);
  const auto whole = value_of(meta, share.whole, level);
  return part && whole && *whole > 0.0 ? fmt::format("{:.1f}%", 100.0 * *part / *whole) : "-";
}

std::optional<double> part_bits(const container::Metadata& meta, const Part& part, const LevelRow& level) {
  const auto bytes = value_of(meta, part.bytes, level.level);
  if (!bytes || level.vertices == 0) return std::nullopt;
  return 8.0 * *bytes / static_cast<double>(level.vertices);
}

std::string part_cell(const container::Metadata& meta, const Part& part, const LevelRow& level) {
  const auto bits = part_bits(meta, part, level);
  return bits ? fmt::format("{:.2f}", *bits) : "-";
}

// Whether the table says this already, by the node table, as a part or as a share.
bool is_shown(std::string_view name) {
  constexpr std::array<std::string_view, 8> kShown{"level",     "nodes",        "leaves",        "vertices",
                                                   "triangles", "stored_bytes", "payload_bytes", "error"};
  return std::find(kShown.begin(), kShown.end(), name) != kShown.end() ||
         std::any_of(kParts.begin(), kParts.end(), [&](const Part& part) { return name == part.bytes; }) ||
         std::any_of(kShares.begin(), kShares.end(),
                     [&](const Share& share) { return name == share.part || name == share.whole; });
}

// Levels with more than a tenth more triangles than were aimed at, as the builder counts them.
std::vector<std::uint32_t> levels_above_target(const container::Metadata& meta, const Summary& summary) {
  std::vector<std::uint32_t> levels;
  for (const LevelRow& level : summary.levels) {
    const auto target = value_of(meta, "target_triangles", level.level);
    const auto reached = value_of(meta, "reached_triangles", level.level);
    if (target && reached && 10.0 * *reached > 11.0 * *target) levels.push_back(level.level);
  }
  return levels;
}

std::string shrink_text(const container::Metadata& meta, const Summary& summary) {
  std::string text;
  for (const std::uint32_t level : levels_above_target(meta, summary))
    text += fmt::format(
        "level {} does not shrink as it should: {:.0f} triangles are left of {:.0f}, where {:.0f} were aimed "
        "at\n",
        level, *value_of(meta, "reached_triangles", level),
        value_of(meta, "initial_triangles", level).value_or(0.0), *value_of(meta, "target_triangles", level));
  return text;
}

std::string level_table(const access::Statue& statue, const Summary& summary) {
  std::vector<std::vector<std::string>> table{
      {"level", "nodes", "leaves", "triangles", "vertices", "bytes", "bits/vertex", "error"}};
  const container::Metadata& meta = statue.metadata();
  for (const Part& part : kParts) table.front().push_back(part.title);
  for (const Share& share : kShares) table.front().push_back(share.title);
  for (const auto& column : meta.levels)
    if (!is_shown(column.name)) table.front().push_back(column.name);
  for (const LevelRow& level : summary.levels) {
    table.push_back({fmt::format("{}", level.level), fmt::format("{}", level.nodes),
                     fmt::format("{}", level.leaves), fmt::format("{}", level.triangles),
                     fmt::format("{}", level.vertices), fmt::format("{}", level.bytes),
                     fmt::format("{:.2f}", level.bits_per_vertex()), fmt::format("{:.6g}", level.error)});
    for (const Part& part : kParts) table.back().push_back(part_cell(meta, part, level));
    for (const Share& share : kShares) table.back().push_back(share_cell(meta, share, level.level));
    for (const auto& column : meta.levels)
      if (!is_shown(column.name)) table.back().push_back(cell_exact(column, level.level));
  }
  std::vector<std::size_t> widths(table.front().size(), 0);
  for (const auto& line : table)
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  std::string text;
  for (const auto& line : table) {
    for (std::size_t i = 0; i < line.size(); ++i)
      text += fmt::format("{}{:>{}}", i == 0 ? "" : "  ", line[i], widths[i]);
    text += '\n';
  }
  return text;
}

}  // namespace

std::string info_text(const access::Statue& statue) {
  const container::Metadata& meta = statue.metadata();
  const Summary summary = summarize(statue);
  std::string text = fmt::format("file                {} ({} bytes)\n", statue.container().path().string(),
                                 statue.container().file_bytes());
  text += fmt::format("schema              {}.{}, scheme {}\n", meta.schema_major, meta.schema_minor,
                      meta.scheme);
  if (!meta.producer.empty())
    text += fmt::format("producer            {} {}\n", meta.producer, meta.producer_version);
  text +=
      fmt::format("lattice             origin {} {} {}, step {} (in the input's units)\n",
                  meta.lattice.origin[0], meta.lattice.origin[1], meta.lattice.origin[2], meta.lattice.step);
  text += fmt::format(
      "positions           {} {}; a leaf's vertex moves by at most {:.6g}, of which the lattice {:.6g}\n",
      meta.position_bits, statue.position_bits_meaning(), summary.quantisation_error, statue.lattice_error());
  text += fmt::format("attributes          {}\n", meta.has_normals
                                                      ? meta.has_colors ? "normals, colours" : "normals"
                                                  : meta.has_colors ? "colours"
                                                                    : "none");
  for (const auto& option : meta.options)
    text += fmt::format("option              {} = {}\n", option.name, option.value);
  for (const auto& parameter : meta.parameters)
    text += fmt::format("parameter           {} = {}\n", parameter.name, parameter.value);
  for (const auto& measure : meta.measures)
    text += fmt::format("measure             {} = {}\n", measure.name, measure.value);
  for (const auto& input : meta.inputs)
    text += fmt::format("input               {} ({} bytes, {})\n", input.name, input.bytes, input.hash);
  for (const auto& count : meta.counts)
    text += fmt::format("input count         {} {}\n", count.name, count.value);
  text += fmt::format("nodes               {}, of which {} leaves above the limit\n\n", statue.rows().size(),
                      summary.above_limit);
  text +=
      "topology to parent: what of the bits per vertex is spent on what\n"
      "target, reached: share of the triangles that the level's inner nodes were made of; locked: of their "
      "vertices;\n"
      "< n deg: share of triangles with a smaller angle than that\n\n";
  return text + level_table(statue, summary) + shrink_text(meta, summary);
}

std::string info_json(const access::Statue& statue) {
  using nlohmann::ordered_json;
  const container::Metadata& meta = statue.metadata();
  const Summary summary = summarize(statue);
  ordered_json json;
  json["file"] = {{"path", statue.container().path().string()}, {"bytes", statue.container().file_bytes()}};
  json["schema"] = {{"major", meta.schema_major}, {"minor", meta.schema_minor}};
  json["producer"] = {{"name", meta.producer}, {"version", meta.producer_version}};
  json["scheme"] = meta.scheme;
  json["lattice"] = {
      {"origin", meta.lattice.origin}, {"step", meta.lattice.step}, {"root_bits", meta.lattice.root_bits}};
  json["position_bits"] = meta.position_bits;
  json["lattice_error"] = statue.lattice_error();
  json["quantisation_error"] = summary.quantisation_error;
  json["attributes"] = {{"normals", meta.has_normals}, {"colors", meta.has_colors}};
  json["options"] = ordered_json::object();
  for (const auto& option : meta.options) json["options"][option.name] = option.value;
  json["parameters"] = ordered_json::object();
  for (const auto& parameter : meta.parameters) json["parameters"][parameter.name] = parameter.value;
  json["measures"] = ordered_json::object();
  for (const auto& measure : meta.measures) json["measures"][measure.name] = measure.value;
  json["inputs"] = ordered_json::array();
  for (const auto& input : meta.inputs)
    json["inputs"].push_back({{"name", input.name}, {"bytes", input.bytes}, {"hash", input.hash}});
  json["counts"] = ordered_json::object();
  for (const auto& count : meta.counts) json["counts"][count.name] = count.value;
  json["nodes"] = statue.rows().size();
  json["above_limit"] = summary.above_limit;
  json["levels"] = ordered_json::array();
  for (const LevelRow& level : summary.levels) {
    ordered_json line{{"level", level.level},
                      {"nodes", level.nodes},
                      {"leaves", level.leaves},
                      {"triangles", level.triangles},
                      {"vertices", level.vertices},
                      {"bytes", level.bytes},
                      {"bits_per_vertex", level.bits_per_vertex()},
                      {"error", level.error}};
    for (const Part& part : kParts)
      if (const auto bits = part_bits(meta, part, level)) line["part_bits_per_vertex"][part.name] = *bits;
    for (const auto& column : meta.levels)
      std::visit(
          [&](const auto& values) {
            if (level.level < values.size()) line["statistics"][column.name] = values[level.level];
          },
          column.values);
    json["levels"].push_back(line);
  }
  json["levels_above_target"] = levels_above_target(meta, summary);
  return core::with_escaped_texts(json).dump(2) + "\n";
}

}  // namespace colossus::reader
