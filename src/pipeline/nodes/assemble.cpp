#include "pipeline/nodes/assemble.hpp"

#include "cluster/stop.hpp"
#include "container/writer.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "pipeline/nodes/finest_level.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::nodes {
namespace {

container::Metadata metadata_of(const facts::BuildOptions& options, const facts::Catalog& catalog,
                                const char* scheme, const facts::Hierarchy& hierarchy) {
  container::Metadata metadata;
  metadata.scheme = scheme;
  metadata.lattice = hierarchy.lattice;
  metadata.position_bits = hierarchy.position_bits;
  metadata.has_normals = true;
  metadata.has_colors = catalog.has_colors;
  metadata.options = {{"leaf_triangles", fmt::format("{}", options.leaf_triangles)},
                      {"position_bits", fmt::format("{}", hierarchy.position_bits)},
                      {"codec", options.codec}};
  if (options.tolerance) metadata.options.push_back({"tolerance", fmt::format("{}", *options.tolerance)});
  if (options.keep_outliers) metadata.options.push_back({"keep_outliers", "true"});
  if (options.drop_textures) metadata.options.push_back({"drop_textures", "true"});
  if (options.is_lenient) metadata.options.push_back({"lenient", "true"});
  metadata.options.insert(metadata.options.end(), hierarchy.options.begin(), hierarchy.options.end());
  metadata.parameters = hierarchy.parameters;
  for (const facts::InputFile& file : catalog.files)
    metadata.inputs.push_back({core::escaped_text(file.name), file.bytes, file.hash});
  const facts::InputCounts& c = catalog.counts;
  std::uint64_t above_limit = 0;
  for (const facts::LevelStatistics& level : hierarchy.levels) above_limit += level.leaves_above_limit;
  metadata.counts = {{"vertices", c.vertices},
                     {"triangles", c.triangles},
                     {"polygons", c.polygons},
                     {"small_faces", c.small_faces},
                     {"degenerate", c.degenerate},
                     {"collapsed", c.collapsed},
                     {"duplicate", c.duplicate},
                     {"opposite", c.opposite},
                     {"collinear", c.collinear},
                     {"border_edges", c.border_edges},
                     {"nonmanifold_edges", c.nonmanifold_edges},
                     {"inconsistent_edges", c.inconsistent_edges},
                     {"merged_vertices", c.merged_vertices},
                     {"attribute_seams", c.attribute_seams},
                     {"leaves_above_limit", above_limit},
                     {"finest_triangles", hierarchy.finest_triangles()},
                     {"finest_border_edges", c.finest_border_edges},
                     {"finest_nonmanifold_edges", c.finest_nonmanifold_edges}};
  const AreaCheck areas(catalog, hierarchy);
  metadata.counts.push_back({"area_differs", areas.differs() ? 1U : 0U});
  metadata.measures = {{"input_area", areas.input}, {"finest_area", areas.finest}};
  const geometry::Bounds& bounds = catalog.bounds;
  for (std::size_t axis = 0; axis < 3; ++axis)
    metadata.measures.push_back({fmt::format("min_{}", "xyz"[axis]), bounds.low[axis]});
  for (std::size_t axis = 0; axis < 3; ++axis)
    metadata.measures.push_back({fmt::format("max_{}", "xyz"[axis]), bounds.high[axis]});
  if (c.split_edges > 0) metadata.counts.push_back({"split_edges", c.split_edges});
  const auto add = [&](const char* name, auto value_of) {
    std::vector<std::uint64_t> values;
    for (const facts::LevelStatistics& level : hierarchy.levels) values.push_back(value_of(level));
    metadata.levels.push_back({name, values});
  };
  const auto add_real = [&](const char* name, auto value_of) {
    std::vector<double> values;
    for (const facts::LevelStatistics& level : hierarchy.levels) values.push_back(value_of(level));
    metadata.levels.push_back({name, values});
  };
  using Level = facts::LevelStatistics;
  std::uint64_t number = 0;
  add("level", [&](const Level&) { return number++; });
  add("nodes", [](const Level& l) { return l.nodes; });
  add("leaves", [](const Level& l) { return l.leaves; });
  add("vertices", [](const Level& l) { return l.vertices; });
  add("triangles", [](const Level& l) { return l.triangles; });
  add("payload_bytes", [](const Level& l) { return l.payload_bytes; });
  add("stored_bytes", [](const Level& l) { return l.stored_bytes; });
  // Named as in info's table.
  constexpr codec::coded::PerComponent<const char*> kColumns{"connectivity_bytes", "position_bytes",
                                                             "normal_bytes", "color_bytes", "parent_bytes"};
  for (std::size_t i = 0; i < codec::coded::kComponentCount; ++i)
    add(kColumns[i], [i](const Level& l) { return l.component_bytes[i]; });
  add_real("error", [](const Level& l) { return l.error; });
  add_real("quantization_error", [](const Level& l) { return l.displacement; });
  add("initial_triangles", [](const Level& l) { return l.sums.initial_triangles; });
  add("target_triangles", [](const Level& l) { return l.sums.target_triangles; });
  add("reached_triangles", [](const Level& l) { return l.sums.reached_triangles; });
  add("initial_vertices", [](const Level& l) { return l.sums.initial_vertices; });
  add("locked_vertices", [](const Level& l) { return l.sums.locked_vertices; });
  add("angle_below_5", [](const Level& l) { return l.sums.angles.below_5_degrees; });
  add("angle_below_15", [](const Level& l) { return l.sums.angles.below_15_degrees; });
  add("angle_below_30", [](const Level& l) { return l.sums.angles.below_30_degrees; });
  add("inconsistent_edges", [](const Level& l) { return l.sums.inconsistent_edges; });
  return metadata;
}

}  // namespace

std::uint64_t assemble(const run::Workspace& workspace, const facts::Catalog& catalog, const char* scheme,
                       const facts::Hierarchy& hierarchy) {
  log_finest_level(catalog, hierarchy);
  container::ContainerWriter writer(workspace.outputs.container.path);
  std::vector<container::NodeRow> rows;
  rows.reserve(hierarchy.nodes.size());
  for (const facts::StoredNode& node : hierarchy.nodes) rows.push_back(node.row);
  workspace.reporter.begin_phase("assembly", hierarchy.nodes.size(), 0);
  writer.add_nodes(metadata_of(workspace.options, catalog, scheme, hierarchy), std::move(rows));
  for (const facts::StoredNode& node : hierarchy.nodes) {
    cluster::throw_if_stop_requested();
    writer.append_chunk(workspace.reader.read(node.chunk));
    workspace.reporter.finish_task();
  }
  check_not_superseded(workspace);
  writer.commit();
  return std::filesystem::file_size(workspace.outputs.container.path);
}

}  // namespace colossus::pipeline::nodes
