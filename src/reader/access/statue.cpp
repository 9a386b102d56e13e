#include "reader/access/statue.hpp"

#include <cmath>
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
  for (const double origin : metadata().lattice.origin)
    if (!std::isfinite(origin)) core::fail(Status::kBadData, "{}: the lattice's origin is not finite", file);
  if (rows().size() >= kNoRow) core::fail(Status::kBadData, "{}: too many nodes: {}", file, rows().size());
  for (RowIndex row = 0; row < rows().size(); ++row) check_row(row);
}

void Statue::check_row(RowIndex index) const {
  const NodeRow& row = rows()[index];
  if (!std::isfinite(row.error) || row.error < 0) fail_node(index, fmt::format("its error is {}", row.error));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(row.bounds[axis]) || !std::isfinite(row.bounds[axis + 3]) ||
        row.bounds[axis] > row.bounds[axis + 3])
      fail_node(index, fmt::format("its bounds are {} to {} on axis {}", row.bounds[axis],
                                   row.bounds[axis + 3], axis));
  if (index > 0) {
    const NodeRow& before = rows()[index - 1];
    if (std::tie(before.level, before.center) >= std::tie(row.level, row.center))
      fail_node(index, "the node table is not in ascending order of level and centre");
  }
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

void Statue::fail_node(RowIndex row, const std::string& message) const {
  core::fail(Status::kBadData, "{}: node at {}: {}", container_.path().string(), name(row), message);
}

}  // namespace colossus::reader::access
