#include "pipeline/nodes/finest_level.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/log.hpp"
#include "pipeline/ingest/extent.hpp"

namespace colossus::pipeline::nodes {
namespace {

// From so many bits on quantisation changes the area of a scan by less than a thousandth.
constexpr int kFineBits = 12;
constexpr double kAreaShare = 1e-3;
// Less than this share of the area, and the surface is not there.
constexpr double kLeastShare = 0.5;

}  // namespace

AreaCheck::AreaCheck(const facts::Catalog& catalog, const facts::FinishedNodes& finished)
    : finest(finished.finest_area()), position_bits(finished.position_bits) {
  const double units = catalog.lattice.step / finished.lattice.step;
  input = catalog.area * units * units;
}

bool AreaCheck::differs() const {
  return position_bits >= kFineBits && std::abs(finest - input) > kAreaShare * input;
}

void refuse_lost_surface(const facts::Catalog& catalog, const facts::FinishedNodes& finished) {
  const AreaCheck areas(catalog, finished);
  const std::uint64_t triangles = finished.finest_triangles();
  if (triangles > 0 && areas.finest >= kLeastShare * areas.input) return;
  core::fail(
      core::Status::kBadData,
      "{}: the finest level would have {} triangles and {:.2f} % of the input's area, since what is "
      "finer than its quantisation falls together: build with more --position-bits, with smaller leaves "
      "(--leaf-triangles), or in parts{}",
      catalog.input_name(), triangles, 100.0 * areas.finest / areas.input, ingest::far_corner_text(catalog));
}

void count_finest_level(facts::Catalog& catalog, const facts::FinishedNodes& finished) {
  facts::InputCounts& counts = catalog.counts;
  counts.finest_triangles = finished.finest_triangles();
  counts.area_differs = AreaCheck(catalog, finished).differs() ? 1 : 0;
  counts.leaves_above_limit = 0;
  for (const facts::LevelStatistics& level : finished.levels)
    counts.leaves_above_limit += level.leaves_above_limit;
}

void log_finest_level(const facts::Catalog& catalog, const facts::FinishedNodes& finished) {
  const AreaCheck areas(catalog, finished);
  const double percent = 100.0 * areas.finest / areas.input;
  core::log("finest level: {} triangles, {:.4f} % of the input's area; {} border and {} non-manifold edges",
            finished.finest_triangles(), percent, catalog.counts.finest_border_edges,
            catalog.counts.finest_nonmanifold_edges);
  if (areas.differs())
    core::warn(
        "the finest level has {:.3f} % of the input's area: what is thinner than its quantisation is rough",
        percent);
}

}  // namespace colossus::pipeline::nodes
