// Small containers of the blocks scheme made without the builder: levels are made by clustering vertices in
// cells that are as large as the conditions with sigma0 allow, so closed surfaces stay closed and pinch.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "codec/coded/lattice_node.hpp"
#include "container/schema.hpp"
#include "hierarchy/octree.hpp"
#include "reader/blocks/statue.hpp"
#include "support/diamonds_fixture.hpp"

namespace colossus::support {

struct FixtureCube {
  codec::coded::CodedNode mesh = codec::coded::lattice_node();
  container::NodeRow row;  // counts and bounds are taken from the mesh when the fixture is written ...
  bool keeps_row = false;  // ... unless this is set
};

// Moves a vertex of a node on the lattice, whose offset and bits may change.
void move_vertex(codec::coded::CodedNode& node, std::size_t vertex, const geometry::Point& to);

class BlocksFixture {
 public:
  static constexpr double kRootSide = 8.0;  // world units

  // The mesh is scaled into the root cube. Its edges must be at most sigma0 * 2^-deepest sides of it.
  explicit BlocksFixture(const WorldMesh& mesh, int deepest = 3, double sigma0 = 0.25, int position_bits = 10,
                         double root_side = 8.0);
  ~BlocksFixture();
  BlocksFixture(const BlocksFixture&) = delete;
  BlocksFixture& operator=(const BlocksFixture&) = delete;

  std::map<hierarchy::CubeId, FixtureCube> nodes;
  container::Metadata metadata;
  WorldMesh input;  // as it lies in the world, not rounded to the lattice

  // Stores of the input and of the nodes as they stand what a build stores, like DiamondsFixture::describe().
  void describe();
  // Errors that are a little larger than the sampled distance from the input, or from it to the node.
  void measure_errors();
  // Writes the container as it stands, but for the order of vertices, which the codec wants to be that of
  // their first use, and opens it.
  std::unique_ptr<reader::blocks::Statue> open();
  void write() const;
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct IndexedTriangle {
    mesh::Triangle corners;  // of points_
    hierarchy::CubeId cube;
  };
  // A vertex of the input keeps its index at all levels.
  using VertexLists = std::map<hierarchy::CubeId, std::vector<std::uint32_t>>;

  void place(const WorldMesh& mesh);
  std::vector<std::uint32_t> cluster(const VertexLists& lists, int level) const;
  void build();
  void add_cube(const hierarchy::CubeId& cube, const std::vector<std::uint32_t>& list,
                const std::vector<mesh::Triangle>& triangles);

  int deepest_ = 0;
  double root_side_ = 0.0;  // world units; a power of two
  double sigma0_ = 0.0;
  std::vector<geometry::Point> points_;
  std::filesystem::path folder_;
  std::filesystem::path path_;
};

}  // namespace colossus::support
