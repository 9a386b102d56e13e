#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "codec/node_codec.hpp"
#include "codec/quantization/quantize.hpp"
#include "mesh/topology.hpp"

namespace colossus::codec {
namespace {

using geometry::Plane;
using geometry::Point;
using hierarchy::Tetrahedron;
using mesh::Triangle;
using Random = std::mt19937_64;

// Both ends included.
std::int64_t pick(Random& random, std::int64_t low, std::int64_t high) {
  return std::uniform_int_distribution<std::int64_t>(low, high)(random);
}

Tetrahedron random_tetrahedron(Random& random, int level) {
  const hierarchy::Diamond root = hierarchy::Diamond::at(hierarchy::root_center());
  Tetrahedron tetrahedron = root.tetrahedra[static_cast<std::size_t>(pick(random, 0, root.place_count - 1))];
  for (int l = 0; l < level; ++l) tetrahedron = tetrahedron.child(static_cast<int>(pick(random, 0, 1)));
  return tetrahedron;
}

// Any lattice point of the box around the given tetrahedron.
Point random_point_around(Random& random, const Tetrahedron& tetrahedron) {
  Point point;
  for (int axis = 0; axis < 3; ++axis) {
    std::int32_t low = geometry::kRootSide;
    std::int32_t high = 0;
    for (const Point& corner : tetrahedron.corners) {
      low = std::min(low, corner[axis]);
      high = std::max(high, corner[axis]);
    }
    point[axis] = static_cast<std::int32_t>(pick(random, low, high));
  }
  return point;
}

Point random_point_inside(Random& random, const Tetrahedron& tetrahedron) {
  for (;;)
    if (const Point point = random_point_around(random, tetrahedron); tetrahedron.contains(point))
      return point;
}

// A lattice point in the convex hull of some corners: all edges run along primitive lattice vectors.
Point random_point_of(Random& random, const std::vector<Point>& corners) {
  Point point = corners[0];
  std::int64_t left = std::int64_t{1} << 31;
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Point& to = corners[k];
    std::int64_t divisor = 0;
    for (int axis = 0; axis < 3; ++axis)
      divisor = std::gcd(divisor, std::int64_t{to[axis]} - corners[0][axis]);
    const std::int64_t share = pick(random, 0, left);
    left -= share;
    const std::int64_t steps = (divisor * share) >> 31;
    for (int axis = 0; axis < 3; ++axis)
      point[axis] += static_cast<std::int32_t>((std::int64_t{to[axis]} - corners[0][axis]) / divisor * steps);
  }
  return point;
}

std::array<double, 3> decoded_position(const coded::Weights& weights, const Tetrahedron& tetrahedron,
                                       int bits) {
  const coded::ScaledPosition scaled = coded::scaled_position(weights, tetrahedron);
  std::array<double, 3> position{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    position[axis] = std::ldexp(static_cast<double>(scaled[axis]), -bits);
  return position;
}

double distance(const std::array<double, 3>& a, const Point& b) {
  return std::hypot(a[0] - b.x, a[1] - b.y, a[2] - b.z);
}

void expect_exact_weights(const Tetrahedron& tetrahedron, const Point& point, int bits) {
  SCOPED_TRACE(testing::Message() << "point " << point.x << ' ' << point.y << ' ' << point.z << ", bits "
                                  << bits);
  const quantization::Barycentric barycentric(tetrahedron);
  const coded::Weights weights = barycentric.weights(point, bits);
  EXPECT_EQ(std::accumulate(weights.begin(), weights.end(), std::uint64_t{0}), std::uint64_t{1} << bits);
  std::uint8_t marks = 0;  // by the planes alone
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Plane plane = tetrahedron.face_plane(i);
    const double lambda =
        static_cast<double>(plane.side(point)) / static_cast<double>(plane.side(tetrahedron.corners[k]));
    EXPECT_EQ(weights[k] == 0, plane.side(point) == 0) << "corner " << i;
    // Less than one unit by rounding, and up to three units given to or taken from the others.
    EXPECT_LT(std::abs(weights[k] - std::ldexp(lambda, bits)), 4.0) << "corner " << i;
    if (plane.side(point) == 0) marks = static_cast<std::uint8_t>(marks | 1U << i);
  }
  EXPECT_EQ(coded::marks_of(weights), marks);
}

TEST(Barycentric, WeightsSumToAllAndVanishExactlyOnTheOppositeFace) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    for (int round = 0; round < 120; ++round) {
      const Tetrahedron tetrahedron = random_tetrahedron(random, static_cast<int>(pick(random, 0, 70)));
      const auto& corners = tetrahedron.corners;
      for (const int bits : {8, 12, 16}) {
        expect_exact_weights(tetrahedron, random_point_inside(random, tetrahedron), bits);
        for (unsigned subset = 1; subset < 16; ++subset) {
          std::vector<Point> chosen;
          for (std::size_t i = 0; i < 4; ++i)
            if ((subset >> i & 1U) != 0) chosen.push_back(corners[i]);
          expect_exact_weights(tetrahedron, random_point_of(random, chosen), bits);
        }
      }
      if (HasFailure()) return;
    }
  }
}

TEST(Barycentric, CornersKeepTheWholeWeightAndTheirNeighboursTheLeast) {
  const Tetrahedron root = hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0];
  const quantization::Barycentric barycentric(root);
  for (std::size_t i = 0; i < 4; ++i) {
    coded::Weights expected{};
    expected[i] = 1U << 12;
    EXPECT_EQ(barycentric.weights(root.corners[i], 12), expected);
  }
  // One unit beside the first corner along the long edge: far less than a unit of weight, and yet not on the
  // corner.
  EXPECT_EQ(barycentric.weights({1, 1, 1}, 12), (coded::Weights{4095, 0, 0, 1}));
}

struct Side {
  Tetrahedron tetrahedron;
  int opposite;  // the corner that is not on the face
};

// Tetrahedra by the faces that they have whole, among some of one diamond and three levels below it.
std::map<std::array<Point, 3>, std::vector<Side>> sides_of_faces(const hierarchy::Diamond& diamond) {
  std::vector<Tetrahedron> all(diamond.tetrahedra.begin(), diamond.tetrahedra.begin() + diamond.place_count);
  std::size_t first = 0;
  for (int level = 0; level < 3; ++level) {
    const std::size_t end = all.size();
    for (; first < end; ++first)
      for (const int which : {0, 1}) all.push_back(Tetrahedron(all[first]).child(which));
  }
  std::map<std::array<Point, 3>, std::vector<Side>> sides;
  for (const Tetrahedron& tetrahedron : all)
    for (int opposite = 0; opposite < 4; ++opposite) {
      std::array<Point, 3> face{};
      for (std::size_t i = 0, k = 0; i < 4; ++i)
        if (static_cast<int>(i) != opposite) face[k++] = tetrahedron.corners[i];
      sides[face].push_back({tetrahedron, opposite});
    }
  return sides;
}

void expect_same_weights(const Side& a, const Side& b, const Point& point, int bits) {
  const coded::Weights weights_a = quantization::Barycentric(a.tetrahedron).weights(point, bits);
  const coded::Weights weights_b = quantization::Barycentric(b.tetrahedron).weights(point, bits);
  EXPECT_EQ(weights_a[static_cast<std::size_t>(a.opposite)], 0U);
  EXPECT_EQ(weights_b[static_cast<std::size_t>(b.opposite)], 0U);
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      if (a.tetrahedron.corners[i] != b.tetrahedron.corners[k]) continue;
      EXPECT_EQ(weights_a[i], weights_b[k]);
    }
}

TEST(Barycentric, BothSidesOfAFaceAgreeOnItsPoints) {
  constexpr std::uint64_t kSeed = 4;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  std::size_t tried = 0;
  for (int round = 0; round < 25; ++round) {
    const Tetrahedron start = random_tetrahedron(random, static_cast<int>(pick(random, 0, 60)));
    const auto faces = sides_of_faces(hierarchy::Diamond::at(start.center()));
    for (const auto& [face, sides] : faces) {
      if (sides.size() < 2) continue;
      const Side& a = sides.front();
      const Side& b = sides.back();
      const Plane plane = a.tetrahedron.face_plane(a.opposite);
      std::vector<Point> points(face.begin(), face.end());
      points.push_back(random_point_of(random, {face[0], face[2]}));
      for (int attempt = 0; attempt < 30; ++attempt) {
        const Point p = random_point_around(random, a.tetrahedron);
        const Point q = random_point_around(random, b.tetrahedron);
        const std::int64_t side_p = plane.side(p);
        const std::int64_t side_q = plane.side(q);
        if (side_p != 0 && side_q != 0 && (side_p < 0) != (side_q < 0))
          points.push_back(geometry::cut_edge(p, q, side_p, side_q));
      }
      for (const Point& point : points) {
        if (!a.tetrahedron.contains(point) || !b.tetrahedron.contains(point)) continue;
        ++tried;
        for (const int bits : {8, 12, 16}) expect_same_weights(a, b, point, bits);
      }
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(tried, 5000U);
}

// The vertex's number as its colour, to tell which vertex of the input an output vertex is.
mesh::Vertex numbered_vertex(const Point& position, std::size_t number) {
  mesh::Vertex vertex;
  vertex.position = position;
  for (std::size_t k = 0; k < 4; ++k) vertex.color[k] = static_cast<std::uint8_t>(number >> (8 * k));
  return vertex;
}

std::uint32_t number_of(const mesh::Color& color) {
  return color[0] | std::uint32_t{color[1]} << 8 | std::uint32_t{color[2]} << 16 |
         std::uint32_t{color[3]} << 24;
}

mesh::Mesh numbered_mesh(const std::vector<Point>& positions, std::vector<Triangle> triangles) {
  mesh::Mesh mesh;
  for (const Point& position : positions)
    mesh.vertices.push_back(numbered_vertex(position, mesh.vertices.size()));
  mesh.triangles = std::move(triangles);
  return mesh;
}

// A closed grid on a torus around `center`, its rings noisy.
mesh::Mesh noisy_torus(Random& random, const Point& center, double radius, std::uint32_t rings) {
  std::vector<Point> positions;
  std::vector<Triangle> triangles;
  const double step = 2.0 * std::acos(-1.0) / rings;
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t k = 0; k < rings; ++k) {
      const double tube = radius * (0.25 + 0.05 * static_cast<double>(pick(random, 0, 1000)) / 1000.0);
      const double out = radius + tube * std::cos(step * k);
      positions.push_back({center.x + static_cast<std::int32_t>(out * std::cos(step * i)),
                           center.y + static_cast<std::int32_t>(out * std::sin(step * i)),
                           center.z + static_cast<std::int32_t>(tube * std::sin(step * k))});
      const std::uint32_t next_i = (i + 1) % rings;
      const std::uint32_t next_k = (k + 1) % rings;
      triangles.push_back({i * rings + k, next_i * rings + k, next_i * rings + next_k});
      triangles.push_back({i * rings + k, next_i * rings + next_k, i * rings + next_k});
    }
  return numbered_mesh(positions, triangles);
}

// The first vertex of each group that merges: the same weights and a common triangle.
std::vector<std::uint32_t> merged_groups(const mesh::Mesh& mesh, const std::vector<coded::Weights>& weights) {
  std::vector<std::uint32_t> groups(mesh.vertices.size());
  std::iota(groups.begin(), groups.end(), 0U);
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (const Triangle& t : mesh.triangles)
      for (const auto a : t)
        for (const auto b : t)
          if (weights[a] == weights[b] && groups[a] < groups[b]) {
            groups[b] = groups[a];
            has_changed = true;
          }
  }
  return groups;
}

void expect_displacement_bounds_all(const mesh::Mesh& mesh, const Tetrahedron& tetrahedron, int bits) {
  const quantization::Quantized quantized = quantization::quantize(mesh, tetrahedron, 0, {bits, false, true});
  const quantization::Barycentric barycentric(tetrahedron);
  std::vector<coded::Weights> weights;
  for (const mesh::Vertex& vertex : mesh.vertices)
    weights.push_back(barycentric.weights(vertex.position, bits));
  const auto groups = merged_groups(mesh, weights);
  // By group; several where something was kept apart.
  std::map<std::uint32_t, std::vector<std::size_t>> stored;
  for (std::size_t i = 0; i < quantized.tetrahedron.positions.size(); ++i)
    stored[groups[number_of(quantized.tetrahedron.colors[i])]].push_back(i);
  double greatest = 0.0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    double least = INFINITY;
    for (const std::size_t i : stored[groups[v]])
      least =
          std::min(least, distance(decoded_position(quantized.tetrahedron.positions[i], tetrahedron, bits),
                                   mesh.vertices[v].position));
    if (std::isfinite(least)) greatest = std::max(greatest, least);
  }
  EXPECT_GT(greatest, 0.0);
  EXPECT_LE(greatest, quantized.displacement * (1.0 + 1e-12));
  // Four units along edges no longer than the cube's diagonal.
  const double diagonal = std::sqrt(
      static_cast<double>(geometry::squared_distance(tetrahedron.corners[0], tetrahedron.corners[3])));
  EXPECT_LT(quantized.displacement, 4.0 * std::ldexp(diagonal, -bits));
}

TEST(Quantize, DisplacementBoundsTheMovementOfEveryVertex) {
  for (const std::uint64_t seed : {5U, 6U, 7U, 8U}) {
    Random random(seed);
    for (int round = 0; round < 20; ++round) {
      const Tetrahedron tetrahedron = random_tetrahedron(random, static_cast<int>(pick(random, 0, 40)));
      mesh::Mesh soup;
      for (std::uint32_t v = 0; v < 99; ++v)
        soup.vertices.push_back(numbered_vertex(random_point_inside(random, tetrahedron), v));
      for (std::uint32_t v = 0; v < 99; v += 3) soup.triangles.push_back({v, v + 1, v + 2});
      const int bits = static_cast<int>(pick(random, coded::kMinPositionBits, coded::kMaxPositionBits));
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", round " << round << ", bits " << bits);
      expect_displacement_bounds_all(soup, tetrahedron, bits);
    }
  }
}

Point centroid(const Tetrahedron& tetrahedron) {
  Point center;
  for (int axis = 0; axis < 3; ++axis) {
    std::int64_t sum = 0;
    for (const Point& corner : tetrahedron.corners) sum += corner[axis];
    center[axis] = static_cast<std::int32_t>(sum / 4);
  }
  return center;
}

// Small closed surfaces at few bits, where many vertices fall together: some merge, some step aside.
TEST(Quantize, DisplacementCountsVerticesThatMergeAndStepAside) {
  for (std::uint64_t seed = 9; seed < 29; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Tetrahedron tetrahedron = random_tetrahedron(random, 6);
    const double side = std::ldexp(1.0, geometry::kRootBits - 2);
    const double radius = side * static_cast<double>(pick(random, 20, 60)) / 1000.0;
    expect_displacement_bounds_all(noisy_torus(random, centroid(tetrahedron), radius, 40), tetrahedron, 8);
  }
}

TEST(Quantize, MakesNoInnerEdgeNonManifold) {
  std::size_t merged = 0;
  for (std::uint64_t seed = 30; seed < 50; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Tetrahedron tetrahedron = random_tetrahedron(random, 6);
    const double radius =
        std::ldexp(1.0, geometry::kRootBits - 2) * static_cast<double>(pick(random, 40, 80)) / 1000.0;
    const mesh::Mesh torus = noisy_torus(random, centroid(tetrahedron), radius, 32);
    const coded::CodedPart stored =
        quantization::quantize(torus, tetrahedron, 0, {8, false, false}).tetrahedron;
    merged += torus.vertices.size() - stored.positions.size();
    std::map<coded::Weights, std::uint32_t> welded;
    for (const coded::Weights& w : stored.positions)
      welded.try_emplace(w, static_cast<std::uint32_t>(welded.size()));
    std::vector<Triangle> triangles = stored.triangles;
    for (Triangle& t : triangles)
      for (auto& v : t) v = welded.at(stored.positions[v]);
    for (const mesh::Edge& edge : mesh::edges(triangles)) {
      EXPECT_FALSE(edge.is_nonmanifold());
      EXPECT_EQ(edge.forward, edge.backward);
    }
  }
  EXPECT_GT(merged, 100U);
}

// A tetrahedron of the first level with room for small coordinates: the corner 0 0 0 and side 2^30.
Tetrahedron first_root() { return hierarchy::Diamond::at(hierarchy::root_center()).tetrahedra[0]; }

// Four points of it that no quantisation brings together, and one that 8 bits bring to the first.
std::vector<Point> spread_points(const Tetrahedron& tetrahedron) {
  const Point middle = centroid(tetrahedron);
  std::vector<Point> points{middle};
  for (const Point& corner : tetrahedron.corners) points.push_back(geometry::midpoint(middle, corner));
  points.push_back({middle.x + 1, middle.y, middle.z});
  return points;
}

// Triangles by the numbers of the input's vertices, the smallest first.
std::vector<Triangle> numbered_triangles(const coded::CodedPart& part) {
  std::vector<Triangle> triangles;
  for (const Triangle& t : part.triangles) {
    Triangle n{number_of(part.colors[t[0]]), number_of(part.colors[t[1]]), number_of(part.colors[t[2]])};
    std::rotate(n.begin(), std::min_element(n.begin(), n.end()), n.end());
    triangles.push_back(n);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(Quantize, OppositeAndEqualTrianglesStay) {
  const Tetrahedron root = first_root();
  const auto points = spread_points(root);
  const quantization::QuantizeOptions options{8, false, true};
  const auto stored = [&](const std::vector<Triangle>& triangles) {
    return numbered_triangles(quantize(numbered_mesh(points, triangles), root, 0, options).tetrahedron);
  };
  // They are surface, wider than a unit: see lost_test.cpp for those that are not.
  EXPECT_EQ(stored({{0, 1, 2}, {1, 2, 3}, {1, 0, 2}}),
            (std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}, {1, 2, 3}}));
  EXPECT_EQ(stored({{0, 1, 2}, {1, 2, 0}}), (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}}));
  EXPECT_EQ(stored({{0, 1, 2}, {2, 1, 0}}), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}}));
}

TEST(Quantize, DropsWhatBecomesDegenerateAndMergesItsVertices) {
  const Tetrahedron root = first_root();
  const auto points = spread_points(root);
  // 5 falls onto 0 in the first triangle, so the second is that of 0 too; the third has what is left of the
  // first for an edge.
  const mesh::Mesh mesh = numbered_mesh(points, {{0, 5, 1}, {5, 2, 3}, {1, 0, 4}});
  const coded::CodedPart part = quantization::quantize(mesh, root, 3, {8, false, true}).tetrahedron;
  EXPECT_EQ(part.place, 3);
  EXPECT_EQ(numbered_triangles(part), (std::vector<Triangle>{{0, 2, 3}, {0, 4, 1}}));
  EXPECT_EQ(part.positions.size(), 5U);
}

TEST(Quantize, TrianglesUseVerticesInOrderOfFirstUse) {
  constexpr std::uint64_t kSeed = 50;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  Random random(kSeed);
  const Tetrahedron tetrahedron = random_tetrahedron(random, 6);
  mesh::Mesh torus = noisy_torus(random, centroid(tetrahedron), std::ldexp(1.0, 24), 30);
  torus.vertices.push_back(numbered_vertex(centroid(tetrahedron), 900));  // used by nothing
  const coded::CodedPart part = quantization::quantize(torus, tetrahedron, 1, {16, true, true}).tetrahedron;
  std::uint32_t next = 0;
  for (const Triangle& t : part.triangles)
    for (const auto v : t) {
      ASSERT_LE(v, next);
      next += v == next ? 1 : 0;
    }
  EXPECT_EQ(next, 900U);
  EXPECT_EQ(part.positions.size(), 900U);
  EXPECT_EQ(part.normals.size(), 900U);
  std::vector<Triangle> expected = torus.triangles;
  for (Triangle& t : expected) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(numbered_triangles(part), expected);
  const quantization::Barycentric barycentric(tetrahedron);
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const mesh::Vertex& vertex = torus.vertices[number_of(part.colors[i])];
    EXPECT_EQ(part.positions[i], barycentric.weights(vertex.position, 16));
  }
  coded::CodedNode node;
  node.position_bits = 16;
  node.has_normals = node.has_colors = true;
  node.parts = {part};
  const auto decoded = decode_with_weights(encode(node, codec_named("zstd")).bytes, {900, 1800});
  ASSERT_TRUE(decoded) << decoded.defect().message;
  EXPECT_EQ(decoded.value(), node);
}

}  // namespace
}  // namespace colossus::codec
