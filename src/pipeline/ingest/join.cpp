#include "pipeline/ingest/join.hpp"

#include <algorithm>
#include <bit>

#include "cluster/stop.hpp"
#include "input/polygons.hpp"
#include "pipeline/facts/fingerprint.hpp"
#include "pipeline/ingest/radix_sort.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::ingest {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;

// A task for each group and for each range: enough of them for some dozens of ranks, and small enough that
// the largest, a group of a shuffled mesh, takes 100 MB.
constexpr std::uint64_t kTasks = 64;
constexpr std::uint64_t kLeastGroup = std::uint64_t{1} << 17;
constexpr std::uint64_t kMostGroup = std::uint64_t{1} << 19;
constexpr std::uint64_t kLeastRange = std::uint64_t{1} << 17;
constexpr std::uint64_t kMostRange = std::uint64_t{1} << 20;
// Of polygons, between looks whether a stop is requested.
constexpr std::uint64_t kCornersPerLook = 4096;

// A corner's number within its group, in the low bits of a sort key.
constexpr int kCornerBits = 21;
static_assert(3 * (kMostGroup + input::kBlockElements) <= std::uint64_t{1} << kCornerBits);

// The triangle blocks of each group: from begins[i] up to begins[i + 1].
std::vector<std::size_t> group_begins(const facts::Catalog& catalog) {
  const std::uint64_t least = group_size(catalog);
  std::vector<std::size_t> begins{0};
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < catalog.triangle_blocks.size(); ++i) {
    count += catalog.triangle_blocks[i].count;
    if (count < least && i + 1 < catalog.triangle_blocks.size()) continue;
    begins.push_back(i + 1);
    count = 0;
  }
  return begins;
}

struct GroupTask {
  std::uint64_t begin = 0;  // of the triangle blocks
  std::uint64_t end = 0;
  std::uint64_t first = 0;  // triangle, over all files
};

// The triangles of a group as they lie in scratch, and what belongs to them.
struct GroupTriangles {
  std::vector<mesh::Triangle> triangles;
  std::vector<input::Polygon> polygons;
  // Where a file of the group has face colours, by triangle; else empty.
  std::vector<mesh::Color> colors;
  std::vector<std::uint8_t> is_colored;
  std::uint64_t first = 0;  // triangle, over all files

  scratch::RecordRef store(const run::Workspace& workspace) const {
    const std::array<std::uint64_t, 3> header{polygons.size(), colors.size(), first};
    return workspace.writer.append(
        static_cast<std::uint32_t>(facts::RecordKind::kGroupTriangles),
        {std::as_bytes(std::span(header)), core::as_bytes(triangles), core::as_bytes(polygons),
         core::as_bytes(colors), core::as_bytes(is_colored)});
  }
  static GroupTriangles load(const run::Workspace& workspace, const TriangleGroup& group) {
    const Bytes bytes = workspace.reader.read(group.triangles);
    ByteReader reader(bytes);
    GroupTriangles result;
    const auto header = reader.get<std::array<std::uint64_t, 3>>();
    result.triangles = reader.get_array<mesh::Triangle>(group.triangle_count);
    result.polygons = reader.get_array<input::Polygon>(header[0]);
    result.colors = reader.get_array<mesh::Color>(header[1]);
    result.is_colored = reader.get_array<std::uint8_t>(header[1]);
    result.first = header[2];
    COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
    return result;
  }
};

TriangleGroup read_group(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  TriangleGroup group;
  group.triangle_count = reader.get<std::uint64_t>();
  group.polygon_count = reader.get<std::uint64_t>();
  group.triangles = reader.get<scratch::RecordRef>();
  group.slices = reader.get_array<VertexSlice>(reader.remaining() / sizeof(VertexSlice));
  COLOSSUS_CHECK(!reader.failed());
  return group;
}

// What a block has beside its triangles.
void read_polygons_and_colors(ByteReader& reader, const facts::RawTrianglesHeader& header,
                              std::uint32_t count, const input::ColorScale& scale, std::size_t first,
                              GroupTriangles& group) {
  for (const input::Polygon& polygon : reader.get_array<input::Polygon>(header.polygons))
    group.polygons.push_back({static_cast<std::uint32_t>(first) + polygon.first, polygon.corners});
  if (header.color_readings == 0) return;
  const auto unit = reader.get_array<mesh::Color>(count);
  const auto byte = header.color_readings == 2 ? reader.get_array<mesh::Color>(count) : unit;
  group.colors.resize(first, input::kNoColor);
  group.is_colored.resize(first, 0);
  for (std::size_t i = 0; i < count; ++i) group.colors.push_back(scale.pick(unit[i], byte[i]));
  group.is_colored.resize(first + count, 1);
}

// The corners of all triangles, sorted by the vertices that they name.
std::vector<std::uint64_t> sorted_corners(const run::Workspace& workspace, const facts::Catalog& catalog,
                                          const GroupTask& task, std::uint64_t& first_number,
                                          GroupTriangles& group) {
  std::size_t count = 0;
  group.first = task.first;
  for (std::uint64_t i = task.begin; i < task.end; ++i) count += catalog.triangle_blocks[i].count;
  std::vector<std::uint64_t> keys;
  keys.reserve(3 * count);
  for (std::uint64_t i = task.begin; i < task.end; ++i) {
    const facts::TriangleBlockRef& block = catalog.triangle_blocks[i];
    const Bytes bytes = workspace.reader.read(block.record);
    ByteReader reader(bytes);
    const auto header = reader.get<facts::RawTrianglesHeader>();
    const std::size_t first = keys.size() / 3;
    for (const mesh::Triangle& t : reader.get_array<mesh::Triangle>(block.count))
      for (const auto v : t) keys.push_back(block.first_vertex + v);
    read_polygons_and_colors(reader, header, block.count, catalog.color_scales[block.file], first, group);
    COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
  }
  if (!group.colors.empty()) {
    group.colors.resize(count, input::kNoColor);
    group.is_colored.resize(count, 0);
  }
  const auto [least, most] = std::minmax_element(keys.begin(), keys.end());
  first_number = *least;
  const auto bits = static_cast<int>(std::bit_width(*most - *least));
  COLOSSUS_CHECK(bits + kCornerBits <= 64, "{} vertices", catalog.counts.vertices);
  for (std::size_t corner = 0; corner < keys.size(); ++corner)
    keys[corner] = (keys[corner] - first_number) << kCornerBits | corner;
  radix_sort(keys, kCornerBits, kCornerBits + bits);
  return keys;
}

TriangleGroup make_group(const run::Workspace& workspace, const facts::Catalog& catalog,
                         const GroupTask& task) {
  const std::uint64_t size = range_size(catalog);
  std::uint64_t first_number = 0;
  GroupTriangles content;
  const std::vector<std::uint64_t> corners = sorted_corners(workspace, catalog, task, first_number, content);
  std::vector<mesh::Triangle>& triangles = content.triangles;
  triangles.resize(corners.size() / 3);
  TriangleGroup group;
  std::vector<std::uint32_t> offsets;  // of the range at hand
  const auto finish_range = [&] {
    if (offsets.empty()) return;
    group.slices.back().count = static_cast<std::uint32_t>(offsets.size());
    group.slices.back().record = workspace.writer.append(
        static_cast<std::uint32_t>(facts::RecordKind::kRequest), core::as_bytes(offsets));
    offsets.clear();
  };
  std::uint32_t index = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint64_t number = first_number + (corners[i] >> kCornerBits);
    if (i == 0 || corners[i] >> kCornerBits != corners[i - 1] >> kCornerBits) {
      if (i > 0) ++index;
      const auto range = static_cast<std::uint32_t>(number / size);
      if (group.slices.empty() || group.slices.back().range != range) {
        finish_range();
        group.slices.push_back({range, 0, {}});
      }
      offsets.push_back(static_cast<std::uint32_t>(number % size));
    }
    const std::uint64_t corner = corners[i] & ((std::uint64_t{1} << kCornerBits) - 1);
    triangles[corner / 3][corner % 3] = index;
  }
  finish_range();
  group.triangle_count = triangles.size();
  group.polygon_count = content.polygons.size();
  workspace.reporter.add_triangles(group.triangle_count);
  group.triangles = content.store(workspace);
  return group;
}

// Calls visit(first, positions, normals, colors) for the blocks of a range of vertices, the arrays being
// those of the vertices `first`, `first` + 1 ... of the range.
template <typename Visit>
void visit_range(const run::Workspace& workspace, const facts::Catalog& catalog, std::uint64_t range,
                 const Visit& visit) {
  const std::uint64_t begin = range * range_size(catalog);
  const std::uint64_t end = std::min(begin + range_size(catalog), catalog.counts.vertices);
  const auto& blocks = catalog.vertex_blocks;
  auto block = std::partition_point(blocks.begin(), blocks.end(), [&](const facts::VertexBlockRef& b) {
    return b.first + b.count <= begin;
  });
  for (; block != blocks.end() && block->first < end; ++block) {
    const Bytes raw = workspace.reader.read(block->record);
    ByteReader reader(raw);
    const auto header = reader.get<facts::RawVerticesHeader>();
    const auto positions = reader.get_array<std::array<double, 3>>(block->count);
    const auto normals = reader.get_array<std::array<float, 3>>(header.has_normals != 0 ? block->count : 0);
    auto colors = reader.get_array<mesh::Color>(header.color_readings != 0 ? block->count : 0);
    const auto byte_colors = reader.get_array<mesh::Color>(header.color_readings == 2 ? block->count : 0);
    for (std::size_t i = 0; i < byte_colors.size(); ++i)
      colors[i] = catalog.color_scales[block->file].pick(colors[i], byte_colors[i]);
    COLOSSUS_CHECK(!reader.failed(), "a checked scratch record has the wrong size");
    const std::size_t from = begin > block->first ? begin - block->first : 0;
    const std::size_t to = std::min<std::uint64_t>(block->count, end - block->first);
    const auto part = [&](const auto& values) {
      return values.empty() ? std::span(values) : std::span(values).subspan(from, to - from);
    };
    visit(block->first + from - begin, part(positions), part(normals), part(colors));
  }
}

// The vertices of a range that are asked for.
class RequestedOffsets {
 public:
  RequestedOffsets(const run::Workspace& workspace, const facts::Catalog& catalog,
                   std::span<const std::byte> task)
      : is_used_(range_size(catalog), false) {
    ByteReader reader(task);
    range_ = reader.get<std::uint64_t>();
    while (reader.remaining() > 0) {
      const auto slice = reader.get<VertexSlice>();
      const Bytes bytes = workspace.reader.read(slice.record);
      offsets_.push_back(ByteReader(bytes).get_array<std::uint32_t>(slice.count));
      for (const auto offset : offsets_.back()) is_used_.at(offset) = true;
    }
    COLOSSUS_CHECK(!reader.failed());
  }
  std::uint64_t range() const { return range_; }
  // By slice of the task.
  const std::vector<std::vector<std::uint32_t>>& offsets() const { return offsets_; }
  bool has(std::size_t offset) const { return is_used_[offset]; }

 private:
  std::uint64_t range_ = 0;
  std::vector<std::vector<std::uint32_t>> offsets_;
  std::vector<bool> is_used_;
};

// The vertices of a range on the lattice; of those that nobody asks for nothing is known.
std::vector<mesh::Vertex> load_range(const run::Workspace& workspace, const facts::Catalog& catalog,
                                     const RequestedOffsets& requested) {
  std::vector<mesh::Vertex> vertices;
  visit_range(
      workspace, catalog, requested.range(),
      [&](std::size_t first, const auto& positions, const auto& normals, const auto& colors) {
        vertices.resize(first + positions.size());
        for (std::size_t i = 0; i < positions.size(); ++i) {
          if (!requested.has(first + i)) continue;
          mesh::Vertex& v = vertices[first + i];
          v.position = catalog.lattice.input_vertex(positions[i]);
          v.fingerprint = facts::fingerprint_of(positions[i]);
          v.normal = {0, 0, 0};
          if (!normals.empty() && (normals[i][0] != 0.0F || normals[i][1] != 0.0F || normals[i][2] != 0.0F))
            v.normal = geometry::to_normal16(normals[i][0], normals[i][1], normals[i][2]);
          if (!colors.empty()) v.color = colors[i];
        }
      });
  return vertices;
}

Bytes answer_range(const run::Workspace& workspace, const facts::Catalog& catalog,
                   std::span<const std::byte> task) {
  const RequestedOffsets requested(workspace, catalog, task);
  const std::vector<mesh::Vertex> vertices = load_range(workspace, catalog, requested);
  ByteWriter answers;
  for (const std::vector<std::uint32_t>& offsets : requested.offsets()) {
    PackedVertices packed(catalog, offsets.size());
    for (const auto offset : offsets) packed.add(vertices.at(offset));
    answers.put(workspace.writer.append(
        static_cast<std::uint32_t>(facts::RecordKind::kAnswer),
        {core::as_bytes(offsets), packed.positions(), packed.normals(), packed.colors()}));
  }
  return answers.take();
}

}  // namespace

std::uint64_t group_size(const facts::Catalog& catalog) {
  return std::clamp(catalog.counts.triangles / kTasks, kLeastGroup, kMostGroup);
}

std::uint64_t range_size(const facts::Catalog& catalog) {
  return std::clamp(std::bit_ceil(catalog.counts.vertices / kTasks + 1), kLeastRange, kMostRange);
}

RequestedRanges::RequestedRanges(const facts::Catalog& catalog, const std::vector<TriangleGroup>& groups)
    : groups_(groups) {
  std::vector<std::vector<Asker>> by_range(catalog.counts.vertices / range_size(catalog) + 1);
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (std::uint32_t s = 0; s < groups[g].slices.size(); ++s)
      by_range[groups[g].slices[s].range].push_back({g, s});
  for (std::uint64_t r = 0; r < by_range.size(); ++r) {
    if (by_range[r].empty()) continue;
    ranges_.push_back(r);
    askers_.push_back(std::move(by_range[r]));
  }
}

Bytes RequestedRanges::task(std::size_t i) const {
  ByteWriter writer;
  writer.put(ranges_[i]);
  for (const Asker& asker : askers_[i]) writer.put(groups_[asker.group].slices[asker.slice]);
  return writer.take();
}

std::vector<VertexSlice*> RequestedRanges::slices(std::size_t i, std::vector<TriangleGroup>& groups) const {
  std::vector<VertexSlice*> slices;
  for (const Asker& asker : askers_[i]) slices.push_back(&groups[asker.group].slices[asker.slice]);
  return slices;
}

void visit_requested(const run::Workspace& workspace, const facts::Catalog& catalog,
                     std::span<const std::byte> task,
                     const std::function<void(std::uint64_t, const std::array<double, 3>&)>& visit) {
  const RequestedOffsets requested(workspace, catalog, task);
  const std::uint64_t begin = requested.range() * range_size(catalog);
  visit_range(workspace, catalog, requested.range(),
              [&](std::size_t first, const auto& positions, const auto&, const auto&) {
                for (std::size_t i = 0; i < positions.size(); ++i)
                  if (requested.has(first + i)) visit(begin + first + i, positions[i]);
              });
}

std::vector<TriangleGroup> request_vertices(const run::Workspace& workspace, const facts::Catalog& catalog) {
  const std::vector<std::size_t> begins = group_begins(catalog);
  std::vector<TriangleGroup> groups(workspace.ranks.is_root() ? begins.size() - 1 : 0);
  std::vector<std::uint64_t> firsts{0};
  for (std::size_t g = 0; g + 1 < begins.size(); ++g) {
    firsts.push_back(firsts.back());
    for (std::size_t i = begins[g]; i < begins[g + 1]; ++i) firsts.back() += catalog.triangle_blocks[i].count;
  }
  run_phase(
      workspace, "requests", begins.size() - 1,
      [&](std::size_t i) {
        ByteWriter writer;
        writer.put(GroupTask{begins[i], begins[i + 1], firsts[i]});
        return writer.take();
      },
      [&](std::span<const std::byte> task) {
        return group_task(make_group(workspace, catalog, ByteReader(task).get<GroupTask>()));
      },
      [&](std::size_t i, const Bytes& result) { groups[i] = read_group(result); });
  return groups;
}

void answer_requests(const run::Workspace& workspace, const facts::Catalog& catalog,
                     std::vector<TriangleGroup>& groups) {
  const RequestedRanges ranges(catalog, groups);
  // Results overwrite the requests that later tasks are made of, so they are kept until all are there.
  std::vector<std::vector<scratch::RecordRef>> answers(ranges.size());
  run_phase(
      workspace, "answers", ranges.size(), [&](std::size_t i) { return ranges.task(i); },
      [&](std::span<const std::byte> task) { return answer_range(workspace, catalog, task); },
      [&](std::size_t i, const Bytes& result) {
        answers[i] =
            ByteReader(result).get_array<scratch::RecordRef>(result.size() / sizeof(scratch::RecordRef));
      });
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::vector<VertexSlice*> slices = ranges.slices(i, groups);
    COLOSSUS_CHECK(slices.size() == answers[i].size());
    for (std::size_t k = 0; k < slices.size(); ++k) slices[k]->record = answers[i][k];
  }
}

Bytes group_task(const TriangleGroup& group) {
  ByteWriter writer;
  writer.put(group.triangle_count);
  writer.put(group.polygon_count);
  writer.put(group.triangles);
  writer.put_array<VertexSlice>(group.slices);
  return writer.take();
}

namespace {

// The vertices of a group.
void load_slices(const run::Workspace& workspace, const facts::Catalog& catalog, const TriangleGroup& group,
                 Piece& piece) {
  const std::uint64_t size = range_size(catalog);
  std::size_t count = 0;
  for (const VertexSlice& slice : group.slices) count += slice.count;
  piece.numbers.reserve(count);
  piece.vertices.reserve(count);
  for (const VertexSlice& slice : group.slices) {
    const Bytes bytes = workspace.reader.read(slice.record);
    ByteReader answer(bytes);
    for (const auto offset : answer.get_array<std::uint32_t>(slice.count))
      piece.numbers.push_back(slice.range * size + offset);
    PackedVertices::read(catalog, answer, slice.count, piece.vertices);
  }
}

// Only so are colours of faces averaged over all triangles around a position, whichever bucket has them.
void give_corners_vertices(const GroupTriangles& group, Piece& piece) {
  const std::size_t corners =
      3 * static_cast<std::size_t>(std::count(group.is_colored.begin(), group.is_colored.end(), 1));
  piece.vertices.reserve(piece.vertices.size() + corners);
  piece.numbers.reserve(piece.numbers.size() + corners);
  for (std::size_t i = 0; i < piece.triangles.size(); ++i) {
    if (group.is_colored[i] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      auto& v = piece.triangles[i][k];
      mesh::Vertex vertex = piece.vertices[v];
      const std::uint64_t number = piece.numbers[v];
      vertex.color = group.colors[i];
      v = static_cast<std::uint32_t>(piece.vertices.size());
      piece.vertices.push_back(vertex);
      piece.numbers.push_back(face_corner_number(number, 3 * (group.first + i) + k));
    }
  }
}

// Of a group with polygons; what its task returns.
struct CutGroup {
  scratch::RecordRef triangles;
  input::OddPolygons odd;
};

CutGroup cut_group(const run::Workspace& workspace, const facts::Catalog& catalog,
                   const TriangleGroup& group) {
  Piece piece;
  load_slices(workspace, catalog, group, piece);
  GroupTriangles content = GroupTriangles::load(workspace, group);
  input::PolygonCutter cutter;
  std::uint64_t corners = kCornersPerLook;
  for (const input::Polygon& polygon : content.polygons) {
    if ((corners += polygon.corners) >= kCornersPerLook) {
      cluster::throw_if_stop_requested();
      corners = 0;
    }
    cutter.cut(std::span(content.triangles).subspan(polygon.first, polygon.corners - 2),
               [&](std::uint32_t v) { return piece.vertices[v].position; });
  }
  workspace.reporter.add_triangles(group.triangle_count);
  return {content.store(workspace), cutter.odd()};
}

}  // namespace

void cut_polygons(const run::Workspace& workspace, facts::Catalog& catalog,
                  std::vector<TriangleGroup>& groups) {
  std::vector<std::size_t> with_polygons;
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (groups[g].polygon_count > 0) with_polygons.push_back(g);
  std::uint64_t count = with_polygons.size();
  broadcast_value(workspace.ranks, count);
  if (count == 0) return;
  input::OddPolygons odd;
  // Results overwrite what later tasks are made of, so they are kept until all are there.
  std::vector<scratch::RecordRef> records(count);
  run_phase(
      workspace, "polygons", count, [&](std::size_t i) { return group_task(groups[with_polygons[i]]); },
      [&](std::span<const std::byte> task) {
        ByteWriter writer;
        writer.put(cut_group(workspace, catalog, read_group(task)));
        return writer.take();
      },
      [&](std::size_t i, const Bytes& bytes) {
        const auto result = ByteReader(bytes).get<CutGroup>();
        records[i] = result.triangles;
        odd.merge(result.odd);
      });
  for (std::size_t i = 0; i < with_polygons.size(); ++i) groups[with_polygons[i]].triangles = records[i];
  broadcast_value(workspace.ranks, odd);
  catalog.counts.concave_polygons = odd.concave;
  catalog.counts.warped_polygons = odd.warped;
  catalog.counts.crossing_polygons = odd.crossing;
}

Piece load_group(const run::Workspace& workspace, const facts::Catalog& catalog,
                 std::span<const std::byte> task) {
  const TriangleGroup group = read_group(task);
  Piece piece;
  load_slices(workspace, catalog, group, piece);
  GroupTriangles content = GroupTriangles::load(workspace, group);
  piece.triangles = std::move(content.triangles);
  if (!content.colors.empty()) give_corners_vertices(content, piece);
  workspace.reporter.add_triangles(group.triangle_count);
  return piece;
}

}  // namespace colossus::pipeline::ingest
