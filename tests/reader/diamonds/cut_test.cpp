#include "reader/diamonds/cut.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.hpp"
#include "support/diamonds_fixture.hpp"

namespace colossus::reader::diamonds {

using namespace support;
namespace {

bool is_closed_under_parents(const Statue& statue, const Cut& cut) {
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
    if (cut.is_split[row]) {
      if (statue.is_leaf(row)) return false;
      for (const access::RowIndex parent : statue.parents(row))
        if (!cut.is_split[parent]) return false;
    }
  return true;
}

void expect_closed_surface(const Statue& statue, const Cut& cut) {
  ASSERT_TRUE(is_closed_under_parents(statue, cut));
  const access::CutMesh mesh = assemble(statue, cut);
  ASSERT_FALSE(mesh.triangles.empty());
  const Census census = census_of(mesh);
  EXPECT_EQ(census.border_edges, 0U);
  EXPECT_EQ(census.nonmanifold_edges, 0U);
  EXPECT_EQ(census.repeated_points, 0U);
}

std::uint64_t counted_anew(const Statue& statue, const Cut& cut) {
  std::uint64_t total = 0;
  for (access::RowIndex row = 0; row < statue.rows().size(); ++row) {
    const Node node = statue.load(row);
    for (const auto& part : node.mesh.parts)
      if (cut.is_active(statue, {row, part.place})) total += part.triangles.size();
  }
  return total;
}

// The unsplit row that has to be split first when `row` is to be.
access::RowIndex first_missing(const Statue& statue, const Cut& cut, access::RowIndex row) {
  access::RowIndex first = row;
  for (const access::RowIndex parent : statue.parents(row))
    if (!cut.is_split[parent]) first = std::min(first, first_missing(statue, cut, parent));
  return first;
}

Cut brute_force_triangles(const Statue& statue, std::uint64_t most) {
  Cut cut{std::vector<bool>(statue.rows().size(), false), {}};
  for (;;) {
    access::RowIndex best = access::kNoRow;
    for (access::RowIndex row = 0; row < statue.rows().size(); ++row)
      if (!cut.is_split[row] && !statue.is_leaf(row) && cut.active_places(statue, row) != 0 &&
          (best == access::kNoRow || statue.rows()[row].error > statue.rows()[best].error))
        best = row;
    if (best == access::kNoRow) return cut;
    while (!cut.is_split[best]) {
      const access::RowIndex step = first_missing(statue, cut, best);
      cut.is_split[step] = true;
      if (counted_anew(statue, cut) > most) {
        cut.is_split[step] = false;
        return cut;
      }
    }
  }
}

TEST(Cut, EveryLevelIsClosed) {
  DiamondsFixture fixture(torus(40, 24), 200);
  const auto statue = fixture.open();
  ASSERT_GT(statue->deepest_level(), 3U);
  for (std::uint32_t level = 0; level <= statue->deepest_level() + 1; ++level) {
    SCOPED_TRACE(level);
    const Cut cut = cut_at_level(*statue, level);
    expect_closed_surface(*statue, cut);
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row)
      if (cut.active_places(*statue, row) != 0) {
        const std::uint32_t own = statue->rows()[row].level;
        EXPECT_TRUE(own == level || (own < level && statue->is_leaf(row)));
        EXPECT_EQ(cut.active_places(*statue, row), statue->rows()[row].tetra_mask);
      }
    const std::vector<std::uint64_t> parts = parts_by_level(*statue, cut);
    ASSERT_EQ(parts.size(), statue->deepest_level() + 1);
    for (std::uint32_t own = 0; own < parts.size(); ++own) {
      std::uint64_t tetrahedra = 0;
      for (access::RowIndex row = 0; row < statue->rows().size(); ++row)
        if (statue->rows()[row].level == own && (own == level || (own < level && statue->is_leaf(row))))
          for (int mask = statue->rows()[row].tetra_mask; mask != 0; mask >>= 1) tetrahedra += mask & 1;
      if (level <= statue->deepest_level()) {
        EXPECT_EQ(parts[own], tetrahedra) << own;
      }
    }
  }
}

TEST(Cut, RandomCutsClosedUnderParentsAreClosed) {
  DiamondsFixture fixture(torus(40, 24), 100);
  const auto statue = fixture.open();
  const unsigned seed = 20261123;
  std::cout << "seed " << seed << "\n";
  std::mt19937 random(seed);
  bool had_partly_active = false;
  for (int round = 0; round < 50; ++round) {
    Cut cut{std::vector<bool>(statue->rows().size(), false), {}};
    const auto chance = 30 + random() % 65;
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
      const auto parents = statue->parents(row);
      cut.is_split[row] =
          !statue->is_leaf(row) && random() % 100 < chance &&
          std::all_of(parents.begin(), parents.end(), [&](access::RowIndex p) { return cut.is_split[p]; });
    }
    SCOPED_TRACE(round);
    expect_closed_surface(*statue, cut);
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
      const auto places = cut.active_places(*statue, row);
      had_partly_active = had_partly_active || (places != 0 && places != statue->rows()[row].tetra_mask);
    }
    EXPECT_EQ(triangle_count(*statue, cut), counted_anew(*statue, cut));
  }
  EXPECT_TRUE(had_partly_active);
}

TEST(Cut, ErrorCutIsTheCoarsestWithinTheError) {
  DiamondsFixture fixture(torus(40, 24), 100);
  const auto statue = fixture.open();
  std::vector<double> errors{0.0, std::numeric_limits<double>::infinity()};
  for (access::RowIndex row = 0; row < statue->rows().size(); row += 7)
    errors.push_back(statue->rows()[row].error);
  for (const double error : errors) {
    SCOPED_TRACE(error);
    const Cut cut = cut_with_error(*statue, error);
    ASSERT_TRUE(is_closed_under_parents(*statue, cut));
    bool has_leaf_above = false;
    std::vector<bool> has_split_child(statue->rows().size(), false);
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
      if (cut.active_places(*statue, row) != 0 && statue->rows()[row].error > error) {
        EXPECT_TRUE(statue->is_leaf(row)) << statue->name(row);
        has_leaf_above = true;
      }
      if (cut.is_split[row])
        for (const access::RowIndex parent : statue->parents(row)) has_split_child[parent] = true;
    }
    EXPECT_EQ(cut.warning.empty(), !has_leaf_above) << cut.warning;
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row)
      if (cut.is_split[row] && !has_split_child[row]) {
        EXPECT_GT(statue->rows()[row].error, error) << "needlessly split";
      }
  }
}

TEST(Cut, TriangleCutIsAPrefixOfTheRefinementOrder) {
  DiamondsFixture fixture(torus(30, 16), 100);
  // Errors out of step with the levels, so that parents have to be forced, and with many ties.
  std::mt19937 random(5);
  for (auto& [key, node] : fixture.nodes) node.row.error = 1.0 + static_cast<double>(random() % 16);
  const auto statue = fixture.open();
  const std::uint64_t root = statue->rows()[0].triangles;
  const std::uint64_t finest = triangle_count(*statue, cut_at_level(*statue, 99));
  ASSERT_GT(finest, root);
  for (const std::uint64_t most :
       {root, root + 1, (root + finest) / 2, root + (finest - root) / 5, finest - 1, finest, finest * 10}) {
    SCOPED_TRACE(most);
    const Cut cut = cut_with_triangles(*statue, most);
    EXPECT_EQ(cut.is_split, brute_force_triangles(*statue, most).is_split);
    EXPECT_LE(counted_anew(*statue, cut), most);
    EXPECT_TRUE(cut.warning.empty());
    EXPECT_LE(assemble(*statue, cut).triangles.size(), most);
  }
  const Cut too_few = cut_with_triangles(*statue, root - 1);
  EXPECT_NE(too_few.warning, "");
  EXPECT_EQ(too_few.is_split, std::vector<bool>(statue->rows().size(), false));
}

TEST(Cut, EyeCutRefinesWhatIsNearAndIsClosed) {
  DiamondsFixture fixture(torus(40, 24), 50);
  const auto statue = fixture.open();
  const auto& bounds = statue->rows()[0].bounds;
  std::mt19937 random(5);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double root_side = statue->lattice().step * geometry::kRootSide;
  for (int i = 0; i < 20; ++i) {
    const verify::measure::WorldPoint eye{within(bounds[0], bounds[3]), within(bounds[1], bounds[4]),
                                          within(bounds[2], bounds[5])};
    const double kappa = 0.1 + 0.1 * i;
    const Cut cut = cut_at_eye(*statue, {eye, kappa});
    ASSERT_TRUE(is_closed_under_parents(*statue, cut));
    for (access::RowIndex row = 0; row < statue->rows().size(); ++row) {
      if (cut.active_places(*statue, row) == 0 || statue->is_leaf(row)) continue;
      const auto& box = statue->rows()[row].bounds;
      double distance = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        distance = std::max({distance, box[k] - eye[k], eye[k] - box[k + 3]});
      EXPECT_GE(distance, kappa * root_side / std::pow(2.0, statue->rows()[row].level / 3))
          << statue->name(row);
    }
    EXPECT_EQ(census_of(assemble(*statue, cut)).border_edges, 0U);
    EXPECT_LE(triangle_count(*statue, cut), triangle_count(*statue, cut_at_eye(*statue, {eye, kappa + 0.5})));
  }
  const verify::measure::WorldPoint far{1e9, 0, 0};
  EXPECT_EQ(cut_at_eye(*statue, {far, std::nullopt}).is_split,
            std::vector<bool>(statue->rows().size(), false));
  for (const double kappa : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(cut_at_eye(*statue, {far, kappa}), core::Error);
  EXPECT_THROW(cut_at_eye(*statue, {{0, std::nan(""), 0}, 2.0}), core::Error);
  EXPECT_THROW(cut_at_eye(*statue, {{0, 0, HUGE_VAL}, 2.0}), core::Error);
}

}  // namespace
}  // namespace colossus::reader::diamonds
