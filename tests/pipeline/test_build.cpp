#include "pipeline/test_build.hpp"

#include <algorithm>

namespace colossus::pipeline {
namespace {

template <typename T>
std::span<const std::byte> part_of(const std::vector<T>& values, std::size_t first, std::size_t count) {
  return values.empty() ? std::span<const std::byte>()
                        : core::as_bytes(std::span(values).subspan(first, count));
}

scratch::RecordRef store_vertices(const run::Workspace& workspace, const MadeUpFile& file, std::size_t first,
                                  std::size_t count) {
  const facts::RawVerticesHeader header{file.normals.empty() ? 0U : 1U, file.colors.empty()        ? 0U
                                                                        : file.byte_colors.empty() ? 1U
                                                                                                   : 2U};
  return workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kRawVertices),
                                 {std::as_bytes(std::span(&header, 1)), part_of(file.positions, first, count),
                                  part_of(file.normals, first, count), part_of(file.colors, first, count),
                                  part_of(file.byte_colors, first, count)});
}

scratch::RecordRef store_triangles(const run::Workspace& workspace, const MadeUpFile& file, std::size_t first,
                                   std::size_t count) {
  const facts::RawTrianglesHeader header{static_cast<std::uint32_t>(file.polygons.size()),
                                         file.face_colors.empty() ? 0U : 1U};
  return workspace.writer.append(static_cast<std::uint32_t>(facts::RecordKind::kTriangles),
                                 {std::as_bytes(std::span(&header, 1)), part_of(file.triangles, first, count),
                                  core::as_bytes(file.polygons), part_of(file.face_colors, first, count)});
}

}  // namespace

facts::Catalog store_files(const run::Workspace& workspace, const std::vector<MadeUpFile>& files,
                           std::size_t block_vertices, std::size_t block_triangles) {
  facts::Catalog catalog;
  std::vector<std::size_t> firsts;  // of the blocks, within their file: of vertices, then of triangles
  std::uint64_t next_vertex = 0;
  for (std::uint32_t f = 0; f < files.size(); ++f) {
    const MadeUpFile& file = files[f];
    catalog.files.push_back({fmt::format("made-up-{}.ply", f), 0, "", !file.normals.empty(),
                             !file.colors.empty() || !file.face_colors.empty()});
    catalog.color_scales.push_back({false, true});
    catalog.has_normals |= !file.normals.empty();
    catalog.has_colors |= catalog.files.back().has_colors;
    catalog.has_face_colors |= !file.face_colors.empty();
    for (std::size_t i = 0; i < file.positions.size(); i += block_vertices) {
      const std::size_t count = std::min(block_vertices, file.positions.size() - i);
      catalog.vertex_blocks.push_back({f, static_cast<std::uint32_t>(count), next_vertex + i, {}});
      firsts.push_back(i);
    }
    catalog.counts.triangles += file.triangles.size();
    catalog.counts.polygons += file.polygons.size();
    next_vertex += file.positions.size();
  }
  catalog.counts.vertices = next_vertex;
  const std::size_t vertex_blocks = firsts.size();
  next_vertex = 0;
  for (std::uint32_t f = 0; f < files.size(); ++f) {
    const std::size_t size = files[f].polygons.empty() ? block_triangles : files[f].triangles.size();
    for (std::size_t i = 0; i < files[f].triangles.size(); i += size) {
      const std::size_t count = std::min(size, files[f].triangles.size() - i);
      catalog.triangle_blocks.push_back({f, static_cast<std::uint32_t>(count), next_vertex, {}});
      firsts.push_back(i);
    }
    next_vertex += files[f].positions.size();
  }
  run_phase(
      workspace, "made-up files", firsts.size(),
      [](std::size_t i) {
        core::ByteWriter writer;
        writer.put(i);
        return writer.take();
      },
      [&](std::span<const std::byte> task) {
        const auto i = core::ByteReader(task).get<std::size_t>();
        core::ByteWriter writer;
        if (i < vertex_blocks) {
          const facts::VertexBlockRef& block = catalog.vertex_blocks[i];
          writer.put(store_vertices(workspace, files[block.file], firsts[i], block.count));
        } else {
          const facts::TriangleBlockRef& block = catalog.triangle_blocks[i - vertex_blocks];
          writer.put(store_triangles(workspace, files[block.file], firsts[i], block.count));
        }
        return writer.take();
      },
      [&](std::size_t i, const core::Bytes& result) {
        const auto record = core::ByteReader(result).get<scratch::RecordRef>();
        if (i < vertex_blocks)
          catalog.vertex_blocks[i].record = record;
        else
          catalog.triangle_blocks[i - vertex_blocks].record = record;
      });
  broadcast_values(workspace.ranks, catalog.vertex_blocks);
  broadcast_values(workspace.ranks, catalog.triangle_blocks);
  return catalog;
}

void fit_lattice(facts::Catalog& catalog, const std::vector<MadeUpFile>& files) {
  for (const MadeUpFile& file : files)
    for (const auto& position : file.positions) catalog.bounds.add(position);
  catalog.lattice = geometry::Lattice::fit(catalog.bounds);
}

}  // namespace colossus::pipeline
