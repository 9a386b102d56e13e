#include "reader/verify_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace colossus::reader {
namespace {

std::string density_cell(const std::optional<double>& density) {
  return density ? fmt::format("{:.3f}", *density) : "-";
}

}  // namespace

std::string_view name_of(FindingKind kind) {
  static constexpr std::array<std::string_view, kFindingKinds> kNames{
      "damage",       "structure", "bounds", "face",      "edge",       "error growth",  "border",
      "non-manifold", "distance",  "parent", "condition", "parent map", "shared vertex", "loose error"};
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
  if (report.samples > 0)
    text += fmt::format(
        "measured: {} samples, greatest distance / stored error {:.3f}, {} of {} errors above four times "
        "it\n",
        report.samples, report.greatest_ratio, report.loose_nodes, report.measured_nodes);
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

void FindingLog::check_census(const StatueFile& statue) {
  if (report_.levels.empty()) return;
  check_edges(FindingKind::kBorder, "border", &LevelReport::border_edges, statue.count_of("border_edges"));
  check_edges(FindingKind::kNonManifold, "non-manifold", &LevelReport::nonmanifold_edges,
              statue.count_of("nonmanifold_edges"));
}

void FindingLog::check_edges(FindingKind kind, const char* word, std::uint64_t LevelReport::*member,
                             std::optional<std::uint64_t> of_input) {
  if (of_input.value_or(report_.levels.back().*member) != 0) return;
  for (const LevelReport& level : report_.levels)
    if (level.*member != 0)
      add({kind, fmt::format("the cut of level {} has {} {} edges, {} none", level.level, level.*member, word,
                             of_input ? "the input" : "the finest cut")});
}

void FindingLog::check_looseness() {
  if (report_.loose_nodes * 10 > report_.measured_nodes)
    add({FindingKind::kLooseError,
         fmt::format("{} of {} nodes store an error of more than four times the sampled distance",
                     report_.loose_nodes, report_.measured_nodes)});
}

void FindingLog::sort() {
  std::stable_sort(report_.findings.begin(), report_.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.kind < b.kind; });
}

double arithmetic_tolerance(const container::LatticeInfo& lattice) {
  double magnitude = 0.0;
  for (const double origin : lattice.origin)
    magnitude = std::max(
        {magnitude, std::abs(origin), std::abs(origin + lattice.step * std::ldexp(1.0, lattice.root_bits))});
  return 4.0 * std::numeric_limits<double>::epsilon() * magnitude;
}

std::optional<Finding> check_distance(const StatueFile& statue, RowIndex row, const WorldPoint& p,
                                      double distance) {
  const double error = statue.rows()[row].error;
  if (!(distance > error * (1.0 + 1e-9) + arithmetic_tolerance(statue.metadata().lattice)))
    return std::nullopt;
  return Finding{FindingKind::kDistance,
                 fmt::format("node at {}: {} {} {} is {} from the input, more than the stored error {}",
                             statue.name(row), p[0], p[1], p[2], distance, error)};
}

}  // namespace colossus::reader
