#include "pipeline/blocks/partition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/log.hpp"
#include "pipeline/blocks/long_edges.hpp"
#include "pipeline/blocks/scheme.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::blocks {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using geometry::Point;
using hierarchy::CubeId;

// More of them, and a level would be lost to a few stretched triangles for which a split does.
constexpr std::uint64_t kLongTrianglesShare = 100;

std::int64_t longest_side(const Point& p, const Point& q, const Point& r) {
  return std::max(
      {hierarchy::max_distance(p, q), hierarchy::max_distance(q, r), hierarchy::max_distance(r, p)});
}

std::int64_t longest_edge_at(int level) {
  return static_cast<std::int64_t>(
      std::floor(kGreatestSigma * static_cast<double>(std::int64_t{1} << (geometry::kRootBits - level))));
}

// Three interleaved bits per level, so that coarser cubes are prefixes.
std::uint64_t interleaved(const CubeId& cube) {
  std::uint64_t key = 0;
  for (int bit = cube.level - 1; bit >= 0; --bit)
    key = key << 3 | static_cast<std::uint64_t>((cube.z >> bit & 1) << 2 | (cube.y >> bit & 1) << 1 |
                                                (cube.x >> bit & 1));
  return key;
}

// What the triangles of some groups say about the choice of a level.
struct LevelCensus {
  std::uint64_t triangles = 0;
  std::array<std::uint64_t, kDeepestCountedLevel + 1> with_long_edges{};
  std::vector<std::uint64_t> occupied;  // cubes of the deepest counted level, ascending

  void merge(const LevelCensus& other) {
    triangles += other.triangles;
    for (std::size_t l = 0; l < with_long_edges.size(); ++l) with_long_edges[l] += other.with_long_edges[l];
    std::vector<std::uint64_t> both;
    std::set_union(occupied.begin(), occupied.end(), other.occupied.begin(), other.occupied.end(),
                   std::back_inserter(both));
    occupied = std::move(both);
  }
};

LevelCensus take_census(const ingest::Piece& group) {
  LevelCensus census;
  for (const mesh::Triangle& t : group.triangles) {
    const Point& p = group.vertices[t[0]].position;
    const Point& q = group.vertices[t[1]].position;
    const Point& r = group.vertices[t[2]].position;
    if (mesh::is_degenerate(p, q, r)) continue;
    ++census.triangles;
    const std::int64_t longest = longest_side(p, q, r);
    for (int level = 0; level <= kDeepestCountedLevel; ++level)
      census.with_long_edges[static_cast<std::size_t>(level)] += longest > longest_edge_at(level) ? 1 : 0;
    census.occupied.push_back(
        interleaved(hierarchy::cube_of_barycenter(p, q, r, kDeepestCountedLevel, geometry::kRootBits)));
  }
  std::sort(census.occupied.begin(), census.occupied.end());
  census.occupied.erase(std::unique(census.occupied.begin(), census.occupied.end()), census.occupied.end());
  return census;
}

std::uint64_t occupied_at(const LevelCensus& census, int level) {
  const int shift = 3 * (kDeepestCountedLevel - level);
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < census.occupied.size(); ++i)
    count += i == 0 || census.occupied[i] >> shift != census.occupied[i - 1] >> shift ? 1 : 0;
  return count;
}

int choose_level(const LevelCensus& census, std::uint64_t leaf_triangles) {
  int level = 0;
  while (level < kDeepestCountedLevel && census.triangles > leaf_triangles * occupied_at(census, level))
    ++level;
  while (level > 0 &&
         census.with_long_edges[static_cast<std::size_t>(level)] * kLongTrianglesShare > census.triangles)
    --level;
  return level;
}

int choose_position_bits(const facts::BuildOptions& options, const facts::Catalog& catalog, int levels) {
  const int most = std::min(codec::coded::kMaxPositionBits, geometry::kRootBits - levels);
  if (!options.tolerance) return std::min(options.position_bits, most);
  const auto error_at = [&](int bits) {
    return Grid{levels, bits}.spacing() * std::sqrt(3.0) / 2.0 * catalog.lattice.step +
           catalog.lattice.input_error();
  };
  for (int bits = codec::coded::kMinPositionBits; bits <= most; ++bits)
    if (error_at(bits) <= *options.tolerance) return bits;
  core::fail(core::Status::kUsage,
             "--tolerance {} cannot be kept: the least that can is {}, with {} bits along a cube of level "
             "{}; smaller cubes (--leaf-triangles, --levels) allow less, but not less than the lattice's {}",
             *options.tolerance, error_at(most), most, levels, catalog.lattice.input_error());
}

struct CubesCounts {
  std::uint64_t split_edges = 0;
  std::int64_t longest_edge = 0;
  buckets::EdgeCensus finest;
};

struct CubesResult {
  CubesCounts counts;
  std::vector<CubeRecord> cubes;
  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(counts);
    writer.put_array<CubeRecord>(cubes);
    return writer.take();
  }
  static CubesResult from_bytes(const Bytes& bytes) {
    ByteReader reader(bytes);
    CubesResult result;
    result.counts = reader.get<CubesCounts>();
    result.cubes = reader.get_array<CubeRecord>(reader.remaining() / sizeof(CubeRecord));
    COLOSSUS_CHECK(!reader.failed());
    return result;
  }
};

// The triangles of one cube, out of those of its bucket.
mesh::Mesh mesh_of_cube(const mesh::Mesh& bucket, std::span<const std::uint32_t> triangles,
                        std::vector<std::uint32_t>& renumbered) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  mesh::Mesh mesh;
  for (const auto i : triangles) {
    mesh::Triangle t = bucket.triangles[i];
    for (auto& v : t) {
      if (renumbered[v] == kNone) {
        renumbered[v] = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.push_back(bucket.vertices[v]);
      }
      v = renumbered[v];
    }
    mesh.triangles.push_back(t);
  }
  for (const auto i : triangles)
    for (const auto v : bucket.triangles[i]) renumbered[v] = kNone;
  return mesh;
}

// By cube, how far at most what stands for a lost triangle in it is from where that lies.
using Displacements = std::map<CubeId, double>;

void assign_to_cubes(const run::Workspace& workspace, const Grid& grid, const hierarchy::CubeId& cube,
                     const mesh::Mesh& mesh, const LongEdgeSplitter& splitter, const Displacements& of_lost,
                     CubesResult& out) {
  struct Assigned {
    CubeId id;
    std::uint32_t triangle;
  };
  std::vector<Assigned> assigned;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const mesh::Triangle& t = mesh.triangles[i];
    const Point &p = mesh.vertices[t[0]].position, &q = mesh.vertices[t[1]].position,
                &r = mesh.vertices[t[2]].position;
    const CubeId id = hierarchy::cube_of_barycenter(p, q, r, grid.levels, geometry::kRootBits);
    if (id.ancestor(cube.level) != cube) continue;
    out.counts.longest_edge = std::max(out.counts.longest_edge, longest_side(p, q, r));
    assigned.push_back({id, i});
  }
  std::stable_sort(assigned.begin(), assigned.end(),
                   [](const Assigned& a, const Assigned& b) { return a.id < b.id; });
  std::vector<std::uint32_t> renumbered(mesh.vertices.size(), ~std::uint32_t{0});
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i < assigned.size();) {
    const CubeId id = assigned[i].id;
    triangles.clear();
    double displacement = 0.0;
    for (; i < assigned.size() && assigned[i].id == id; ++i) {
      triangles.push_back(assigned[i].triangle);
      displacement = std::max(displacement, splitter.displacement(assigned[i].triangle));
    }
    if (const auto lost = of_lost.find(id); lost != of_lost.end())
      displacement = std::max(displacement, lost->second);
    const nodes::SampledMesh content{mesh_of_cube(mesh, triangles, renumbered), {}};
    out.cubes.push_back(store_cube(workspace, id, content, displacement));
  }
}

// Of what stands for lost triangles: it is one step wide, and may be cut into pieces yet.
void note_revived(const mesh::Mesh& mesh, std::size_t first, const Grid& grid, Displacements& result) {
  const std::int64_t side = std::int64_t{1} << (geometry::kRootBits - grid.levels);
  for (std::size_t i = first; i < mesh.triangles.size(); ++i) {
    const mesh::Triangle& t = mesh.triangles[i];
    const Point &p = mesh.vertices[t[0]].position, &q = mesh.vertices[t[1]].position;
    const std::int64_t steps = 8 * hierarchy::max_distance(p, q) / side + 1;
    for (std::int64_t k = 0; k <= steps; ++k) {
      // And the cubes that are as near as the next step.
      for (int corner = 0; corner < 8; ++corner) {
        Point at;
        for (int axis = 0; axis < 3; ++axis)
          at[axis] = static_cast<std::int32_t>(p[axis] + (std::int64_t{q[axis]} - p[axis]) * k / steps +
                                               ((corner >> axis & 1) != 0 ? side / 8 : -side / 8));
        const CubeId id = hierarchy::cube_of_barycenter(at, at, at, grid.levels, geometry::kRootBits);
        double& greatest = result.try_emplace(id, 0.0).first->second;
        greatest = std::max(greatest, static_cast<double>(grid.spacing()));
      }
    }
  }
}

// Of fins, which lie in the cubes of their barycentres.
Displacements displacements_of_fins(const std::vector<buckets::LostTriangle>& lost, const Grid& grid) {
  Displacements result;
  for (const buckets::LostTriangle& fin : lost) {
    if (!fin.is_fin()) continue;
    const CubeId id =
        hierarchy::cube_of_barycenter(fin.corners[0].position, fin.corners[1].position,
                                      fin.corners[2].position, grid.levels, geometry::kRootBits);
    double& greatest = result.try_emplace(id, 0.0).first->second;
    greatest = std::max(greatest, fin.displacement);
  }
  return result;
}

CubesResult make_cubes(const run::Workspace& workspace, const Grid& grid, buckets::LoadedBucket&& bucket) {
  CubesResult out;
  Displacements of_lost = displacements_of_fins(bucket.lost, grid);
  bool is_changed = false;
  const auto revive = [&](const std::vector<buckets::LostTriangle>& lost) {
    const std::size_t first = revive_lost(lost, grid.spacing(), bucket.cube, bucket.mesh).first;
    is_changed = is_changed || first < bucket.mesh.triangles.size();
    note_revived(bucket.mesh, first, grid, of_lost);
  };
  revive(bucket.lost);
  LongEdgeSplitter splitter(grid.longest_edge(), grid.spacing(), bucket.mesh);
  const std::size_t before = bucket.mesh.triangles.size();
  out.counts.split_edges = splitter.run(bucket.cube);
  is_changed = is_changed || bucket.mesh.triangles.size() != before || !splitter.lost().empty();
  revive(splitter.lost());
  out.counts.finest =
      is_changed ? buckets::census_of_edges(bucket.mesh.triangles, bucket.mesh.vertices, {}, bucket.cube)
                 : bucket.finest;
  assign_to_cubes(workspace, grid, bucket.cube, bucket.mesh, splitter, of_lost, out);
  return out;
}

}  // namespace

std::int64_t Grid::longest_edge() const { return longest_edge_at(levels); }

Grid choose_grid(const run::Workspace& workspace, const facts::Catalog& catalog,
                 std::span<const ingest::TriangleGroup> groups) {
  const std::optional<std::int64_t> levels = options_of(workspace.options).levels;
  LevelCensus census;
  run_phase(
      workspace, "census", levels ? 0 : groups.size(), [&](std::size_t i) { return group_task(groups[i]); },
      [&](std::span<const std::byte> task) {
        const LevelCensus own = take_census(ingest::load_group(workspace, catalog, task));
        ByteWriter writer;
        writer.put(own.triangles);
        writer.put(own.with_long_edges);
        writer.put_array<std::uint64_t>(own.occupied);
        return writer.take();
      },
      [&](std::size_t, const Bytes& bytes) {
        ByteReader reader(bytes);
        LevelCensus other;
        other.triangles = reader.get<std::uint64_t>();
        other.with_long_edges = reader.get<decltype(other.with_long_edges)>();
        other.occupied = reader.get_array<std::uint64_t>(reader.remaining() / sizeof(std::uint64_t));
        census.merge(other);
      });
  Grid grid;
  workspace.ranks.attempt([&] {
    if (!workspace.ranks.is_root()) return;
    const facts::BuildOptions& options = workspace.options;
    grid.levels = levels ? static_cast<std::int32_t>(*levels) : choose_level(census, options.leaf_triangles);
    grid.position_bits = choose_position_bits(options, catalog, grid.levels);
  });
  broadcast_value(workspace.ranks, grid);
  return grid;
}

Partition partition(const run::Workspace& workspace, facts::Catalog& catalog, const Grid& grid,
                    std::vector<ingest::TriangleGroup>&& groups) {
  const buckets::Rounding rounding{grid.spacing()};
  const std::vector<buckets::BucketRecord> buckets =
      make_buckets(workspace, catalog, std::move(groups), rounding, {grid.levels});
  Partition partition;
  run_phase(
      workspace, "partition", buckets.size(), [&](std::size_t i) { return bucket_task(buckets[i]); },
      [&](std::span<const std::byte> task) {
        return make_cubes(workspace, grid, buckets::load_bucket(workspace, task)).to_bytes();
      },
      [&](std::size_t, const Bytes& bytes) {
        const CubesResult result = CubesResult::from_bytes(bytes);
        catalog.counts.split_edges += result.counts.split_edges;
        partition.longest_edge = std::max(partition.longest_edge, result.counts.longest_edge);
        catalog.counts.finest_border_edges += result.counts.finest.border;
        catalog.counts.finest_nonmanifold_edges += result.counts.finest.nonmanifold;
        for (const CubeRecord& made : result.cubes)
          partition.displacement = std::max(partition.displacement, made.displacement);
        partition.cubes.insert(partition.cubes.end(), result.cubes.begin(), result.cubes.end());
      });
  release_phases_up_to(workspace, last_phase(workspace) - 1);
  std::sort(partition.cubes.begin(), partition.cubes.end(),
            [](const CubeRecord& a, const CubeRecord& b) { return a.id < b.id; });
  broadcast_value(workspace.ranks, catalog.counts);
  return partition;
}

}  // namespace colossus::pipeline::blocks
