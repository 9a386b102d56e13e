#include "reader/blocks/statue.hpp"

#include <algorithm>

#include "codec/node_codec.hpp"
#include "core/error.hpp"

namespace colossus::reader::blocks {

using container::NodeRow;
using core::Status;
using hierarchy::CubeId;

Statue::Statue(const std::filesystem::path& path, const access::StatueOptions& options)
    : Statue(container::ContainerReader(path), options) {}

Statue::Statue(container::ContainerReader container, const access::StatueOptions& options)
    : access::Statue(std::move(container), hierarchy::kBlocks), cache_(options.cache_bytes) {
  const std::string file = this->container().path().string();
  sigma0_ = parameter("sigma0");
  if (!(sigma0_ > 0.0) || !(sigma0_ <= 1.0))
    core::fail(Status::kBadData, "{}: sigma0: expected a number above 0 and at most 1, found {}", file,
               sigma0_);
  const double size = parameter("block_size");
  if (!(size >= hierarchy::kLeastBlockSize) || !(size <= hierarchy::kGreatestBlockSize) ||
      std::fmod(size, 4.0) != 0.0)
    core::fail(Status::kBadData, "{}: block_size: expected a multiple of 4 from {} to {}, found {}", file,
               hierarchy::kLeastBlockSize, hierarchy::kGreatestBlockSize, size);
  block_size_ = static_cast<int>(size);
  // A cube of the deepest level has sides of 2^position_bits.
  const int most_level = std::min(hierarchy::kMaxCubeLevel, root_bits() - metadata().position_bits);
  for (access::RowIndex row = 0; row < rows().size(); ++row) {
    const NodeRow& node = rows()[row];
    if (std::int64_t{node.level} > most_level)
      fail_node(row, fmt::format("expected a level of at most {}", most_level));
    if (!cube(row).is_inside_root()) fail_node(row, "the centre is no cube's centre of this level");
    if (node.tetra_mask != 1)
      fail_node(row, fmt::format("expected a mask of 1, found {}", static_cast<int>(node.tetra_mask)));
  }
}

CubeId Statue::cube(access::RowIndex row) const {
  const NodeRow& node = rows()[row];
  const geometry::Point center{node.center[0], node.center[1], node.center[2]};
  const auto level = std::min<std::uint32_t>(node.level, hierarchy::kMaxCubeLevel + 1);
  return hierarchy::cube_at(center, static_cast<int>(level), root_bits());
}

access::RowIndex Statue::find(const CubeId& cube) const {
  if (!cube.is_inside_root() || cube.level >= root_bits()) return access::kNoRow;
  return find_row(static_cast<std::uint32_t>(cube.level), cube.center(root_bits()));
}

access::RowIndex Statue::parent(access::RowIndex row) const {
  return rows()[row].level == 0 ? access::kNoRow : find(cube(row).parent());
}

std::array<access::RowIndex, 8> Statue::children(access::RowIndex row) const {
  std::array<access::RowIndex, 8> result{};
  const CubeId own = cube(row);
  for (int octant = 0; octant < 8; ++octant)
    result[static_cast<std::size_t>(octant)] = find(own.child(octant));
  return result;
}

codec::coded::CodedNode Statue::load(access::RowIndex index) const {
  codec::coded::CodedNode node = decode_node(index, &codec::decode_on_lattice);
  const codec::coded::CodedPart& mesh = node.parts[0];
  if (node.has_parents != (rows()[index].level > 0))
    fail_node(index, node.has_parents ? "its vertices have parents" : "its vertices have no parents");
  const std::int64_t side = std::int64_t{1} << root_bits();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const geometry::Point p = codec::coded::lattice_position(node, i);
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < 0 || p[axis] > side)
        fail_node(index,
                  fmt::format("vertex {} is at {} on axis {}, outside the root cube", i, p[axis], axis));
  }
  return node;
}

std::shared_ptr<const codec::coded::CodedNode> Statue::node(access::RowIndex row) const {
  return cache_.get(
      row, [&] { return load(row); }, codec::coded::memory_bytes);
}

}  // namespace colossus::reader::blocks
