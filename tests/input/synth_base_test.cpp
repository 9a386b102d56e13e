// Statues on a base mesh of the user's: smooth, and true to its topology.
#include "synth_testing.hpp"

namespace colossus::input {
namespace {

BaseMesh tetrahedron() {
  return {"tetrahedron",
          {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
          {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {128, 128, 128}}};
}

BaseMesh cube() {
  BaseMesh mesh;
  mesh.name = "cube";
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)});
  const std::array<std::array<std::uint32_t, 4>, 6> quads = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : quads) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

// A sphere of few facets: an octahedron, each side cut into four, `times` times over.
BaseMesh sphere(int times) {
  BaseMesh mesh = {"sphere",
                   {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                   {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}},
                   {}};
  for (int i = 0; i < times; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, is_new] = middles.insert({{std::min(a, b), std::max(a, b)}, 0});
      if (!is_new) return place->second;
      place->second = static_cast<std::uint32_t>(mesh.positions.size());
      Point p = mesh.positions[a];
      for (std::size_t c = 0; c < 3; ++c) p[c] += mesh.positions[b][c];
      const double radius = length(p);
      for (double& c : p) c /= radius;
      mesh.positions.push_back(p);
      return place->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  return mesh;
}

// As STL files have it: no vertex is shared.
BaseMesh soup(const BaseMesh& mesh) {
  BaseMesh result{mesh.name + " soup", {}, {}, {}};
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(result.positions.size());
    result.triangles.push_back({first, first + 1, first + 2});
    for (const std::uint32_t v : t) result.positions.push_back(mesh.positions[v]);
  }
  return result;
}

class SynthBase : public Synth {};

TEST_F(SynthBase, ClosedBaseStaysClosed) {
  for (const BaseMesh& base : {tetrahedron(), cube(), soup(cube())})
    for (const std::uint64_t k : {1U, 2U, 3U, 4U, 7U, 40U}) {
      SCOPED_TRACE(fmt::format("{} k {}", base.name, k));
      const std::uint64_t triangles = k * k * base.triangles.size();
      SynthOptions made = options(triangles + k * base.triangles.size() / 2);
      made.shuffle = k == 7;
      const Ply ply = parse(bytes(made, base));
      EXPECT_EQ(report_.triangles, triangles);
      expect_closed_manifold(ply);
      EXPECT_GT(volume(ply), 0);
    }
}

TEST_F(SynthBase, BaseShapeIsKept) {
  const BaseMesh base = cube();
  const Ply ply = parse(bytes(options(12 * 64 * 64), base));
  // The corners come first, moved by no more than the noise of a small scanner.
  for (std::size_t i = 0; i < 8; ++i) {
    const auto nearest = std::ranges::min(base.positions, {},
                                          [&](const Point& p) { return length(minus(p, ply.positions[i])); });
    EXPECT_LT(length(minus(nearest, ply.positions[i])), 0.2);
  }
  // Rounder than the cube, since its surface is smooth, but not by much.
  EXPECT_GT(volume(ply), 0.9);
  EXPECT_LT(volume(ply), 2.2);
}

// Where facets met, the subdivided surface is about as smooth as between: relief, but no crease.
TEST_F(SynthBase, BaseFacetsDoNotShow) {
  const BaseMesh base = sphere(2);
  const std::uint32_t k = 32, corners = 66, edges = 192, along = k - 1;
  const Ply ply = parse(bytes(options(base.triangles.size() * k * k), base));
  std::map<std::pair<std::uint32_t, std::uint32_t>, Point> sides;
  for (const Triangle& t : ply.triangles)
    for (std::size_t i = 0; i < 3; ++i) sides[{t[i], t[(i + 1) % 3]}] = area_vector(ply, t);
  std::array<double, 2> bend{}, count{};
  for (const auto& [ends, area] : sides) {
    const auto [a, b] = ends;
    if (a > b) continue;
    // On a base edge lie successive vertices of one edge's numbers.
    const bool on_edge =
        a >= corners && b < corners + edges * along && (a - corners) / along == (b - corners) / along;
    const Point& other = sides.at({b, a});
    bend[on_edge] += 1 - dot(area, other) / (length(area) * length(other));
    ++count[on_edge];
  }
  EXPECT_EQ(count[1], edges * (along - 1));
  EXPECT_LT(bend[1] / count[1], 1.4 * bend[0] / count[0]);
}

TEST_F(SynthBase, BordersStayStraightAndInPlace) {
  const BaseMesh square = {"square",
                           {{0, 0, 5}, {4, 0, 5}, {4, 4, 5}, {0, 4, 5}, {2, 2, 5}},
                           {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
                           {}};
  for (const std::uint64_t k : {1U, 2U, 9U, 30U}) {
    const Ply ply = parse(bytes(options(k * k * 4), square));
    const Uses uses = edge_uses(ply.triangles);
    const std::size_t border = edges_used(uses, {1, 0}) + edges_used(uses, {0, 1});
    EXPECT_EQ(border, 4 * k);
    EXPECT_EQ(border + edges_used(uses, {1, 1}), uses.size());
    EXPECT_EQ(ply.positions.size() + ply.triangles.size(), uses.size() + 1);
    double perimeter = 0, highest = 0;
    for (const auto& [edge, use] : uses) {
      if (use == std::array{1, 1}) continue;
      const Point &a = ply.positions[edge.first], &b = ply.positions[edge.second];
      perimeter += length(minus(a, b));
      for (const Point& p : {a, b}) {
        EXPECT_EQ(p[2], 5);
        EXPECT_LT(std::min({p[0], p[1], 4 - p[0], 4 - p[1]}), 1e-6);
      }
    }
    EXPECT_NEAR(perimeter, 16, 1e-5);
    for (const Point& p : ply.positions) highest = std::max(highest, std::abs(p[2] - 5));
    EXPECT_GT(highest, 0) << "no relief at all";
    EXPECT_LT(highest, 0.5);
  }
}

TEST_F(SynthBase, ThreeSheetsStayOnTheirEdge) {
  const BaseMesh fan = {"three sheets",
                        {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}},
                        {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}},
                        {}};
  for (const std::uint64_t k : {1U, 3U, 10U}) {
    const Ply ply = parse(bytes(options(k * k * 3), fan));
    const Uses uses = edge_uses(ply.triangles);
    std::size_t triple = 0, single = 0;
    for (const auto& [edge, use] : uses) {
      single += use[0] + use[1] == 1;
      if (use[0] + use[1] != 3) continue;
      ++triple;
      for (const std::uint32_t v : {edge.first, edge.second}) {
        EXPECT_EQ(ply.positions[v][0], 0);
        EXPECT_EQ(ply.positions[v][1], 0);
      }
    }
    EXPECT_EQ(triple, k);
    EXPECT_EQ(single, 6 * k);
    EXPECT_EQ(ply.positions.size(), 5 + 7 * (k - 1) + (k > 2 ? 3 * (k - 1) * (k - 2) / 2 : 0));
  }
}

TEST_F(SynthBase, BaseColorsAreInterpolated) {
  const Ply ply = parse(bytes(options(4 * 20 * 20), tetrahedron()));
  const std::vector<Color> expected = {
      {255, 0, 0}, {0, 0, 255}, {0, 255, 0}, {128, 128, 128}};  // by first use
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(ply.colors[i][c], expected[i][c], 20);
  // Half-way along the first edge, from vertex 0 to 1 of the file.
  const Color middle = ply.colors[4 + 9];
  EXPECT_NEAR(middle[0], 128, 20);
  EXPECT_NEAR(middle[1], 0, 20);
  EXPECT_NEAR(middle[2], 128, 20);
}

TEST_F(SynthBase, FarBaseKeepsItsDetailInDoubles) {
  BaseMesh far = cube();
  for (Point& p : far.positions) p = {p[0] + 500'000, p[1] + 5'000'000, p[2]};
  const Ply ply = parse(bytes(options(12 * 50 * 50), far));
  EXPECT_EQ(std::ranges::count(ply.header, "property double x"), 1);
  expect_closed_manifold(ply);
}

TEST_F(SynthBase, BadBaseMeshesAreRefused) {
  const auto status = [&](const BaseMesh& base, const std::string& part) {
    try {
      synthesize(options(100), base);
    } catch (const core::Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      EXPECT_FALSE(std::filesystem::exists(folder_.path() / "statue.ply"));
      return static_cast<int>(error.status());
    }
    return 0;
  };
  BaseMesh bad = tetrahedron();
  bad.triangles[2][1] = 4;
  EXPECT_EQ(status(bad, "tetrahedron: face 2: vertex index 4"), 65);
  bad = tetrahedron();
  bad.positions[3][1] = std::nan("");
  EXPECT_EQ(status(bad, "tetrahedron: vertex 3"), 65);
  bad.triangles.clear();
  EXPECT_EQ(status(bad, "no triangles"), 65);
  bad = tetrahedron();
  bad.triangles = {{1, 1, 2}};
  EXPECT_EQ(status(bad, "degenerate"), 65);
}

}  // namespace
}  // namespace colossus::input
