#include "verify/measure/report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace colossus::verify::measure {
namespace {

std::string density_cell(const std::optional<double>& density) {
  return density ? fmt::format("{:.3f}", *density) : "-";
}

}  // namespace

std::string_view name_of(FindingKind kind) {
  static constexpr std::array<std::string_view, kFindingKinds> kNames{
      "damage",        "structure",    "bounds",   "face",   "edge",           "error growth",
      "border",        "non-manifold", "distance", "parent", "condition",      "parent map",
      "shared vertex", "orientation",  "count",    "area",   "input distance", "loose error"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::uint64_t VerifyReport::total() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t n : counts) sum += n;
  return sum;
}

std::string to_text(const VerifyReport& report) {
  const bool has_clefts = std::any_of(report.levels.begin(), report.levels.end(),
                                      [](const LevelReport& level) { return level.clefts.has_value(); });
  std::string text =
      fmt::format("{:>5} {:>9} {:>13} {:>12} {:>12}{}\n", "level", "nodes", "triangles", "border",
                  "non-manifold", has_clefts ? fmt::format(" {:>12} {:>12}", "locked", "earlier") : "");
  for (const LevelReport& level : report.levels) {
    text += fmt::format("{:>5} {:>9} {:>13} {:>12} {:>12}", level.level, level.nodes, level.triangles,
                        level.border_edges, level.nonmanifold_edges);
    if (has_clefts) {
      const CleftDensities clefts = level.clefts.value_or(CleftDensities{});
      text += fmt::format(" {:>12} {:>12}", density_cell(clefts.locked), density_cell(clefts.earlier));
    }
    text += '\n';
  }
  if (has_clefts)
    text +=
        "locked, earlier: density of triangles near borders of blocks that were locked while this, or a "
        "finer, "
        "level was made, over that of the rest of their cubes\n";
  text += fmt::format("checked: {} nodes", report.nodes);
  if (report.faces > 0)
    text += fmt::format(", {} faces of the hierarchy ({} crossed by the surface), {} edges of it",
                        report.faces, report.nonempty_faces, report.edges);
  if (report.parents > 0)
    text += fmt::format(", {} parents of vertices, {} triangles under the parent map", report.parents,
                        report.mapped_triangles);
  text += '\n';
  const bool is_partial = std::any_of(report.levels.begin(), report.levels.end(),
                                      [](const LevelReport& level) { return level.is_partial; });
  if (is_partial) text += "levels with damaged nodes: edges that these might use are not counted\n";
  if (report.samples > 0)
    text += fmt::format(
        "measured: {} samples, greatest distance / stored error {:.3f}, {} of {} errors above four times "
        "it\n",
        report.samples, report.greatest_ratio, report.loose_nodes, report.measured_nodes);
  if (report.input_samples > 0) {
    text += fmt::format("from the input: {} samples, greatest distance / stored error from level 0 on:",
                        report.input_samples);
    for (const LevelReport& level : report.levels) text += fmt::format(" {:.3f}", level.input_ratio);
    text += '\n';
  }
  for (const std::string& note : report.notes) text += note + '\n';
  for (const Finding& finding : report.findings)
    text += fmt::format("{}: {}\n", name_of(finding.kind), finding.message);
  for (std::size_t kind = 0; kind < kFindingKinds; ++kind)
    if (report.counts[kind] > 0)
      text += fmt::format("found: {} of kind \"{}\"\n", report.counts[kind],
                          name_of(static_cast<FindingKind>(kind)));
  text += report.is_ok() ? "nothing found\n" : fmt::format("{} findings\n", report.total());
  return text;
}

void FindingLog::add_many(FindingKind kind, std::uint64_t count, std::vector<std::string> messages) {
  std::uint64_t& so_far = report_.counts[static_cast<std::size_t>(kind)];
  for (std::size_t i = 0; i < messages.size() && so_far + i < examples_per_kind_; ++i)
    report_.findings.push_back({kind, std::move(messages[i])});
  so_far += count;
}

void FindingLog::start_level(std::uint32_t level) {
  if (!report_.levels.empty()) {
    if (report_.levels.back().level + 1 != level)
      add({FindingKind::kStructure,
           fmt::format("no nodes between levels {} and {}", report_.levels.back().level, level)});
  } else if (level != 0) {
    add({FindingKind::kStructure, fmt::format("the coarsest level is {}; the root is missing", level)});
  }
  report_.levels.emplace_back().level = level;
}

void FindingLog::add_input_measure(std::uint64_t samples, double greatest_ratio) {
  report_.input_samples += samples;
  report_.levels.back().input_ratio = greatest_ratio;
}

void FindingLog::check_census(const reader::access::Statue& statue) {
  if (report_.levels.empty()) return;
  check_edges(FindingKind::kBorder, "border", &LevelReport::border_edges, statue.count_of("border_edges"));
  // What the lattice lays onto each other is non-manifold from the finest level on, and the build says so.
  // What only the places of a coarser level lay onto each other is so there, see check_edges().
  if (statue.count_of("finest_nonmanifold_edges").value_or(0) > 0) return;
  check_edges(FindingKind::kNonManifold, "non-manifold", &LevelReport::nonmanifold_edges,
              statue.count_of("nonmanifold_edges"));
}

void FindingLog::check_edges(FindingKind kind, const char* word, std::uint64_t LevelReport::*member,
                             std::optional<std::uint64_t> of_input) {
  const LevelReport& finest = report_.levels.back();
  if (!of_input && finest.is_partial) return;
  if (of_input.value_or(finest.*member) != 0) return;
  for (const LevelReport& level : report_.levels)
    if (level.*member != 0 && !(kind == FindingKind::kNonManifold && level.has_shared_places))
      add({kind, fmt::format("the cut of level {} has {} {} edges, {} none", level.level, level.*member, word,
                             of_input ? "the input" : "the finest cut")});
}

void FindingLog::check_orientation(const reader::access::Statue& statue) {
  const auto& columns = statue.metadata().levels;
  const auto column = std::find_if(columns.begin(), columns.end(),
                                   [](const auto& c) { return c.name == "inconsistent_edges"; });
  const auto* stored =
      column == columns.end() ? nullptr : std::get_if<std::vector<std::uint64_t>>(&column->values);
  if (stored == nullptr) return;
  for (const LevelReport& level : report_.levels) {
    if (level.damaged_nodes > 0 || level.level >= stored->size()) continue;
    if (const std::uint64_t expected = (*stored)[level.level]; level.inconsistent_edges != expected)
      add({FindingKind::kOrientation,
           fmt::format(
               "the nodes of level {} have {} edges that two triangles use in the same direction; the "
               "container says {}",
               level.level, level.inconsistent_edges, expected)});
  }
}

void FindingLog::check_looseness() {
  if (report_.loose_nodes * 2 > report_.measured_nodes)
    add({FindingKind::kLooseError,
         fmt::format("{} of {} nodes store an error of more than four times the sampled distance",
                     report_.loose_nodes, report_.measured_nodes)});
}

void FindingLog::sort() {
  std::stable_sort(report_.findings.begin(), report_.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.kind < b.kind; });
}

std::vector<std::string> layout_faults(const std::vector<container::NodeRow>& rows,
                                       std::uint64_t table_offset) {
  std::vector<std::string> faults;
  const auto behind = std::find_if(rows.begin(), rows.end(),
                                   [&](const container::NodeRow& row) { return row.offset < table_offset; });
  if (behind != rows.end())
    faults.push_back(
        fmt::format("the node table, at byte {}, lies behind the chunk of the node at {}, at byte {}",
                    table_offset, reader::access::name_of(*behind), behind->offset));
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (rows[i].offset <= rows[i - 1].offset)
      faults.push_back(fmt::format(
          "node at {}: its chunk, at byte {}, does not lie behind that of the row before it, at byte {}",
          reader::access::name_of(rows[i]), rows[i].offset, rows[i - 1].offset));
  return faults;
}

void check_layout(const reader::access::Statue& statue, FindingLog& log) {
  const container::ContainerReader& container = statue.container();
  if (!container.offsets_hold()) {
    log.add_note(
        "not checked, since another program has moved the chunks: their order, and that of the node table");
    return;
  }
  std::vector<std::string> faults = layout_faults(statue.rows(), container.table_offset());
  const std::size_t count = faults.size();
  log.add_many(FindingKind::kStructure, count, std::move(faults));
}

double arithmetic_tolerance(const container::LatticeInfo& lattice) {
  double magnitude = 0.0;
  for (const double origin : lattice.origin)
    magnitude = std::max(
        {magnitude, std::abs(origin), std::abs(origin + lattice.step * std::ldexp(1.0, lattice.root_bits))});
  return 4.0 * std::numeric_limits<double>::epsilon() * magnitude;
}

bool is_within(const reader::access::Statue& statue, double distance, double error) {
  return distance <= error * (1.0 + 1e-9) + arithmetic_tolerance(statue.metadata().lattice);
}

std::optional<Finding> check_distance(const reader::access::Statue& statue, reader::access::RowIndex row,
                                      const WorldPoint& p, double distance) {
  const double error = statue.rows()[row].error;
  if (is_within(statue, distance, error)) return std::nullopt;
  return Finding{FindingKind::kDistance,
                 fmt::format("node at {}: {} {} {} is {} from the input, more than the stored error {}",
                             statue.name(row), p[0], p[1], p[2], distance, error)};
}

}  // namespace colossus::verify::measure
