// Synthetic statues: closed, even, the same bytes everywhere, and true to a base mesh's topology.
#include "input/synth.hpp"

#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

#include "core/file.hpp"
#include "input/synth_order.hpp"
#include "input_testing.hpp"

namespace colossus::input {
namespace {

using Point = std::array<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;
using Color = std::array<std::uint8_t, 3>;

struct Ply {
  std::vector<std::string> header;
  std::vector<Point> positions, normals;
  std::vector<Color> colors;
  std::vector<Triangle> triangles;
};

// Reads what synth writes, and nothing else: every byte must be accounted for.
Ply parse(const core::Bytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t end = text.find("end_header\n") + 11;
  Ply ply;
  std::istringstream lines{std::string(text.substr(0, end))};
  std::uint64_t vertex_count = 0, face_count = 0;
  for (std::string line; std::getline(lines, line);) {
    ply.header.push_back(line);
    if (line.starts_with("element vertex ")) vertex_count = std::stoull(line.substr(15));
    if (line.starts_with("element face ")) face_count = std::stoull(line.substr(13));
  }
  const auto has = [&](const char* line) { return std::ranges::count(ply.header, line) == 1; };
  const bool doubles = has("property double x"), normals = has("property float nx"), colors = has("property uchar red");
  core::ByteReader reader{std::span(bytes).subspan(end)};
  for (std::uint64_t i = 0; i < vertex_count; ++i) {
    Point position{}, normal{};
    for (double& c : position) c = doubles ? reader.get<double>() : static_cast<double>(reader.get<float>());
    ply.positions.push_back(position);
    if (normals)
      for (double& c : normal) c = static_cast<double>(reader.get<float>());
    if (normals) ply.normals.push_back(normal);
    if (colors) ply.colors.push_back(reader.get<Color>());
  }
  for (std::uint64_t i = 0; i < face_count; ++i) {
    EXPECT_EQ(reader.get<std::uint8_t>(), 3);
    ply.triangles.push_back(reader.get<Triangle>());
  }
  EXPECT_FALSE(reader.failed());
  EXPECT_EQ(reader.remaining(), 0U);
  return ply;
}

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point& a) { return std::sqrt(dot(a, a)); }

Point area_vector(const Ply& ply, const Triangle& t) {
  const Point cross_product = cross(minus(ply.positions[t[1]], ply.positions[t[0]]), minus(ply.positions[t[2]], ply.positions[t[0]]));
  return {cross_product[0] / 2, cross_product[1] / 2, cross_product[2] / 2};
}

double volume(const Ply& ply) {
  double sum = 0;
  for (const Triangle& t : ply.triangles)
    sum += dot(ply.positions[t[0]], cross(ply.positions[t[1]], ply.positions[t[2]])) / 6;
  return sum;
}

// Per undirected edge, how many triangles use it each way.
using Uses = std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<int, 2>>;

Uses edge_uses(const std::vector<Triangle>& triangles) {
  Uses uses;
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}][a < b ? 0 : 1];
    }
  return uses;
}

std::size_t edges_used(const Uses& uses, const std::array<int, 2>& as) {
  return static_cast<std::size_t>(std::ranges::count_if(uses, [&](const auto& use) { return use.second == as; }));
}

class Synth : public testing::Test {
 protected:
  SynthOptions options(std::uint64_t triangles) const {
    SynthOptions result;
    result.output = folder_.path() / "statue.ply";
    result.triangles = triangles;
    return result;
  }
  core::Bytes bytes(const SynthOptions& made) const {
    report_ = synthesize(made);
    return core::read_file(made.output);
  }
  core::Bytes bytes(const SynthOptions& made, const BaseMesh& base) const {
    report_ = synthesize(made, base);
    return core::read_file(made.output);
  }
  // The status that making this statue fails with; checks that nothing is left behind.
  int failure(const SynthOptions& made) const {
    try {
      synthesize(made);
    } catch (const core::Error& error) {
      std::filesystem::path part = made.output;
      part += ".part";
      EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(part)));
      EXPECT_NE(std::string(error.what()), "");
      return static_cast<int>(error.status());
    }
    return 0;
  }

  TemporaryFolder folder_;
  mutable SynthReport report_;
};

void expect_closed_manifold(const Ply& ply) {
  const Uses uses = edge_uses(ply.triangles);
  EXPECT_EQ(edges_used(uses, {1, 1}), uses.size());
  EXPECT_EQ(ply.positions.size() + ply.triangles.size(), uses.size() + 2) << "Euler characteristic";
  const std::set<Point> distinct(ply.positions.begin(), ply.positions.end());
  EXPECT_EQ(distinct.size(), ply.positions.size()) << "vertices at one position";
}

TEST_F(Synth, StatueIsClosedManifoldAndOutwardAtEverySize) {
  for (const std::uint64_t triangles : {1U, 12U, 20U, 100U, 1000U, 10'000U, 10'001U, 54'321U, 300'000U}) {
    SCOPED_TRACE(triangles);
    const Ply ply = parse(bytes(options(triangles)));
    EXPECT_EQ(ply.positions.size(), report_.vertices);
    EXPECT_EQ(ply.triangles.size(), report_.triangles);
    expect_closed_manifold(ply);
    EXPECT_GT(volume(ply), 0.05e9);
    EXPECT_LT(volume(ply), 0.60e9);
    double smallest = 1e30, sum = 0;
    for (const Triangle& t : ply.triangles) {
      const double area = length(area_vector(ply, t));
      smallest = std::min(smallest, area);
      sum += area;
    }
    EXPECT_GT(smallest, 0.01 * sum / static_cast<double>(ply.triangles.size()));
    for (const Point& p : ply.positions)
      for (const double c : p) EXPECT_TRUE(std::isfinite(c));
  }
}

TEST_F(Synth, CountsAreNearTheRequest) {
  for (const std::uint64_t triangles : {12U, 100U, 10'000U, 300'000U}) {
    synthesize(options(12));
    const SynthReport report = synthesize(options(triangles));
    EXPECT_EQ(report.triangles, triangles);
  }
  for (std::uint64_t triangles = 10'000; triangles < 400'000; triangles = triangles * 9 / 7 + 1) {
    const auto made = static_cast<double>(synthesize(options(triangles)).triangles);
    EXPECT_NEAR(made, static_cast<double>(triangles), 0.01 * static_cast<double>(triangles));
  }
}

TEST_F(Synth, TrianglesAreEven) {
  const Ply ply = parse(bytes(options(100'000)));
  std::vector<double> edges;
  for (const Triangle& t : ply.triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.push_back(length(minus(ply.positions[t[i]], ply.positions[t[(i + 1) % 3]])));
  std::ranges::sort(edges);
  EXPECT_LT(edges[edges.size() * 99 / 100], 6 * edges[edges.size() / 100]);
  EXPECT_LT(edges.back(), 50 * edges.front());
}

// Over six edges along the rings, the surface bends by the same at every size: the relief goes as deep as the edges.
TEST_F(Synth, DetailReachesAFewEdgesAtEverySize) {
  for (const std::uint64_t triangles : {20'000U, 200'000U, 2'000'000U}) {
    SynthOptions made = options(triangles);
    made.colors = false;
    const Ply ply = parse(bytes(made));
    // The middle half of the vertices lies on rings, in order.
    double bend = 0, across = 0;
    for (std::size_t i = ply.positions.size() / 4; i < ply.positions.size() * 3 / 4; ++i) {
      const Point &before = ply.positions[i - 3], &after = ply.positions[i + 3];
      const Point to = minus(ply.positions[i], before), on = minus(after, ply.positions[i]);
      bend += length(minus(on, to));
      across += length(minus(after, before));
    }
    std::cout << triangles << ' ' << bend / across << '\n';
    EXPECT_GT(bend / across, 0.05) << triangles;
  }
}

TEST_F(Synth, BytesDependOnSeedButNotOnThreads) {
  SynthOptions made = options(150'000);
  made.normals = true;
  for (const bool shuffle : {false, true}) {
    made.shuffle = shuffle;
    made.seed = 7;
    made.threads = 1;
    const core::Bytes one = bytes(made);
    for (const unsigned threads : {2U, 3U, 0U}) {
      made.threads = threads;
      EXPECT_EQ(bytes(made), one) << threads << " threads, shuffle " << shuffle;
    }
    made.seed = 8;
    EXPECT_NE(bytes(made), one);
  }
}

TEST_F(Synth, SeedsDifferInRelief) {
  SynthOptions made = options(20'000);
  const Ply one = parse(bytes(made));
  made.seed = 2;
  const Ply two = parse(bytes(made));
  double farthest = 0;
  for (std::size_t i = 0; i < one.positions.size(); ++i)
    farthest = std::max(farthest, length(minus(one.positions[i], two.positions[i])));
  EXPECT_GT(farthest, 5) << "millimetres; the scanner's noise is below 2";
}

constexpr std::uint64_t kGolden = 12258328321678355528U;

// The hash of a small statue, so that a change of compiler, build type or code that changes the bytes is noticed.
TEST_F(Synth, BytesAreTheSameOnEveryMachine) {
  SynthOptions made = options(3000);
  made.normals = true;
  EXPECT_EQ(core::hash64(bytes(made)), kGolden);
}

TEST_F(Synth, HeaderListsWhatWasAskedFor) {
  SynthOptions made = options(12);
  made.normals = true;
  const std::vector<std::string> full = {
      "ply", "format binary_little_endian 1.0", "comment colossus synth, seed 1", "element vertex 8",
      "property float x", "property float y", "property float z", "property float nx", "property float ny",
      "property float nz", "property uchar red", "property uchar green", "property uchar blue", "element face 12",
      "property list uchar int vertex_indices", "end_header"};
  EXPECT_EQ(parse(bytes(made)).header, full);
  made.normals = made.colors = false;
  const Ply bare = parse(bytes(made));
  EXPECT_EQ(bare.header.size(), full.size() - 6);
  EXPECT_TRUE(bare.colors.empty());
}

TEST_F(Synth, ColorsVary) {
  const Ply ply = parse(bytes(options(50'000)));
  std::vector<std::size_t> histogram(256);
  for (const Color& c : ply.colors) ++histogram[c[0]];
  EXPECT_GT(std::ranges::count_if(histogram, [](std::size_t n) { return n > 20; }), 60);
  EXPECT_LT(histogram[0] + histogram[255], ply.colors.size() / 50);
}

TEST_F(Synth, NormalsAreThoseOfTheSurface) {
  SynthOptions made = options(100'000);
  made.normals = true;
  const Ply ply = parse(bytes(made));
  double sum = 0;
  for (const Triangle& t : ply.triangles) {
    const Point area = area_vector(ply, t);
    for (const std::uint32_t v : t) sum += dot(area, ply.normals[v]) / length(area);
  }
  EXPECT_GT(sum / (3.0 * static_cast<double>(ply.triangles.size())), 0.97);
  for (const Point& n : ply.normals) EXPECT_NEAR(length(n), 1, 1e-5);
}

std::multiset<std::array<Point, 3>> corners_of(const Ply& ply) {
  std::multiset<std::array<Point, 3>> result;
  for (const Triangle& t : ply.triangles) {
    result.insert({ply.positions[t[0]], ply.positions[t[1]], ply.positions[t[2]]});
  }
  return result;
}

TEST_F(Synth, ShuffleOnlyReorders) {
  SynthOptions made = options(40'000);
  const Ply plain = parse(bytes(made));
  made.shuffle = true;
  const Ply shuffled = parse(bytes(made));
  EXPECT_EQ(corners_of(shuffled), corners_of(plain));
  std::multiset<std::pair<Point, Color>> before, after;
  for (std::size_t i = 0; i < plain.positions.size(); ++i) {
    before.insert({plain.positions[i], plain.colors[i]});
    after.insert({shuffled.positions[i], shuffled.colors[i]});
  }
  EXPECT_EQ(after, before);
  // No locality: the corners of a triangle, and of successive triangles, lie anywhere.
  const auto mean_jump = [](const Ply& ply) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < ply.triangles.size(); ++i)
      for (const std::uint32_t other : {ply.triangles[i][1], ply.triangles[i + 1][0]})
        sum += std::abs(static_cast<double>(ply.triangles[i][0]) - static_cast<double>(other));
    return sum / static_cast<double>(2 * ply.triangles.size() * ply.positions.size());
  };
  EXPECT_NEAR(mean_jump(shuffled), 1.0 / 3, 0.02);
  EXPECT_LT(mean_jump(plain), 0.01);
}

TEST(SynthOrder, IsAPermutationWithItsInverse) {
  for (const std::uint64_t count : {1U, 2U, 3U, 4U, 5U, 16U, 17U, 1000U, 4096U, 65'537U}) {
    const SynthOrder order(count, count * 31 + 5);
    std::vector<bool> seen(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t to = order.forward(i);
      ASSERT_LT(to, count);
      EXPECT_FALSE(seen[to]);
      seen[to] = true;
      EXPECT_EQ(order.backward(to), i);
    }
  }
}

BaseMesh tetrahedron() {
  return {"tetrahedron", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
          {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {128, 128, 128}}};
}

BaseMesh cube() {
  BaseMesh mesh;
  mesh.name = "cube";
  for (int i = 0; i < 8; ++i) mesh.positions.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1)});
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
  BaseMesh mesh = {"sphere", {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                   {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}, {}};
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

TEST_F(Synth, ClosedBaseStaysClosed) {
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

TEST_F(Synth, BaseShapeIsKept) {
  const BaseMesh base = cube();
  const Ply ply = parse(bytes(options(12 * 64 * 64), base));
  // The corners come first, moved by no more than the noise of a small scanner.
  for (std::size_t i = 0; i < 8; ++i) {
    const auto nearest = std::ranges::min(base.positions, {}, [&](const Point& p) { return length(minus(p, ply.positions[i])); });
    EXPECT_LT(length(minus(nearest, ply.positions[i])), 0.2);
  }
  // Rounder than the cube, since its surface is smooth, but not by much.
  EXPECT_GT(volume(ply), 0.9);
  EXPECT_LT(volume(ply), 2.2);
}

// Where facets met, the subdivided surface is about as smooth as between: relief, but no crease.
TEST_F(Synth, BaseFacetsDoNotShow) {
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
    const bool on_edge = a >= corners && b < corners + edges * along && (a - corners) / along == (b - corners) / along;
    const Point& other = sides.at({b, a});
    bend[on_edge] += 1 - dot(area, other) / (length(area) * length(other));
    ++count[on_edge];
  }
  EXPECT_EQ(count[1], edges * (along - 1));
  EXPECT_LT(bend[1] / count[1], 1.4 * bend[0] / count[0]);
}

TEST_F(Synth, BordersStayStraightAndInPlace) {
  const BaseMesh square = {"square", {{0, 0, 5}, {4, 0, 5}, {4, 4, 5}, {0, 4, 5}, {2, 2, 5}},
                           {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}, {}};
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

TEST_F(Synth, ThreeSheetsStayOnTheirEdge) {
  const BaseMesh fan = {"three sheets", {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}},
                        {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}, {}};
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

TEST_F(Synth, BaseColorsAreInterpolated) {
  const Ply ply = parse(bytes(options(4 * 20 * 20), tetrahedron()));
  const std::vector<Color> expected = {{255, 0, 0}, {0, 0, 255}, {0, 255, 0}, {128, 128, 128}};  // by first use
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(ply.colors[i][c], expected[i][c], 20);
  // Half-way along the first edge, from vertex 0 to 1 of the file.
  const Color middle = ply.colors[4 + 9];
  EXPECT_NEAR(middle[0], 128, 20);
  EXPECT_NEAR(middle[1], 0, 20);
  EXPECT_NEAR(middle[2], 128, 20);
}

TEST_F(Synth, FarBaseKeepsItsDetailInDoubles) {
  BaseMesh far = cube();
  for (Point& p : far.positions) p = {p[0] + 500'000, p[1] + 5'000'000, p[2]};
  const Ply ply = parse(bytes(options(12 * 50 * 50), far));
  EXPECT_EQ(std::ranges::count(ply.header, "property double x"), 1);
  expect_closed_manifold(ply);
}

TEST_F(Synth, BadBaseMeshesAreRefused) {
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

TEST_F(Synth, ErrorsHaveTheirStatusAndLeaveNothingBehind) {
  EXPECT_EQ(failure(options(0)), 2);
  EXPECT_EQ(failure(options(std::uint64_t{1} << 40)), 2);
  EXPECT_EQ(failure(options((std::uint64_t{1} << 32) + 1)), 2);
  SynthOptions made = options(100'000);
  made.output = folder_.path() / "missing" / "statue.ply";
  EXPECT_EQ(failure(made), 73);
  made.output = folder_.path() / "directory";
  std::filesystem::create_directories(made.output / "full");
  EXPECT_EQ(failure(made), 73);
  made.output = folder_.path() / "disk.ply";
  std::filesystem::create_symlink("/dev/full", folder_.path() / "disk.ply.part");
  EXPECT_EQ(failure(made), 69);
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

// A write that fails in the middle, on whichever thread.
TEST_F(Synth, AFileThatCannotGrowIsRemoved) {
  struct rlimit before {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small = {1'000'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  SynthOptions made = options(300'000);
  std::vector<int> statuses;
  for (const unsigned threads : {1U, 3U}) {
    made.threads = threads;
    statuses.push_back(failure(made));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(statuses, std::vector<int>({74, 74}));
  EXPECT_FALSE(std::filesystem::exists(made.output));
}

TEST_F(Synth, AnOldFileIsReplacedAndNoPartRemains) {
  SynthOptions made = options(12);
  folder_.write("statue.ply", "old");
  folder_.write("statue.ply.part", std::string(100'000, 'x'));
  const Ply ply = parse(bytes(made));
  EXPECT_EQ(ply.triangles.size(), 12U);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "statue.ply.part"));
}

}  // namespace
}  // namespace colossus::input
