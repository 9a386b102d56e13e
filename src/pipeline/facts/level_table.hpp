// The table of all statistics of a level, which container, report and tests follow.
#pragma once

#include <functional>

#include "pipeline/facts/finished_nodes.hpp"

namespace colossus::pipeline::facts {

struct LevelField {
  const char* column;                 // in the container; nullptr: not stored
  const char* report_name = nullptr;  // nullptr: not in the report
};

// Calls visit(field, member) for each sum over the nodes of a level; std::invoke(member, statistics) is a
// reference to it.
template <typename Visit>
constexpr void for_each_sum(Visit visit) {
  using S = NodeStatistics;
  visit(LevelField{"initial_triangles"}, &S::initial_triangles);
  visit(LevelField{"target_triangles"}, &S::target_triangles);
  visit(LevelField{"reached_triangles"}, &S::reached_triangles);
  visit(LevelField{"initial_vertices"}, &S::initial_vertices);
  visit(LevelField{"locked_vertices"}, &S::locked_vertices);
  visit(
      LevelField{"angle_below_5"}, [](auto& s) -> auto& { return s.angles.below_5_degrees; });
  visit(
      LevelField{"angle_below_15"}, [](auto& s) -> auto& { return s.angles.below_15_degrees; });
  visit(
      LevelField{"angle_below_30"}, [](auto& s) -> auto& { return s.angles.below_30_degrees; });
  visit(LevelField{"inconsistent_edges"}, &S::inconsistent_edges);
  // These two are counts of the whole container.
  visit(LevelField{nullptr}, &S::finest_border_edges);
  visit(LevelField{nullptr}, &S::finest_nonmanifold_edges);
}

// The same for each statistic of a level, in the order of the container's columns, which follow the level's
// number.
template <typename Visit>
constexpr void for_each_level_field(Visit visit) {
  using L = LevelStatistics;
  visit(LevelField{"nodes", "nodes"}, &L::nodes);
  visit(LevelField{"leaves", "leaves"}, &L::leaves);
  visit(LevelField{nullptr}, &L::leaves_above_limit);  // a count of the whole container
  visit(LevelField{"vertices", "vertices"}, &L::vertices);
  visit(LevelField{"triangles", "triangles"}, &L::triangles);
  visit(LevelField{"payload_bytes"}, &L::payload_bytes);
  visit(LevelField{"stored_bytes", "bytes"}, &L::stored_bytes);
  for (std::size_t i = 0; i < codec::coded::kComponentCount; ++i)
    visit(
        LevelField{codec::coded::kComponentColumns[i]}, [i](auto& level) -> auto& {
          return level.component_bytes[i];
        });
  visit(LevelField{"error", "error"}, &L::error);
  visit(LevelField{"quantization_error"}, &L::displacement);
  for_each_sum([&](const LevelField& field, auto member) {
    visit(
        field, [member](auto& level) -> auto& { return std::invoke(member, level.sums); });
  });
}

}  // namespace colossus::pipeline::facts
