#include "reader/access/cut_mesh.hpp"

#include <algorithm>
#include <bit>

#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::reader::access {
namespace {

using core::Status;

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::size_t kMostVertices = (std::size_t{1} << 31) - 1;  // what signed PLY indices reach

// Finds equal keys by open addressing; the values are counted from 0 in order of insertion.
template <typename Key, typename Hash>
class Numbering {
 public:
  // The number of the key, new when it is the next one.
  std::uint32_t number(const Key& key) {
    if ((keys_.size() + 1) * 2 > table_.size()) grow();
    std::size_t slot = Hash{}(key) & (table_.size() - 1);
    while (table_[slot] != kNone && keys_[table_[slot]] != key) slot = (slot + 1) & (table_.size() - 1);
    if (table_[slot] == kNone) {
      table_[slot] = static_cast<std::uint32_t>(keys_.size());
      keys_.push_back(key);
    }
    return table_[slot];
  }
  std::size_t size() const { return keys_.size(); }

 private:
  void grow() {
    table_.assign(std::max<std::size_t>(1024, table_.size() * 2), kNone);
    for (std::uint32_t i = 0; i < keys_.size(); ++i) {
      std::size_t slot = Hash{}(keys_[i]) & (table_.size() - 1);
      while (table_[slot] != kNone) slot = (slot + 1) & (table_.size() - 1);
      table_[slot] = i;
    }
  }
  std::vector<Key> keys_;
  std::vector<std::uint32_t> table_;
};

using DoubleBits = std::array<std::uint64_t, 3>;
struct DoubleBitsHash {
  std::size_t operator()(const DoubleBits& p) const {
    std::uint64_t h = 0;
    for (const std::uint64_t c : p) h = core::mix64(h + 0x9e3779b97f4a7c15ULL + c);
    return h;
  }
};

}  // namespace

std::uint32_t CutMesh::add_position(const std::array<double, 3>& world) {
  if (positions.size() >= kMostVertices)
    core::fail(Status::kNoResources, "the cut has more than {} vertices; choose a coarser one",
               kMostVertices);
  positions.push_back(world);
  return static_cast<std::uint32_t>(positions.size() - 1);
}

void weld(CutMesh& mesh) {
  Numbering<DoubleBits, DoubleBitsHash> worlds;
  std::vector<std::uint32_t> first(mesh.positions.size());
  std::vector<std::uint32_t> first_of_number;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    DoubleBits bits{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      bits[axis] = std::bit_cast<std::uint64_t>(mesh.positions[i][axis]);
    const std::uint32_t number = worlds.number(bits);
    if (number == first_of_number.size()) first_of_number.push_back(i);
    first[i] = first_of_number[number];
  }
  for (mesh::Triangle& t : mesh.triangles)
    for (auto& v : t) v = first[v];
  std::erase_if(mesh.triangles,
                [](const mesh::Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  std::vector<bool> is_used(first.size());
  for (const mesh::Triangle& t : mesh.triangles)
    for (const auto v : t) is_used[v] = true;
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    if (!is_used[i]) continue;
    mesh.positions[kept] = mesh.positions[i];
    if (!mesh.normals.empty()) mesh.normals[kept] = mesh.normals[i];
    if (!mesh.colors.empty()) mesh.colors[kept] = mesh.colors[i];
    first[i] = kept++;
  }
  mesh.positions.resize(kept);
  if (!mesh.normals.empty()) mesh.normals.resize(kept);
  if (!mesh.colors.empty()) mesh.colors.resize(kept);
  for (mesh::Triangle& t : mesh.triangles)
    for (auto& v : t) v = first[v];
}

}  // namespace colossus::reader::access
