#include "reader/blocks/statue.hpp"

#include <algorithm>
#include <tuple>

#include "codec/node_codec.hpp"
#include "core/error.hpp"

namespace colossus::reader::blocks {

using container::NodeRow;
using core::Status;
using hierarchy::CubeId;

namespace {

double parameter(const access::Statue& statue, const std::string& name) {
  for (const container::NamedReal& parameter : statue.metadata().parameters)
    if (parameter.name == name) return parameter.value;
  core::fail(Status::kBadData, "{}: the parameter \"{}\" is missing", statue.container().path().string(),
             name);
}

}  // namespace

Statue::Statue(const std::filesystem::path& path, const access::StatueOptions& options)
    : Statue(container::ContainerReader(path), options) {}

Statue::Statue(container::ContainerReader container, const access::StatueOptions& options)
    : access::Statue(std::move(container), hierarchy::kBlocks), cache_(options.cache_bytes) {
  const std::string file = this->container().path().string();
  sigma0_ = parameter(*this, "sigma0");
  if (!(sigma0_ > 0.0) || !(sigma0_ <= 1.0))
    core::fail(Status::kBadData, "{}: sigma0: expected a number above 0 and at most 1, found {}", file,
               sigma0_);
  const double size = parameter(*this, "block_size");
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
  const geometry::Point center = cube.center(root_bits());
  const auto level = static_cast<std::uint32_t>(cube.level);
  const std::array<std::int32_t, 3> key{center.x, center.y, center.z};
  const auto found = std::lower_bound(
      rows().begin(), rows().end(), std::tie(level, key),
      [](const NodeRow& row, const auto& wanted) { return std::tie(row.level, row.center) < wanted; });
  if (found == rows().end() || found->level != level || found->center != key) return access::kNoRow;
  return static_cast<access::RowIndex>(found - rows().begin());
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

RowRange Statue::rows_of_level(std::uint32_t level) const {
  const auto before = [](const NodeRow& row, std::uint32_t wanted) { return row.level < wanted; };
  const auto first = std::lower_bound(rows().begin(), rows().end(), level, before);
  const auto last = std::lower_bound(first, rows().end(), level + 1, before);
  return {static_cast<access::RowIndex>(first - rows().begin()),
          static_cast<access::RowIndex>(last - rows().begin())};
}

codec::coded::CodedNode Statue::load(access::RowIndex index) const {
  const NodeRow& row = rows()[index];
  const auto payload = container().read_payload(index);
  // The container's defects name file and node themselves.
  if (!payload) core::fail(Status::kBadData, "{}", payload.defect().message);
  auto decoded = codec::decode_on_lattice(payload.value(), {row.vertices, row.triangles});
  if (!decoded)
    fail_node(index,
              fmt::format("{} (byte {} of the payload)", decoded.defect().message, decoded.defect().offset));
  codec::coded::CodedNode& node = decoded.value();
  const codec::coded::CodedPart& mesh = node.parts[0];
  if (node.has_normals != metadata().has_normals || node.has_colors != metadata().has_colors)
    fail_node(index, "its attributes are not those of the container");
  if (node.has_parents != (row.level > 0))
    fail_node(index, node.has_parents ? "its vertices have parents" : "its vertices have no parents");
  if (mesh.positions.size() != row.vertices || mesh.triangles.size() != row.triangles)
    fail_node(index, fmt::format("it holds {} vertices and {} triangles; its row says {} and {}",
                                 mesh.positions.size(), mesh.triangles.size(), row.vertices, row.triangles));
  const std::int64_t side = std::int64_t{1} << root_bits();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const geometry::Point p = codec::coded::lattice_position(node, i);
    for (int axis = 0; axis < 3; ++axis)
      if (p[axis] < 0 || p[axis] > side)
        fail_node(index,
                  fmt::format("vertex {} is at {} on axis {}, outside the root cube", i, p[axis], axis));
  }
  return std::move(node);
}

std::shared_ptr<const codec::coded::CodedNode> Statue::node(access::RowIndex row) const {
  return cache_.get(
      row, [&] { return load(row); }, codec::coded::memory_bytes);
}

}  // namespace colossus::reader::blocks
