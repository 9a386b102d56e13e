// Small containers made without the builder: a generated mesh clipped into leaf tetrahedra; coarser
// tetrahedra are the unions of their halves, nothing is simplified. So every cut has the surface of the
// input, cut differently.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "codec/coded/weights.hpp"
#include "container/schema.hpp"
#include "geometry/lattice.hpp"
#include "mesh/mesh.hpp"
#include "reader/diamonds/extract.hpp"
#include "reader/diamonds/statue.hpp"
#include "verify/measure/distance.hpp"

namespace colossus::support {

struct WorldMesh {
  std::vector<verify::measure::WorldPoint> points;
  std::vector<mesh::Triangle> triangles;
  verify::measure::Surface surface() const { return {points, triangles}; }
};

// Closed, 2 * columns * rows triangles.
WorldMesh torus(std::size_t columns, std::size_t rows);
// An octahedron, subdivided: 8 * 4^rounds triangles.
WorldMesh sphere(int rounds);

struct FixtureNode {
  codec::coded::CodedNode mesh;
  container::NodeRow row;  // counts, bounds and mask are taken from the mesh when the fixture is written ...
  bool keeps_row = false;  // ... unless this is set
};

class DiamondsFixture {
 public:
  // With the lattice that fits the mesh, unless one is given.
  DiamondsFixture(const WorldMesh& mesh, std::size_t leaf_triangles, int position_bits = 12,
                  const std::optional<geometry::Lattice>& lattice = std::nullopt);
  ~DiamondsFixture();
  DiamondsFixture(const DiamondsFixture&) = delete;
  DiamondsFixture& operator=(const DiamondsFixture&) = delete;

  // By level and centre, as the rows will be.
  std::map<std::pair<std::uint32_t, geometry::Point>, FixtureNode> nodes;
  container::Metadata metadata;
  // Called for each payload before it is packed, so that checksums are right whatever it does.
  std::function<void(core::Bytes&)> change_payload;

  // Stores of the input and of the nodes as they stand what a build stores: done once when the fixture is
  // made, so that whatever is changed later is a fault. Shares no code with the reader.
  void describe(const WorldMesh& mesh);
  // Writes the container as it stands and opens it.
  std::unique_ptr<reader::diamonds::Statue> open(const reader::access::StatueOptions& options = {});
  void write() const;
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  void build(const WorldMesh& mesh, std::size_t leaf_triangles);
  void encode(const hierarchy::TetrahedronId& id, const mesh::Mesh& mesh);
  void set_errors();

  geometry::Lattice lattice_;
  std::filesystem::path folder_;
  std::filesystem::path path_;
};

// Puts vertices in order of first use and drops unused ones, as the codec wants it after a change.
void reorder(codec::coded::CodedPart& part);

// Sets a count or a measure by its name, for faults.
void set_count(container::Metadata& metadata, const std::string& name, std::uint64_t value);
void set_measure(container::Metadata& metadata, const std::string& name, double value);
// The column inconsistent_edges, one value per level.
void set_inconsistent_edges(container::Metadata& metadata, const std::vector<std::uint64_t>& values);
// What a build stores of the input itself; areas are square lattice units.
void describe_input(container::Metadata& metadata, const WorldMesh& mesh, double area);

// How often each edge between positions is used by triangles without two equal ones, and how often from the
// lesser end to the greater.
struct EdgeUsesAt {
  std::size_t uses = 0;
  std::size_t forward = 0;
  bool is_inconsistent() const { return uses == 2 && forward != 1; }
};
using ExactPosition = std::array<std::int64_t, 3>;
using EdgeMap = std::map<std::pair<ExactPosition, ExactPosition>, EdgeUsesAt>;
void add_edges(EdgeMap& edges, const std::vector<ExactPosition>& positions,
               const std::vector<mesh::Triangle>& triangles);
long double area_of(const std::vector<ExactPosition>& positions,
                    const std::vector<mesh::Triangle>& triangles);

// Independent of the reader: welds bit-equal points and counts the uses of edges.
struct Census {
  std::size_t border_edges = 0;
  std::size_t nonmanifold_edges = 0;
  std::size_t repeated_points = 0;  // beyond the first at a position
};
Census census_of(const reader::access::CutMesh& mesh);

}  // namespace colossus::support
