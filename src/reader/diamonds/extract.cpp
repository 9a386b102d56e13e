#include "reader/diamonds/extract.hpp"

#include <algorithm>

#include "reader/access/parallel.hpp"
#include "reader/diamonds/welded.hpp"

namespace colossus::reader::diamonds {
namespace {

constexpr std::size_t kBatch = 64;  // nodes decoded at a time

struct LoadedNode {
  Node node;
  std::vector<WeldedTetrahedron> welded;  // one per active tetrahedron
  std::vector<std::size_t> parts;         // ... and its index in node.mesh.parts
};

LoadedNode load_active(const Statue& statue, const Cut& cut, access::RowIndex row) {
  LoadedNode loaded{statue.load(row), {}, {}};
  const std::uint8_t places = cut.active_places(statue, row);
  const auto& parts = loaded.node.mesh.parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if ((places >> parts[i].place & 1) == 0) continue;
    loaded.welded.push_back(weld_positions(parts[i], loaded.node.diamond.tetrahedra[parts[i].place]));
    loaded.parts.push_back(i);
  }
  return loaded;
}

class Assembler {
 public:
  explicit Assembler(const Statue& statue) : statue_(statue) {}

  void add(const LoadedNode& loaded) {
    for (std::size_t i = 0; i < loaded.welded.size(); ++i)
      add(loaded.welded[i], loaded.node.mesh.parts[loaded.parts[i]]);
  }
  access::CutMesh take() { return std::move(mesh_); }

 private:
  void add(const WeldedTetrahedron& welded, const codec::coded::CodedPart& part) {
    std::vector<std::uint32_t> numbers(welded.positions.size());
    for (std::size_t i = 0; i < welded.positions.size(); ++i) numbers[i] = add_vertex(welded, part, i);
    for (const mesh::Triangle& t : welded.triangles)
      mesh_.triangles.push_back({numbers[t[0]], numbers[t[1]], numbers[t[2]]});
    mesh_.stored_triangles += part.triangles.size();
  }

  std::uint32_t add_vertex(const WeldedTetrahedron& welded, const codec::coded::CodedPart& part,
                           std::size_t i) {
    if (!part.normals.empty()) mesh_.normals.push_back(part.normals[welded.sources[i]]);
    if (!part.colors.empty()) mesh_.colors.push_back(part.colors[welded.sources[i]]);
    return mesh_.add_position(statue_.world(welded.positions[i]));
  }

  const Statue& statue_;
  access::CutMesh mesh_;
};

}  // namespace

access::CutMesh assemble(const Statue& statue, const Cut& cut) {
  std::vector<access::RowIndex> active;
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
    if (cut.active_places(statue, row) != 0) active.push_back(row);
  Assembler assembler(statue);
  for (std::size_t begin = 0; begin < active.size(); begin += kBatch) {
    std::vector<LoadedNode> batch(std::min(kBatch, active.size() - begin));
    access::parallel_for(batch.size(),
                         [&](std::size_t i) { batch[i] = load_active(statue, cut, active[begin + i]); });
    for (const LoadedNode& loaded : batch) assembler.add(loaded);
  }
  access::CutMesh mesh = assembler.take();
  weld(mesh);
  return mesh;
}

access::Extraction Statue::extract(const access::CutRequest& request) const {
  return access::extract_cut(*this, request);
}

}  // namespace colossus::reader::diamonds
