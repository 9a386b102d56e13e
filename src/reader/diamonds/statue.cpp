#include "reader/diamonds/statue.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "codec/node_codec.hpp"
#include "core/error.hpp"

namespace colossus::reader::diamonds {

using container::NodeRow;
using core::Status;
using hierarchy::Diamond;
using hierarchy::Point;

Statue::Statue(const std::filesystem::path& path, const access::StatueOptions& options)
    : Statue(container::ContainerReader(path), options) {}

Statue::Statue(container::ContainerReader container, const access::StatueOptions& options)
    : access::Statue(std::move(container), hierarchy::kDiamonds), cache_(options.cache_bytes) {
  const container::Metadata& meta = metadata();
  const std::string file = this->container().path().string();
  if (meta.lattice.root_bits != geometry::kRootBits)
    core::fail(Status::kBadData, "{}: the root cube has {} bits; this program reads {}", file,
               meta.lattice.root_bits, geometry::kRootBits);
  if (meta.position_bits < codec::coded::kMinPositionBits ||
      meta.position_bits > codec::coded::kMaxPositionBits)
    core::fail(Status::kBadData, "{}: {} position bits; expected {} to {}", file, meta.position_bits,
               codec::coded::kMinPositionBits, codec::coded::kMaxPositionBits);
  int exponent = 0;
  if (!(meta.lattice.step > 0.0) || std::frexp(meta.lattice.step, &exponent) != 0.5)
    core::fail(Status::kBadData, "{}: the lattice's step {} is no power of two", file, meta.lattice.step);
  lattice_.origin = meta.lattice.origin;
  lattice_.step = meta.lattice.step;
  scaled_step_ = std::ldexp(lattice_.step, -meta.position_bits);
  for (access::RowIndex row = 0; row < rows().size(); ++row) check_row(row);
  children_.resize(rows().size());
  parents_.resize(rows().size());
  for (access::RowIndex row = 0; row < rows().size(); ++row)
    if (!is_leaf(row)) link_children(row);
  below_.resize(rows().size());
  for (access::RowIndex row = static_cast<access::RowIndex>(rows().size()); row-- > 0;) {
    below_[row] = static_cast<std::uint8_t>(below_[row] | rows()[row].tetra_mask);
    for (std::uint8_t place = 0; place < kMaxPlaces; ++place)
      if (const TetrahedronRef up = parents_[row][place]; up.exists() && (below_[row] >> place & 1) != 0)
        below_[up.row] = static_cast<std::uint8_t>(below_[up.row] | 1U << up.place);
  }
}

void Statue::check_row(access::RowIndex index) const {
  const NodeRow& row = rows()[index];
  const auto on_lattice = [](std::int32_t value) { return value >= 0 && value <= geometry::kRootSide; };
  if (!std::all_of(row.center.begin(), row.center.end(), on_lattice))
    fail_node(index, "the centre lies outside the root cube");
  if (row.level > hierarchy::kMaxLevel || hierarchy::level_of(center(index)) != static_cast<int>(row.level))
    fail_node(index, fmt::format("the centre is no diamond's centre of this level but of level {}",
                                 hierarchy::level_of(center(index))));
  const Diamond diamond = Diamond::at(center(index));
  for (std::size_t place = 0; place < kMaxPlaces; ++place)
    if ((row.tetra_mask >> place & 1) != 0 && !diamond.is_inside[place])
      fail_node(
          index,
          fmt::format("its mask has place {}, which the diamond does not have inside the root cube", place));
}

void Statue::link_children(access::RowIndex row) {
  const Diamond diamond = Diamond::at(center(row));
  if (diamond.level >= hierarchy::kMaxLevel) return;
  for (std::uint8_t place = 0; place < diamond.place_count; ++place) {
    if (!diamond.is_inside[place]) continue;
    for (int end = 0; end < 2; ++end) {
      const hierarchy::Tetrahedron half = diamond.tetrahedra[place].child(end);
      const access::RowIndex found = find(half.center());
      if (found == access::kNoRow) continue;
      const auto id = hierarchy::id_of(half);
      const auto child_place = static_cast<std::uint8_t>(id.place);
      children_[row][2 * std::size_t{place} + static_cast<std::size_t>(end)] = {found, child_place};
      parents_[found][child_place] = {row, place};
    }
  }
}

Point Statue::center(access::RowIndex row) const {
  const auto& c = rows()[row].center;
  return {c[0], c[1], c[2]};
}

access::RowIndex Statue::find(const Point& center) const {
  return find_row(static_cast<std::uint32_t>(std::max(0, hierarchy::level_of(center))), center);
}

std::vector<access::RowIndex> Statue::parents(access::RowIndex row) const {
  std::vector<access::RowIndex> found;
  for (const Point& parent : Diamond::at(center(row)).parents())
    if (const access::RowIndex index = find(parent); index != access::kNoRow) found.push_back(index);
  return found;
}

TetrahedronRef Statue::child(TetrahedronRef t, int end) const {
  return children_[t.row][2 * std::size_t{t.place} + static_cast<std::size_t>(end)];
}

TetrahedronRef Statue::parent(TetrahedronRef t) const { return parents_[t.row][t.place]; }

bool Statue::exists(TetrahedronRef t) const {
  return rows()[t.row].level == 0 || parents_[t.row][t.place].exists();
}

Node Statue::load(access::RowIndex index) const {
  const NodeRow& row = rows()[index];
  Node node{Diamond::at(center(index)), decode_node(index, &codec::decode_with_weights)};
  const codec::coded::CodedNode& mesh = node.mesh;
  if (mesh.position_bits != metadata().position_bits)
    fail_node(index, fmt::format("it has {} position bits; the container says {}", mesh.position_bits,
                                 metadata().position_bits));
  for (const auto& part : mesh.parts)
    // The mask's places are inside the root cube: check_row().
    if ((row.tetra_mask >> part.place & 1) == 0)
      fail_node(index, fmt::format("it holds place {}, which its row's mask {:#04x} does not have",
                                   part.place, row.tetra_mask));
  if (std::popcount(row.tetra_mask) != static_cast<int>(mesh.parts.size()))
    fail_node(index, fmt::format("it holds {} tetrahedra; its row's mask {:#04x} has {}", mesh.parts.size(),
                                 row.tetra_mask, std::popcount(row.tetra_mask)));
  return node;
}

std::shared_ptr<const Node> Statue::node(access::RowIndex row) const {
  return cache_.get(
      row, [&] { return load(row); }, [](const Node& node) { return node.memory_bytes(); });
}

std::array<std::uint32_t, kMaxPlaces> Statue::triangle_counts(access::RowIndex row) const {
  std::array<std::uint32_t, kMaxPlaces> counts{};
  const std::uint8_t mask = rows()[row].tetra_mask;
  if (std::popcount(mask) <= 1) {
    if (mask != 0) counts[static_cast<std::size_t>(std::countr_zero(mask))] = rows()[row].triangles;
    return counts;
  }
  {
    const std::lock_guard lock(counts_mutex_);
    if (const auto found = counts_.find(row); found != counts_.end()) return found->second;
  }
  const auto decoded = node(row);
  for (const auto& part : decoded->mesh.parts)
    counts[part.place] = static_cast<std::uint32_t>(part.triangles.size());
  const std::lock_guard lock(counts_mutex_);
  counts_.emplace(row, counts);
  return counts;
}

}  // namespace colossus::reader::diamonds
