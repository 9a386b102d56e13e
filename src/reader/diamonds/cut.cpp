#include "reader/diamonds/cut.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>

#include "core/error.hpp"

namespace colossus::reader::diamonds {
namespace {

Cut root_cut(const Statue& statue) { return {std::vector<bool>(statue.rows().size(), false), {}}; }

// The unsplit rows that must be split before and with `row`, parents first. None is a leaf in a sound
// container; in another the leaves are left out, and the cut has no children there.
void collect_closure(const Statue& statue, const Cut& cut, access::RowIndex row,
                     std::vector<access::RowIndex>& order) {
  std::vector<access::RowIndex> pending{row};
  const std::size_t first = order.size();
  while (!pending.empty()) {
    const access::RowIndex next = pending.back();
    pending.pop_back();
    if (cut.is_split[next] || statue.is_leaf(next)) continue;
    order.push_back(next);
    for (const access::RowIndex parent : statue.parents(next)) pending.push_back(parent);
  }
  // Rows are ordered by level and centre, so this puts parents first.
  std::sort(order.begin() + static_cast<std::ptrdiff_t>(first), order.end());
  order.erase(std::unique(order.begin() + static_cast<std::ptrdiff_t>(first), order.end()), order.end());
}

template <typename Visit>
void for_each_child(const Statue& statue, access::RowIndex row, Visit visit) {
  for (std::uint8_t place = 0; place < kMaxPlaces; ++place)
    for (int end = 0; end < 2; ++end)
      if (const TetrahedronRef child = statue.child({row, place}, end); child.exists()) visit(child);
}

// Places whose tetrahedra exist in the cut and are not split.
std::uint8_t existing_places(const Statue& statue, const Cut& cut, access::RowIndex row) {
  if (cut.is_split[row]) return 0;
  if (statue.rows()[row].level == 0) return 0xff;
  std::uint8_t places = 0;
  for (std::uint8_t place = 0; place < kMaxPlaces; ++place)
    if (const TetrahedronRef parent = statue.parent({row, place});
        parent.exists() && cut.is_split[parent.row])
      places = static_cast<std::uint8_t>(places | 1U << place);
  return places;
}

struct LargestErrorFirst {
  const Statue* statue;
  bool operator()(access::RowIndex a, access::RowIndex b) const {
    const double error_a = statue->rows()[a].error;
    const double error_b = statue->rows()[b].error;
    return error_a != error_b ? error_a < error_b : a > b;
  }
};

// From the root on, every row in the cut for which wants_split(row) is split, with what must be split before.
template <typename WantsSplit>
Cut refined_cut(const Statue& statue, WantsSplit wants_split) {
  Cut cut = root_cut(statue);
  std::vector<access::RowIndex> pending;
  for (access::RowIndex row = 0; row < statue.rows().size() && statue.rows()[row].level == 0; ++row)
    pending.push_back(row);
  std::vector<access::RowIndex> steps;
  while (!pending.empty()) {
    const access::RowIndex row = pending.back();
    pending.pop_back();
    if (!cut.has_row(statue, row) || !wants_split(row)) continue;
    steps.clear();
    collect_closure(statue, cut, row, steps);
    for (const access::RowIndex step : steps) {
      cut.is_split[step] = true;
      for_each_child(statue, step, [&](TetrahedronRef child) { pending.push_back(child.row); });
    }
  }
  return cut;
}

double distance_to_bounds(const std::array<double, 3>& p, const std::array<double, 6>& bounds) {
  double distance = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    distance = std::max({distance, bounds[axis] - p[axis], p[axis] - bounds[axis + 3]});
  return distance;
}

}  // namespace

std::uint8_t Cut::active_places(const Statue& statue, access::RowIndex row) const {
  const std::uint8_t mask = statue.rows()[row].tetra_mask;
  return static_cast<std::uint8_t>(mask & existing_places(statue, *this, row));
}

bool Cut::has_row(const Statue& statue, access::RowIndex row) const {
  return (statue.places_with_geometry_below(row) & existing_places(statue, *this, row)) != 0;
}

Cut cut_at_level(const Statue& statue, std::uint32_t level) {
  Cut cut = root_cut(statue);
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
    cut.is_split[row] = statue.rows()[row].level < level && !statue.is_leaf(row);
  return cut;
}

Cut cut_with_error(const Statue& statue, double error) {
  Cut cut = refined_cut(statue, [&](access::RowIndex row) { return statue.rows()[row].error > error; });
  std::size_t above = 0;
  access::RowIndex worst = access::kNoRow;
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
    if (cut.has_row(statue, row) && statue.rows()[row].error > error) {
      ++above;
      if (worst == access::kNoRow || statue.rows()[row].error > statue.rows()[worst].error) worst = row;
    }
  if (above > 0)
    cut.warning = fmt::format("{} leaves of the finest level have an error above {}, up to {}", above, error,
                              statue.rows()[worst].error);
  return cut;
}

Cut cut_with_triangles(const Statue& statue, std::uint64_t triangles) {
  Cut cut = root_cut(statue);
  std::uint64_t count = triangle_count(statue, cut);
  if (count > triangles) {
    cut.warning = fmt::format("the root, the coarsest cut, has {} triangles, more than {}", count, triangles);
    return cut;
  }
  std::priority_queue<access::RowIndex, std::vector<access::RowIndex>, LargestErrorFirst> queue(
      LargestErrorFirst{&statue});
  const auto enqueue = [&](access::RowIndex row) {
    if (!cut.is_split[row] && !statue.is_leaf(row) && cut.has_row(statue, row)) queue.push(row);
  };
  for (access::RowIndex row = 0; row < statue.rows().size() && statue.rows()[row].level == 0; ++row)
    enqueue(row);
  std::vector<access::RowIndex> steps;
  while (!queue.empty()) {
    const access::RowIndex best = queue.top();
    queue.pop();
    steps.clear();
    collect_closure(statue, cut, best, steps);
    for (const access::RowIndex step : steps) {
      std::uint64_t after = count;
      const auto own = statue.triangle_counts(step);
      for (std::uint8_t place = 0; place < kMaxPlaces; ++place)
        if (cut.is_active(statue, {step, place})) after -= own[place];
      cut.is_split[step] = true;
      for_each_child(statue, step, [&](TetrahedronRef child) {
        if (cut.is_active(statue, child)) after += statue.triangle_counts(child.row)[child.place];
      });
      if (after > triangles) {
        cut.is_split[step] = false;
        return cut;
      }
      count = after;
      for_each_child(statue, step, [&](TetrahedronRef child) { enqueue(child.row); });
    }
  }
  return cut;
}

Cut cut_at_eye(const Statue& statue, const access::Eye& eye) {
  const double kappa = eye.kappa.value_or(access::kDefaultKappa);
  if (!(kappa > 0.0) || !std::isfinite(kappa))
    core::fail(core::Status::kUsage, "kappa: expected a number above 0, found {}", kappa);
  for (const double c : eye.position)
    if (!std::isfinite(c)) core::fail(core::Status::kUsage, "eye: expected finite coordinates, found {}", c);
  const double root_side = statue.lattice().step * geometry::kRootSide;
  return refined_cut(statue, [&](access::RowIndex row) {
    const container::NodeRow& node = statue.rows()[row];
    // Three levels halve the cubes.
    const double side = std::ldexp(root_side, -static_cast<int>(node.level / 3));
    return distance_to_bounds(eye.position, node.bounds) < kappa * side;
  });
}

std::vector<std::uint64_t> parts_by_level(const Statue& statue, const Cut& cut) {
  std::vector<std::uint64_t> counts(statue.deepest_level() + 1, 0);
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
    counts[statue.rows()[row].level] +=
        static_cast<std::uint64_t>(std::popcount(cut.active_places(statue, row)));
  return counts;
}

std::uint64_t triangle_count(const Statue& statue, const Cut& cut) {
  std::uint64_t total = 0;
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row) {
    const std::uint8_t places = cut.active_places(statue, row);
    if (places == 0) continue;
    // A wholly active node needs no decoding.
    if (places == statue.rows()[row].tetra_mask) {
      total += statue.rows()[row].triangles;
      continue;
    }
    const auto counts = statue.triangle_counts(row);
    for (std::size_t place = 0; place < kMaxPlaces; ++place)
      if ((places >> place & 1) != 0) total += counts[place];
  }
  return total;
}

}  // namespace colossus::reader::diamonds
