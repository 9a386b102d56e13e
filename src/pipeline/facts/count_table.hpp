// The table of all counts of the input and of the finest level, which container, report and tests follow.
#pragma once

#include <array>

#include "pipeline/facts/catalog.hpp"
#include "pipeline/facts/stored.hpp"

namespace colossus::pipeline::facts {

struct Count {
  const char* name;  // in container and report
  std::uint64_t InputCounts::*member;
  Stored stored = Stored::kAlways;
};

// In the order of the container.
inline constexpr auto kCounts = std::to_array<Count>({
    {"vertices", &InputCounts::vertices},
    {"triangles", &InputCounts::triangles},
    {"polygons", &InputCounts::polygons},
    {"concave_polygons", &InputCounts::concave_polygons, Stored::kNever},
    {"warped_polygons", &InputCounts::warped_polygons, Stored::kNever},
    {"crossing_polygons", &InputCounts::crossing_polygons, Stored::kNever},
    {"small_faces", &InputCounts::small_faces},
    {"degenerate", &InputCounts::degenerate},
    {"collapsed", &InputCounts::collapsed},
    {"duplicate", &InputCounts::duplicate},
    {"opposite", &InputCounts::opposite},
    {"collinear", &InputCounts::collinear},
    {"border_edges", &InputCounts::border_edges},
    {"nonmanifold_edges", &InputCounts::nonmanifold_edges},
    {"inconsistent_edges", &InputCounts::inconsistent_edges},
    {"merged_vertices", &InputCounts::merged_vertices},
    {"attribute_seams", &InputCounts::attribute_seams},
    {"color_seams", &InputCounts::color_seams, Stored::kNever},
    {"leaves_above_limit", &InputCounts::leaves_above_limit},
    {"finest_triangles", &InputCounts::finest_triangles},
    {"finest_border_edges", &InputCounts::finest_border_edges},
    {"finest_nonmanifold_edges", &InputCounts::finest_nonmanifold_edges},
    {"area_differs", &InputCounts::area_differs},
    {"split_edges", &InputCounts::split_edges, Stored::kUnlessDefault},
});
static_assert(sizeof(InputCounts) == kCounts.size() * sizeof(std::uint64_t), "a count is in no table");

}  // namespace colossus::pipeline::facts
