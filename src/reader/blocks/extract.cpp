#include "reader/blocks/extract.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "geometry/octahedral.hpp"
#include "reader/access/parallel.hpp"

namespace colossus::reader::blocks {
namespace {

using Position = std::array<double, 3>;
using OctahedralCode = std::array<std::uint8_t, 2>;

constexpr std::size_t kBatch = 64;  // nodes decoded at a time

// A cube as it is drawn.
struct DrawnCube {
  std::vector<Position> positions;  // world
  codec::coded::CodedNode node;     // its positions are where they were, its attributes as drawn
};

Position blend(const geometry::Point& own, const geometry::Point& parent, double lambda) {
  Position result{};
  for (int axis = 0; axis < 3; ++axis)
    result[static_cast<std::size_t>(axis)] = lambda * own[axis] + (1.0 - lambda) * parent[axis];
  return result;
}

OctahedralCode blend(const OctahedralCode& own, const OctahedralCode& parent, double lambda) {
  const Position a = geometry::decode_octahedral(own);
  const Position b = geometry::decode_octahedral(parent);
  Position n{};
  for (std::size_t axis = 0; axis < 3; ++axis) n[axis] = lambda * a[axis] + (1.0 - lambda) * b[axis];
  // Opposite directions have none between them.
  if (!(std::hypot(n[0], n[1], n[2]) > 1e-6)) return own;
  return geometry::encode_octahedral(geometry::to_normal16(n[0], n[1], n[2]));
}

mesh::Color blend(const mesh::Color& own, const mesh::Color& parent, double lambda) {
  mesh::Color result{};
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = static_cast<std::uint8_t>(std::floor(lambda * own[i] + (1.0 - lambda) * parent[i] + 0.5));
  return result;
}

// Draws vertex i between itself and its parent in `coarser`.
void morph_vertex(const Statue& statue, const codec::coded::CodedNode& coarser, std::size_t i, double lambda,
                  DrawnCube& drawn) {
  codec::coded::CodedPart& mesh = drawn.node.parts[0];
  const codec::coded::CodedPart& parents = coarser.parts[0];
  const std::uint32_t parent = mesh.parents[i];
  const geometry::Point own_place = lattice_position(drawn.node, i);
  const geometry::Point parent_place = lattice_position(coarser, parent);
  // At the end of the way nothing is computed: whoever draws the parent itself must get the same bits.
  drawn.positions[i] =
      lambda > 0.0 ? statue.world(blend(own_place, parent_place, lambda)) : statue.world(parent_place);
  if (drawn.node.has_normals)
    mesh.normals[i] =
        lambda > 0.0 ? blend(mesh.normals[i], parents.normals[parent], lambda) : parents.normals[parent];
  if (drawn.node.has_colors)
    mesh.colors[i] =
        lambda > 0.0 ? blend(mesh.colors[i], parents.colors[parent], lambda) : parents.colors[parent];
}

DrawnCube draw(const Statue& statue, const Cut& cut, access::RowIndex row) {
  DrawnCube drawn{{}, statue.load(row)};
  const codec::coded::CodedPart& mesh = drawn.node.parts[0];
  const std::size_t count = mesh.positions.size();
  drawn.positions.resize(count);
  const int level = statue.cube(row).level;
  std::shared_ptr<const codec::coded::CodedNode> coarser;
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Point place = lattice_position(drawn.node, i);
    const double lambda = cut.morph ? cut.morph->lambda(place, level) : 1.0;
    if (lambda == 1.0) {
      drawn.positions[i] = statue.world(place);
      continue;
    }
    if (!coarser) {
      const access::RowIndex parent = statue.parent(row);
      if (parent == access::kNoRow)
        core::fail(core::Status::kBadData, "{}: node at {}: its parent cube has no node",
                   statue.container().path().string(), statue.name(row));
      coarser = statue.node(parent);
    }
    if (mesh.parents[i] >= coarser->parts[0].positions.size())
      core::fail(core::Status::kBadData, "{}: node at {}: vertex {} has parent {} of {}",
                 statue.container().path().string(), statue.name(row), i, mesh.parents[i],
                 coarser->parts[0].positions.size());
    morph_vertex(statue, *coarser, i, lambda, drawn);
  }
  return drawn;
}

void append(const DrawnCube& drawn, access::CutMesh& mesh) {
  const codec::coded::CodedPart& cube = drawn.node.parts[0];
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Position& p : drawn.positions) mesh.add_position(p);
  mesh.normals.insert(mesh.normals.end(), cube.normals.begin(), cube.normals.end());
  mesh.colors.insert(mesh.colors.end(), cube.colors.begin(), cube.colors.end());
  for (const mesh::Triangle& t : cube.triangles)
    mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  mesh.stored_triangles += cube.triangles.size();
}

}  // namespace

access::CutMesh assemble(const Statue& statue, const Cut& cut) {
  std::vector<access::RowIndex> drawn;
  for (const access::RowIndex row : cut.rows)
    if (statue.rows()[row].triangles > 0) drawn.push_back(row);
  access::CutMesh mesh;
  for (std::size_t begin = 0; begin < drawn.size(); begin += kBatch) {
    std::vector<DrawnCube> batch(std::min(kBatch, drawn.size() - begin));
    access::parallel_for(batch.size(),
                         [&](std::size_t i) { batch[i] = draw(statue, cut, drawn[begin + i]); });
    for (const DrawnCube& cube : batch) append(cube, mesh);
  }
  weld(mesh);
  return mesh;
}

access::Extraction Statue::extract(const access::CutRequest& request) const {
  return access::extract_cut(*this, request);
}

}  // namespace colossus::reader::blocks
