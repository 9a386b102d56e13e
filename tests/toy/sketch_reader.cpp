#include "toy/sketch_reader.hpp"

#include "codec/coded/lattice_node.hpp"
#include "codec/node_codec.hpp"
#include "core/error.hpp"
#include "geometry/lattice.hpp"
#include "toy/sketch.hpp"

namespace colossus::toy {

using reader::access::AtLevel;
using reader::access::Eye;
using reader::access::RowIndex;
using reader::access::RowRange;
using reader::access::WithError;
using reader::access::WithTriangles;

Statue::Statue(container::ContainerReader container, const reader::access::StatueOptions&)
    : reader::access::Statue(std::move(container), kSketch) {
  if (deepest_level() != kFinestLevel || rows_of_level(0).size() != 1)
    core::fail(core::Status::kBadData, "{}: expected one node at level 0, and others at level {}",
               this->container().path().string(), kFinestLevel);
}

double Statue::lattice_error() const {
  return geometry::Lattice{metadata().lattice.origin, metadata().lattice.step}.input_error();
}

codec::coded::CodedNode Statue::load(RowIndex row) const {
  return decode_node(row, &codec::decode_on_lattice);
}

std::array<double, 3> Statue::world(const geometry::Point& p) const {
  const container::LatticeInfo& lattice = metadata().lattice;
  return {lattice.origin[0] + lattice.step * p.x, lattice.origin[1] + lattice.step * p.y,
          lattice.origin[2] + lattice.step * p.z};
}

reader::access::Extraction Statue::extract(const reader::access::CutRequest& request) const {
  struct Chooser {
    const Statue& statue;
    std::uint32_t operator()(const AtLevel& wanted) const { return wanted.level; }
    std::uint32_t operator()(const WithError& wanted) const {
      return statue.rows()[0].error <= wanted.error ? 0 : kFinestLevel;
    }
    std::uint32_t operator()(const WithTriangles& wanted) const {
      std::uint64_t finest = 0;
      for (RowIndex row = 1; row < statue.rows().size(); ++row) finest += statue.rows()[row].triangles;
      return finest <= wanted.triangles ? kFinestLevel : 0;
    }
    std::uint32_t operator()(const Eye&) const { return kFinestLevel; }
  };
  const std::uint32_t level = std::min<std::uint32_t>(std::visit(Chooser{*this}, request), kFinestLevel);
  reader::access::Extraction extraction;
  const RowRange range = rows_of_level(level);
  extraction.parts_by_level.resize(level + 1);
  extraction.parts_by_level[level] = range.size();
  reader::access::CutMesh& cut = extraction.mesh;
  for (RowIndex row = range.first; row < range.last; ++row) {
    const codec::coded::CodedNode node = load(row);
    const codec::coded::CodedPart& part = node.parts[0];
    const auto base = static_cast<std::uint32_t>(cut.positions.size());
    for (const geometry::Point& p : lattice_positions(node)) cut.add_position(world(p));
    cut.normals.insert(cut.normals.end(), part.normals.begin(), part.normals.end());
    cut.colors.insert(cut.colors.end(), part.colors.begin(), part.colors.end());
    for (const mesh::Triangle& t : part.triangles)
      cut.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    cut.stored_triangles += part.triangles.size();
  }
  weld(cut);
  return extraction;
}

}  // namespace colossus::toy
