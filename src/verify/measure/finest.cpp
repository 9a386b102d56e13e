#include "verify/measure/finest.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace colossus::verify::measure {
namespace {

using Wide = __int128;

// From here on the surface is fine enough for the area to be the input's, unless the build found otherwise.
constexpr int kFineBits = 12;
constexpr double kAreaShare = 1e-3;
constexpr double kSameArea = 1e-9;  // for sums in another order

std::string missing_facts(const reader::access::Statue& statue) {
  std::string missing;
  const auto expect = [&](bool is_there, const char* name) {
    if (!is_there) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", name);
  };
  for (const char* name : {"finest_triangles", "finest_border_edges", "finest_nonmanifold_edges"})
    expect(statue.count_of(name).has_value(), name);
  for (const char* name : {"input_area", "finest_area"}) expect(statue.measure_of(name).has_value(), name);
  expect(stored_bounds(statue).has_value(), "bounds of the input");
  bool has_orientation = false;
  for (const auto& column : statue.metadata().levels)
    has_orientation = has_orientation || column.name == "inconsistent_edges";
  expect(has_orientation, "inconsistent_edges of the levels");
  return missing;
}

void check_count(const reader::access::Statue& statue, FindingKind kind, const char* name, const char* what,
                 std::uint64_t found, FindingLog& log) {
  if (const auto stored = statue.count_of(name); stored && *stored != found)
    log.add({kind, fmt::format("the finest level has {} {}; the container says {}", found, what, *stored)});
}

void check_area(const reader::access::Statue& statue, const FinestSurface& finest, FindingLog& log) {
  const auto stored = statue.measure_of("finest_area");
  const auto of_input = statue.measure_of("input_area");
  if (stored && !(std::abs(finest.area - *stored) <= kSameArea * finest.area + finest.rounding))
    log.add({FindingKind::kArea, fmt::format("the finest level has an area of {} square lattice units; the "
                                             "container says {}",
                                             finest.area, *stored)});
  if (!of_input) return;
  if (!(2.0 * finest.area + finest.rounding >= *of_input)) {
    log.add({FindingKind::kArea, fmt::format("the finest level has {:.2f} % of the input's area; no build "
                                             "stores less than half of it",
                                             100.0 * finest.area / *of_input)});
    return;
  }
  // A build that itself finds more than this share says so.
  if (statue.metadata().position_bits < kFineBits || statue.count_of("area_differs").value_or(0) != 0) return;
  if (!(std::abs(finest.area - *of_input) <= kAreaShare * *of_input + finest.rounding))
    log.add({FindingKind::kArea,
             fmt::format("the finest level has {:.4f} % of the input's area: more than {} % apart, and the "
                         "container does not say that its build found that",
                         100.0 * finest.area / *of_input, 100.0 * kAreaShare)});
}

void check_bounds(const reader::access::Statue& statue, const FinestSurface& finest, FindingLog& log) {
  const auto stored = stored_bounds(statue);
  if (!stored || finest.bounds.is_empty()) return;
  // Nothing is left of a vertex that only degenerate triangles use.
  const bool may_be_smaller = statue.count_of("degenerate").value_or(0) > 0;
  const auto is_near = [&](double outward) {
    return may_be_smaller && outward < 0.0 ? true
                                           : is_within(statue, std::abs(outward), finest.greatest_error);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (is_near(stored->low[axis] - finest.bounds.low[axis]) &&
        is_near(finest.bounds.high[axis] - stored->high[axis]))
      continue;
    log.add({FindingKind::kBounds,
             fmt::format("the finest level reaches from {} to {} on axis {}, the input from {} to {}; the "
                         "greatest error of a leaf is {}",
                         finest.bounds.low[axis], finest.bounds.high[axis], "xyz"[axis], stored -> low[axis],
                         stored -> high[axis], finest.greatest_error)});
  }
}

}  // namespace

void FinestSurface::add(const FinestSurface& part) {
  area += part.area;
  rounding += part.rounding;
  if (!part.bounds.is_empty()) {
    bounds.add(part.bounds.low);
    bounds.add(part.bounds.high);
  }
  greatest_error = std::max(greatest_error, part.greatest_error);
  triangles += part.triangles;
  border_edges += part.border_edges;
  nonmanifold_edges += part.nonmanifold_edges;
  is_whole = is_whole && part.is_whole;
}

void add_area(FinestSurface& part, std::span<const codec::coded::ScaledPosition> positions,
              std::span<const mesh::Triangle> triangles, double units) {
  double area = 0.0;
  double products = 0.0;
  for (const mesh::Triangle& t : triangles) {
    std::array<Wide, 3> u{};
    std::array<Wide, 3> v{};
    std::array<double, 2> squares{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      u[axis] = Wide{positions[t[1]][axis]} - positions[t[0]][axis];
      v[axis] = Wide{positions[t[2]][axis]} - positions[t[0]][axis];
      squares[0] += static_cast<double>(u[axis]) * static_cast<double>(u[axis]);
      squares[1] += static_cast<double>(v[axis]) * static_cast<double>(v[axis]);
    }
    double square = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t next = (axis + 1) % 3;
      const auto component = static_cast<double>(u[axis] * v[next] - u[next] * v[axis]);
      square += component * component;
    }
    area += std::sqrt(square) / 2.0;
    products += std::sqrt(squares[0] * squares[1]);
  }
  part.area += area / (units * units);
  // Of slivers the products cancel.
  part.rounding += 8.0 * std::numeric_limits<double>::epsilon() * products / (units * units);
}

std::optional<geometry::Bounds> stored_bounds(const reader::access::Statue& statue) {
  static constexpr std::array<std::array<const char*, 2>, 3> kNames{
      {{"min_x", "max_x"}, {"min_y", "max_y"}, {"min_z", "max_z"}}};
  geometry::Bounds bounds;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto low = statue.measure_of(kNames[axis][0]);
    const auto high = statue.measure_of(kNames[axis][1]);
    if (!low || !high) return std::nullopt;
    bounds.low[axis] = *low;
    bounds.high[axis] = *high;
  }
  return bounds;
}

void check_finest(const reader::access::Statue& statue, const FinestSurface& finest, FindingLog& log) {
  if (const std::string missing = missing_facts(statue); !missing.empty())
    log.add_note(fmt::format("not checked, since the container does not say: {}", missing));
  if (!finest.is_whole) {
    log.add_note("not checked, since leaves are damaged: the finest level as a whole");
    return;
  }
  check_count(statue, FindingKind::kCount, "finest_triangles", "triangles", finest.triangles, log);
  check_count(statue, FindingKind::kBorder, "finest_border_edges", "border edges", finest.border_edges, log);
  check_count(statue, FindingKind::kNonManifold, "finest_nonmanifold_edges", "non-manifold edges",
              finest.nonmanifold_edges, log);
  check_area(statue, finest, log);
  check_bounds(statue, finest, log);
  if (const auto of_input = statue.measure_of("input_area"); of_input && *of_input > 0.0)
    log.add_note(fmt::format("the finest level: {} triangles, {:.4f} % of the input's area", finest.triangles,
                             100.0 * finest.area / *of_input));
}

}  // namespace colossus::verify::measure
