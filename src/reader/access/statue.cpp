#include "reader/access/statue.hpp"

#include <algorithm>
#include <tuple>

#include "core/error.hpp"

namespace colossus::reader::access {

using container::NodeRow;
using core::Status;

Statue::Statue(container::ContainerReader container, std::string_view scheme)
    : container_(std::move(container)) {
  const std::string file = container_.path().string();
  if (metadata().scheme != scheme)
    core::fail(Status::kBadData, "{}: scheme: expected \"{}\", found \"{}\"", file, scheme,
               metadata().scheme);
  if (rows().size() >= kNoRow) core::fail(Status::kBadData, "{}: too many nodes: {}", file, rows().size());
}

std::optional<std::uint64_t> Statue::count_of(std::string_view name) const {
  for (const container::NamedCount& count : metadata().counts)
    if (count.name == name) return count.value;
  return std::nullopt;
}

std::optional<double> Statue::measure_of(std::string_view name) const {
  for (const container::NamedReal& measure : metadata().measures)
    if (measure.name == name) return measure.value;
  return std::nullopt;
}

std::string name_of(const NodeRow& row) {
  return fmt::format("level {}, centre {}, {}, {}", row.level, row.center[0], row.center[1], row.center[2]);
}

RowIndex Statue::find_row(std::uint32_t level, const geometry::Point& center) const {
  const std::array<std::int32_t, 3> key{center.x, center.y, center.z};
  const auto found = std::lower_bound(
      rows().begin(), rows().end(), std::tie(level, key),
      [](const NodeRow& row, const auto& wanted) { return std::tie(row.level, row.center) < wanted; });
  if (found == rows().end() || found->level != level || found->center != key) return kNoRow;
  return static_cast<RowIndex>(found - rows().begin());
}

RowRange Statue::rows_of_level(std::uint32_t level) const {
  const auto before = [](const NodeRow& row, std::uint32_t wanted) { return row.level < wanted; };
  const auto first = std::lower_bound(rows().begin(), rows().end(), level, before);
  const auto last = std::lower_bound(first, rows().end(), level + 1, before);
  return {static_cast<RowIndex>(first - rows().begin()), static_cast<RowIndex>(last - rows().begin())};
}

double Statue::parameter(std::string_view name) const {
  for (const container::NamedReal& parameter : metadata().parameters)
    if (parameter.name == name) return parameter.value;
  core::fail(Status::kBadData, "{}: the parameter \"{}\" is missing", container_.path().string(), name);
}

codec::coded::CodedNode Statue::decode_node(RowIndex index, Decode decode) const {
  const NodeRow& row = rows()[index];
  const auto payload = container_.read_payload(index);
  // The container's defects name file and node themselves.
  if (!payload) core::fail(Status::kBadData, "{}", payload.defect().message);
  auto decoded = decode(payload.value(), {row.vertices, row.triangles});
  if (!decoded)
    fail_node(index,
              fmt::format("{} (byte {} of the payload)", decoded.defect().message, decoded.defect().offset));
  codec::coded::CodedNode node = std::move(decoded).value();
  if (node.has_normals != metadata().has_normals || node.has_colors != metadata().has_colors)
    fail_node(index, "its attributes are not those of the container");
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const codec::coded::CodedPart& part : node.parts) {
    vertices += part.positions.size();
    triangles += part.triangles.size();
  }
  if (vertices != row.vertices || triangles != row.triangles)
    fail_node(index, fmt::format("it holds {} vertices and {} triangles; its row says {} and {}", vertices,
                                 triangles, row.vertices, row.triangles));
  return node;
}

void Statue::fail_node(RowIndex row, const std::string& message) const {
  core::fail(Status::kBadData, "{}: node at {}: {}", container_.path().string(), name(row), message);
}

}  // namespace colossus::reader::access
