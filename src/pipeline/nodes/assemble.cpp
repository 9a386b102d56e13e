#include "pipeline/nodes/assemble.hpp"

#include <functional>
#include <numeric>
#include <type_traits>

#include "cluster/stop.hpp"
#include "container/writer.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "pipeline/facts/count_table.hpp"
#include "pipeline/facts/level_table.hpp"
#include "pipeline/facts/option_table.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::nodes {
namespace {

std::vector<container::NamedText> options_of(const facts::BuildOptions& options,
                                             const facts::FinishedNodes& finished) {
  facts::BuildOptions chosen = options;
  chosen.position_bits = finished.position_bits;
  std::vector<container::NamedText> texts = stored_options(chosen);
  texts.insert(texts.end(), finished.options.begin(), finished.options.end());
  return texts;
}

std::vector<container::NamedCount> counts_of(const facts::InputCounts& counts) {
  std::vector<container::NamedCount> named;
  for (const facts::Count& count : facts::kCounts) {
    const std::uint64_t value = counts.*count.member;
    if (count.stored == facts::Stored::kAlways ||
        (count.stored == facts::Stored::kUnlessDefault && value != 0))
      named.push_back({count.name, value});
  }
  return named;
}

std::vector<container::NamedReal> measures_of(const facts::Catalog& catalog,
                                              const facts::FinishedNodes& finished) {
  const AreaCheck areas(catalog, finished);
  std::vector<container::NamedReal> measures{{"input_area", areas.input}, {"finest_area", areas.finest}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    measures.push_back({fmt::format("min_{}", "xyz"[axis]), catalog.bounds.low[axis]});
  for (std::size_t axis = 0; axis < 3; ++axis)
    measures.push_back({fmt::format("max_{}", "xyz"[axis]), catalog.bounds.high[axis]});
  return measures;
}

std::vector<container::LevelColumn> columns_of(const std::vector<facts::LevelStatistics>& levels) {
  std::vector<std::uint64_t> numbers(levels.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  std::vector<container::LevelColumn> columns{{"level", numbers}};
  facts::for_each_level_field([&](const facts::LevelField& field, auto member) {
    if (field.column == nullptr) return;
    using Value = std::remove_cvref_t<decltype(std::invoke(member, levels.front()))>;
    std::vector<Value> values;
    values.reserve(levels.size());
    for (const facts::LevelStatistics& level : levels) values.push_back(std::invoke(member, level));
    columns.push_back({field.column, std::move(values)});
  });
  return columns;
}

container::Metadata metadata_of(const facts::BuildOptions& options, const facts::Catalog& catalog,
                                const char* scheme, const facts::FinishedNodes& finished) {
  container::Metadata metadata;
  metadata.scheme = scheme;
  metadata.lattice = finished.lattice;
  metadata.position_bits = finished.position_bits;
  metadata.has_normals = true;
  metadata.has_colors = catalog.has_colors;
  metadata.options = options_of(options, finished);
  metadata.option_meanings = finished.option_meanings;
  metadata.parameters = finished.parameters;
  for (const facts::InputFile& file : catalog.files)
    metadata.inputs.push_back({core::escaped_text(file.name), file.bytes, file.hash});
  metadata.counts = counts_of(catalog.counts);
  metadata.measures = measures_of(catalog, finished);
  metadata.levels = columns_of(finished.levels);
  return metadata;
}

}  // namespace

std::uint64_t assemble(const run::Workspace& workspace, const facts::Catalog& catalog, const char* scheme,
                       const facts::FinishedNodes& finished) {
  log_finest_level(catalog, finished);
  container::ContainerWriter writer(workspace.outputs.container.path);
  std::vector<container::NodeRow> rows;
  rows.reserve(finished.nodes.size());
  for (const facts::StoredNode& node : finished.nodes) rows.push_back(node.row);
  workspace.reporter.begin_phase("assembly", finished.nodes.size(), 0);
  writer.add_nodes(metadata_of(workspace.options, catalog, scheme, finished), std::move(rows));
  for (const facts::StoredNode& node : finished.nodes) {
    cluster::throw_if_stop_requested();
    writer.append_chunk(workspace.reader.read(node.chunk));
    workspace.reporter.finish_task();
  }
  check_not_superseded(workspace);
  writer.commit();
  return std::filesystem::file_size(workspace.outputs.container.path);
}

}  // namespace colossus::pipeline::nodes
