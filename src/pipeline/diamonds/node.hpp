// One node of the hierarchy as a task: from the tetrahedra in scratch to a chunk, and to tetrahedra for its
// parents.
#pragma once

#include "codec/codec.hpp"
#include "codec/quantization/quantize.hpp"
#include "geometry/lattice.hpp"
#include "pipeline/diamonds/tetrahedron_mesh.hpp"
#include "pipeline/facts/finished_nodes.hpp"
#include "simplify/region.hpp"

namespace colossus::pipeline::diamonds {

// A tetrahedron to build a node from: for a leaf the tetrahedron itself, else one half of the tetrahedron at
// `place`.
struct NodePart {
  std::uint32_t place = 0;
  std::uint32_t end = 0;  // which half: the one with this end of the long edge; unused for leaves
  std::uint32_t triangles = 0;
  std::uint32_t padding = 0;
  scratch::RecordRef record;
};

struct NodeTask {
  hierarchy::Point center;
  bool is_leaf = false;
  double least_error = 0.0;  // of the children, world units
  std::vector<NodePart> parts;

  core::Bytes to_bytes() const;
  static NodeTask from_bytes(std::span<const std::byte> bytes);
};

struct NodeResult {
  facts::FinishedNode node;
  std::vector<TetrahedronRecord> tetrahedra;  // empty for leaves: they are in scratch already

  core::Bytes to_bytes() const;
  static NodeResult from_bytes(std::span<const std::byte> bytes);
};

// What all nodes of a build share.
struct NodeSettings {
  geometry::Lattice lattice;
  codec::quantization::QuantizeOptions quantize;
  const codec::Codec* codec = nullptr;
  std::uint64_t leaf_triangles = 0;
  std::uint64_t floor_triangles = 0;
  double input_error = 0.0;  // world units, by which the lattice moved the input
};

// An upper estimate of the memory of build_node() for so many triangles of its parts: these are freed once
// they have become a region, and then that is simplified.
std::uint64_t task_bytes(std::uint64_t triangles);

// Simplifies (unless it is a leaf), quantises, encodes and packs one node; appends chunk and tetrahedra to
// scratch. Not collective; this is where the time of a build goes.
NodeResult build_node(const run::Workspace& workspace, const NodeSettings& settings, const NodeTask& task);

}  // namespace colossus::pipeline::diamonds
