#include "codec/quantization/polylines.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codec/clipped_cells.hpp"

namespace colossus::codec::quantization {
namespace {

using geometry::Point;
using geometry::Vec3;
using mesh::Mesh;
using mesh::Triangle;

constexpr int kBits = 8;
constexpr int kLevel = 6;

double pick(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// A length from 2^-10 to 2^3 units, all magnitudes alike.
double pick_thickness(Random& random, double unit) { return unit * std::exp2(pick(random, -10.0, 3.0)); }

Vec3 pick_direction(Random& random) {
  for (;;) {
    const Vec3 v{pick(random, -1, 1), pick(random, -1, 1), pick(random, -1, 1)};
    const double length = geometry::length(v);
    if (length > 0.1 && length < 1.0) return (1.0 / length) * v;
  }
}

// Two more, orthogonal to it.
std::array<Vec3, 3> frame_of(Random& random, const Vec3& direction) {
  Vec3 second = geometry::cross(direction, pick_direction(random));
  second = (1.0 / geometry::length(second)) * second;
  return {direction, second, geometry::cross(direction, second)};
}

// A face of a tetrahedron well inside the root cube.
struct Place {
  std::array<Vec3, 3> corners;
  Vec3 normal;
  double unit;  // of weight, along the first edge
};

Place pick_place(Random& random) {
  const hierarchy::Diamond root = hierarchy::Diamond::at(hierarchy::root_center());
  for (;;) {
    hierarchy::Tetrahedron t = root.tetrahedra[random() % 6];
    for (int level = 0; level < kLevel; ++level) t = t.child(static_cast<int>(random() % 2));
    const std::size_t opposite = random() % 4;
    Place place{};
    bool is_inner = true;
    for (std::size_t i = 0, k = 0; i < 4; ++i) {
      if (i == opposite) continue;
      place.corners[k++] = geometry::to_vec3(t.corners[i]);
      for (int axis = 0; axis < 3; ++axis)
        is_inner &= t.corners[i][axis] > 0 && t.corners[i][axis] < geometry::kRootSide;
    }
    if (!is_inner) continue;
    const Vec3 side = place.corners[1] - place.corners[0];
    place.normal = geometry::cross(side, place.corners[2] - place.corners[0]);
    place.normal = (1.0 / geometry::length(place.normal)) * place.normal;
    place.unit = std::ldexp(geometry::length(side), -kBits);
    return place;
  }
}

Vec3 pick_point_of_face(Random& random, const Place& place) {
  const double a = pick(random, 0.1, 0.8);
  const double b = pick(random, 0.05, 0.9 - a);
  return a * place.corners[0] + b * place.corners[1] + (1.0 - a - b) * place.corners[2];
}

Vec3 pick_point_of_edge(Random& random, const Place& place) {
  const std::size_t k = random() % 3;
  const double a = pick(random, 0.1, 0.9);
  return a * place.corners[k] + (1.0 - a) * place.corners[(k + 1) % 3];
}

// Thinner than a unit of weight or a little thicker, across the face or one of its edges.
Mesh sheet(Random& random, const Place& place, double least_size, std::uint32_t least_segments) {
  const double unit = place.unit;
  const auto [u, v, w] = frame_of(random, pick_direction(random));
  const Vec3 center =
      random() % 2 == 0 ? pick_point_of_face(random, place) : pick_point_of_edge(random, place);
  const std::array<Vec3, 3> half_axes{pick(random, least_size, 30) * unit * u,
                                      pick(random, least_size, 30) * unit * v,
                                      pick_thickness(random, unit) * w};
  const auto segments = least_segments + static_cast<std::uint32_t>(random() % least_segments);
  return ellipsoid(random, center, half_axes, segments, 0.2);
}

Mesh coarse_sheet(Random& random, const Place& place) { return sheet(random, place, 8, 4); }

// Many vertices on few places.
Mesh fine_sheet(Random& random, const Place& place) { return sheet(random, place, 4, 8); }

// Its end lies within a few units of the face.
Mesh spike_to_face(Random& random, const Place& place) {
  const double unit = place.unit;
  const auto [u, v, w] = frame_of(random, random() % 2 == 0 ? place.normal : pick_direction(random));
  const double length = pick(random, 4, 40) * unit;
  const Vec3 end = pick_point_of_face(random, place) + pick(random, -3, 3) * unit * place.normal;
  const std::array<Vec3, 3> half_axes{length * u, pick_thickness(random, unit) * v,
                                      pick_thickness(random, unit) * w};
  return ellipsoid(random, end - length * u, half_axes, 3 + static_cast<std::uint32_t>(random() % 6), 0.1);
}

// Across an edge of the face, or ending there.
Mesh spike_to_edge(Random& random, const Place& place) {
  const double unit = place.unit;
  const auto [u, v, w] = frame_of(random, pick_direction(random));
  const double length = pick(random, 4, 40) * unit;
  const Vec3 center = pick_point_of_edge(random, place) +
                      pick(random, -1, 1) * unit * pick_direction(random) - pick(random, 0, 1) * length * u;
  const std::array<Vec3, 3> half_axes{length * u, pick_thickness(random, unit) * v,
                                      pick_thickness(random, unit) * w};
  return ellipsoid(random, center, half_axes, 3 + static_cast<std::uint32_t>(random() % 6), 0.1);
}

using MakePart = Mesh (*)(Random&, const Place&);

// One to three parts at the same face, each cell's mesh in an order of its own.
std::vector<Cell> random_cells(std::uint64_t seed, MakePart make_part) {
  Random random(seed);
  const Place place = pick_place(random);
  Mesh mesh;
  for (std::uint64_t i = 0; i <= seed % 3; ++i) append(mesh, make_part(random, place));
  std::vector<Cell> cells = clip_to_cells(mesh, kLevel);
  for (Cell& cell : cells) cell.mesh = shuffled(cell.mesh, random);
  return cells;
}

void expect_conforming(MakePart make_part, std::uint64_t first_seed) {
  std::size_t input_pinches = 0;
  std::size_t face_edges = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::vector<SeenCell> before;
    std::vector<SeenCell> after;
    for (const Cell& cell : random_cells(seed, make_part)) {
      before.push_back(unquantised(cell));
      after.push_back(quantised(cell, kBits));
    }
    EXPECT_EQ(compare_faces(before).differing, 0U);
    const FaceEdges faces = compare_faces(after);
    EXPECT_EQ(faces.differing, 0U);
    face_edges += faces.count;
    const EdgeCounts edges = count_edges(after);
    EXPECT_EQ(edges.degenerate, 0U);
    EXPECT_EQ(edges.unbalanced, 0U);
    // Rounded to the lattice, the thinnest may fall together even without quantisation.
    if (count_edges(before).nonmanifold > 0)
      ++input_pinches;
    else
      EXPECT_EQ(edges.nonmanifold, 0U);
  }
  EXPECT_LT(input_pinches, 5U);
  EXPECT_GT(face_edges, 3000U);
}

TEST(QuantizedFaces, AgreeAndStayManifoldWhereThinSheetsCross) { expect_conforming(coarse_sheet, 1000); }

TEST(QuantizedFaces, AgreeAndStayManifoldWhereFineSheetsCross) { expect_conforming(fine_sheet, 2000); }

TEST(QuantizedFaces, AgreeAndStayManifoldWhereSpikesEnd) { expect_conforming(spike_to_face, 3000); }

TEST(QuantizedFaces, AgreeAndStayManifoldWhereSpikesCrossTheirEdges) {
  expect_conforming(spike_to_edge, 4000);
}

// A mesh and its weights while a case is made up.
struct Surface {
  Mesh mesh;
  std::vector<coded::Weights> weights;

  // Vertices are in the order of their positions as they are of their numbers.
  std::uint32_t add(const coded::Weights& w) {
    mesh.vertices.push_back({});
    mesh.vertices.back().position.x = static_cast<std::int32_t>(weights.size());
    weights.push_back(w);
    return static_cast<std::uint32_t>(weights.size() - 1);
  }
  // A triangle from the edge to a vertex of its own inside.
  void hang(std::uint32_t a, std::uint32_t b) {
    const auto inner = static_cast<std::uint32_t>(weights.size());
    mesh.triangles.push_back({a, b, add({100, 52, 52, 52})});
    mesh.vertices[inner].position.y = 1;
  }
  // A polyline through these places, a triangle at each edge; returns its vertices.
  std::vector<std::uint32_t> hang_all(const std::vector<coded::Weights>& places) {
    std::vector<std::uint32_t> line;
    for (const coded::Weights& place : places) line.push_back(add(place));
    for (std::size_t i = 1; i < line.size(); ++i) hang(line[i - 1], line[i]);
    return line;
  }
  void settle() { settle_polylines(mesh, weights); }
};

// Triangles by the places of their corners.
std::vector<std::array<coded::Weights, 3>> placed_triangles(const Mesh& mesh,
                                                            const std::vector<coded::Weights>& weights) {
  std::vector<std::array<coded::Weights, 3>> placed;
  for (const Triangle& t : mesh.triangles) {
    placed.push_back({weights[t[0]], weights[t[1]], weights[t[2]]});
    auto& corners = placed.back();
    // Of equal corners it matters which comes first.
    std::array<std::array<coded::Weights, 3>, 3> turned{corners, corners, corners};
    std::rotate(turned[1].begin(), turned[1].begin() + 1, turned[1].end());
    std::rotate(turned[2].begin(), turned[2].begin() + 2, turned[2].end());
    corners = *std::min_element(turned.begin(), turned.end());
  }
  std::sort(placed.begin(), placed.end());
  return placed;
}

TEST(Polylines, DoNotDependOnTheOrderOfVerticesAndTriangles) {
  std::size_t moved = 0;
  for (std::uint64_t seed = 5000; seed < 5100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    for (const Cell& cell : random_cells(seed, seed % 2 == 0 ? fine_sheet : spike_to_edge)) {
      const Barycentric barycentric(cell.tetrahedron);
      const auto settled = [&](Mesh mesh) {
        std::vector<coded::Weights> weights;
        for (const mesh::Vertex& vertex : mesh.vertices)
          weights.push_back(barycentric.weights(vertex.position, kBits));
        const auto before = weights;
        settle_polylines(mesh, weights);
        moved += weights != before ? 1 : 0;
        return placed_triangles(mesh, weights);
      };
      EXPECT_EQ(settled(cell.mesh), settled(shuffled(cell.mesh, random)));
    }
  }
  EXPECT_GT(moved, 100U);
}

TEST(Polylines, TurnsOfEightUnitsJoinTheirNeighbours) {
  const coded::Weights end{0, 100, 100, 56};
  Surface surface;
  surface.hang_all({end, {0, 108, 92, 56}, end});
  Surface across;
  across.hang_all({{100, 100, 0, 56}, {108, 96, 0, 52}, {100, 100, 0, 56}});
  surface.settle();
  across.settle();
  for (const std::uint32_t v : {0U, 1U, 2U}) {
    EXPECT_EQ(surface.weights[v], end);
    EXPECT_EQ(across.weights[v], (coded::Weights{100, 100, 0, 56}));
  }
  EXPECT_EQ(surface.mesh.triangles.size(), 2U);
}

TEST(Polylines, TurnsOfNineUnitsStayAndTheirEdgesPart) {
  const coded::Weights end{0, 100, 100, 56};
  for (const coded::Weights& turn :
       {coded::Weights{0, 109, 91, 56}, coded::Weights{0, 91, 109, 56}, coded::Weights{0, 103, 88, 65}}) {
    Surface surface;
    surface.hang_all({end, turn, end});
    surface.settle();
    EXPECT_EQ(surface.weights[0], end);
    EXPECT_EQ(surface.weights[1], turn);
    EXPECT_EQ(surface.weights[2], (coded::Weights{0, 101, 99, 56}));
    EXPECT_EQ(surface.mesh.triangles.size(), 2U);
  }
}

TEST(Polylines, TurnsThatFlatteningMakesAreFlattened) {
  const coded::Weights p{0, 100, 100, 56};
  const coded::Weights q{0, 102, 98, 56};
  Surface surface;
  surface.hang_all({p, q, p, q, p, q, p});
  surface.settle();
  for (std::uint32_t v = 0; v < 7; ++v) EXPECT_EQ(surface.weights[v], p) << v;
}

TEST(Polylines, TurnsOnAnEdgeOfTheFaceStay) {
  const coded::Weights end{0, 2, 154, 100};
  const coded::Weights turn{0, 0, 156, 100};
  for (const std::size_t turn_index : {0U, 1U, 2U}) {
    Surface surface;
    for (std::size_t v = 0; v < 3; ++v) surface.add(v == turn_index ? turn : end);
    const auto first = static_cast<std::uint32_t>(turn_index == 0 ? 1 : 0);
    const auto last = static_cast<std::uint32_t>(turn_index == 2 ? 1 : 2);
    surface.hang(first, static_cast<std::uint32_t>(turn_index));
    surface.hang(static_cast<std::uint32_t>(turn_index), last);
    surface.settle();
    EXPECT_EQ(surface.weights[turn_index], turn);
    EXPECT_EQ(surface.weights[first], end);
    EXPECT_EQ(surface.weights[last], (coded::Weights{0, 3, 153, 100}));
  }
}

TEST(Polylines, TurnsWhereThreeMeetStay) {
  const coded::Weights end{0, 100, 100, 56};
  const coded::Weights fork{0, 103, 97, 56};
  Surface surface;
  surface.hang_all({end, fork, end});
  surface.hang(1, surface.add({0, 50, 150, 56}));
  surface.settle();
  EXPECT_EQ(surface.weights[1], fork);
  EXPECT_NE(surface.weights[0], surface.weights[2]);
}

// On an edge of the face opposite corner 0, on another one, and between.
constexpr coded::Weights kOnEdge{0, 0, 156, 100};
constexpr coded::Weights kOnOtherEdge{0, 156, 0, 100};
constexpr coded::Weights kBetween{0, 60, 96, 100};

TEST(Polylines, OfTwoCoincidingEdgesTheLaterInnerEndStepsAside) {
  for (const bool is_swapped : {false, true}) {
    Surface surface;
    surface.hang_all({kOnEdge, kBetween});
    surface.hang_all({kBetween, kOnEdge});
    const std::uint32_t first = 1;
    const std::uint32_t second = 3;
    ASSERT_EQ(surface.weights[second], kBetween);
    // Positions decide, not numbers.
    if (is_swapped) std::swap(surface.mesh.vertices[first].position, surface.mesh.vertices[second].position);
    const auto before = surface.weights;
    surface.settle();
    auto expected = before;
    expected[is_swapped ? first : second] = {0, 61, 95, 100};
    EXPECT_EQ(surface.weights, expected);
    EXPECT_EQ(surface.mesh.triangles.size(), 2U);
  }
}

TEST(Polylines, CoincidingEdgesTakeDifferentFreePlaces) {
  Surface surface;
  for (int i = 0; i < 3; ++i) surface.hang_all({kOnEdge, kBetween});
  // The first place that they could step to is taken.
  surface.hang_all({{0, 61, 95, 100}, {0, 90, 66, 100}});
  surface.settle();
  EXPECT_EQ(surface.weights[1], kBetween);
  EXPECT_EQ(surface.weights[4], (coded::Weights{0, 61, 96, 99}));
  EXPECT_EQ(surface.weights[7], (coded::Weights{0, 59, 97, 100}));
  EXPECT_EQ(surface.mesh.triangles.size(), 4U);
}

// The smallest corner of each first.
std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(Polylines, OfTwoEdgesWhoseEndsMayNotMoveTheLaterIsSplit) {
  for (const bool is_taken : {false, true}) {
    Surface surface;
    surface.hang_all({kOnEdge, kOnOtherEdge});
    surface.hang_all({kOnOtherEdge, kOnEdge});
    if (is_taken) surface.hang_all({{0, 78, 78, 100}, {0, 20, 136, 100}});
    const auto vertex_count = static_cast<std::uint32_t>(surface.weights.size());
    auto expected = surface.mesh.triangles;
    ASSERT_EQ(expected[1], (Triangle{3, 4, 5}));
    expected[1] = {3, vertex_count, 5};
    expected.push_back({vertex_count, 4, 5});
    auto weights = surface.weights;
    weights.push_back(is_taken ? coded::Weights{0, 79, 77, 100} : coded::Weights{0, 78, 78, 100});
    surface.settle();
    EXPECT_EQ(sorted(surface.mesh.triangles), sorted(expected));
    EXPECT_EQ(surface.weights, weights);
    ASSERT_EQ(surface.mesh.vertices.size(), vertex_count + 1);
  }
}

TEST(Polylines, OfThreeEdgesWhoseEndsMayNotMoveTwoAreSplit) {
  Surface surface;
  for (int i = 0; i < 3; ++i) surface.hang_all({kOnEdge, kOnOtherEdge});
  surface.settle();
  EXPECT_EQ(surface.mesh.triangles.size(), 5U);
  ASSERT_EQ(surface.weights.size(), 11U);
  EXPECT_NE(surface.weights[9], surface.weights[10]);
}

void expect_left_alone(Surface surface) {
  const auto weights = surface.weights;
  const auto triangles = surface.mesh.triangles;
  surface.settle();
  EXPECT_EQ(surface.weights, weights);
  EXPECT_EQ(surface.mesh.triangles, triangles);
}

TEST(Polylines, LeaveWhatDoesNotCoincide) {
  Surface surface;
  surface.hang_all({kOnEdge, kBetween, kOnOtherEdge});
  surface.hang_all({kOnEdge, {0, 60, 95, 101}, kOnOtherEdge});
  expect_left_alone(surface);
}

// Where both sheets go on within the tetrahedron, the edge is none of the face's polyline.
TEST(Polylines, LeaveEdgesThatEndNothing) {
  Surface surface;
  for (int i = 0; i < 2; ++i) {
    const auto line = surface.hang_all({kOnEdge, kOnOtherEdge});
    surface.hang(line[1], line[0]);
  }
  expect_left_alone(surface);
}

TEST(Polylines, LeaveEdgesAlongTheFacesOwn) {
  Surface surface;
  for (int i = 0; i < 2; ++i) surface.hang_all({kOnEdge, {0, 0, 100, 156}});
  expect_left_alone(surface);
}

TEST(Polylines, LeaveEdgesInside) {
  Surface surface;
  for (int i = 0; i < 2; ++i) surface.hang_all({{50, 50, 50, 106}, {60, 50, 50, 96}});
  expect_left_alone(surface);
}

// Both ends on faces, but on no common one.
TEST(Polylines, LeaveEdgesFromFaceToFace) {
  Surface surface;
  for (int i = 0; i < 2; ++i) surface.hang_all({{0, 50, 50, 156}, {60, 0, 50, 146}});
  expect_left_alone(surface);
}

}  // namespace
}  // namespace colossus::codec::quantization
