// What the tests of synth share: a reader of what it writes, and counts of edges.
#pragma once

#include <cmath>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "core/file.hpp"
#include "support/input_testing.hpp"
#include "synth/surface.hpp"
#include "synth/synth.hpp"

namespace colossus::support {

using namespace synth;

using Point = std::array<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;
using Rgb = std::array<std::uint8_t, 3>;

struct Ply {
  std::vector<std::string> header;
  std::vector<Point> positions, normals;
  std::vector<Rgb> colors;
  std::vector<Triangle> triangles;
};

// Reads what synth writes, and nothing else: every byte must be accounted for.
inline Ply parse(const core::Bytes& bytes) {
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
  const bool doubles = has("property double x"), normals = has("property float nx"),
             colors = has("property uchar red");
  core::ByteReader reader{std::span(bytes).subspan(end)};
  for (std::uint64_t i = 0; i < vertex_count; ++i) {
    Point position{}, normal{};
    for (double& c : position) c = doubles ? reader.get<double>() : static_cast<double>(reader.get<float>());
    ply.positions.push_back(position);
    if (normals)
      for (double& c : normal) c = static_cast<double>(reader.get<float>());
    if (normals) ply.normals.push_back(normal);
    if (colors) ply.colors.push_back(reader.get<Rgb>());
  }
  for (std::uint64_t i = 0; i < face_count; ++i) {
    EXPECT_EQ(reader.get<std::uint8_t>(), 3);
    ply.triangles.push_back(reader.get<Triangle>());
  }
  EXPECT_FALSE(reader.failed());
  EXPECT_EQ(reader.remaining(), 0U);
  return ply;
}

inline Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Point& a) { return std::sqrt(dot(a, a)); }

inline Point area_vector(const Ply& ply, const Triangle& t) {
  const Point cross_product =
      cross(minus(ply.positions[t[1]], ply.positions[t[0]]), minus(ply.positions[t[2]], ply.positions[t[0]]));
  return {cross_product[0] / 2, cross_product[1] / 2, cross_product[2] / 2};
}

inline double volume(const Ply& ply) {
  double sum = 0;
  for (const Triangle& t : ply.triangles)
    sum += dot(ply.positions[t[0]], cross(ply.positions[t[1]], ply.positions[t[2]])) / 6;
  return sum;
}

// Whether alone, in any order, or some of them in order, triangles are what they are among all.
inline void expect_triangles_by_number(const SynthSurface& surface) {
  std::vector<Triangle> all(surface.triangle_count());
  surface.triangles(0, all);
  std::vector<std::uint64_t> numbers(all.size()), every_third;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Triangle one{};
    surface.triangles(i, std::span(&one, 1));
    ASSERT_EQ(one, all[i]) << i;
    numbers[i] = i;
    if (i % 3 == 0) every_third.push_back(i);
  }
  std::ranges::shuffle(numbers, std::minstd_rand(4));
  for (const auto& chosen : {numbers, every_third}) {
    std::vector<Triangle> some(chosen.size());
    surface.triangles_at(chosen, some);
    for (std::size_t i = 0; i < some.size(); ++i) ASSERT_EQ(some[i], all[chosen[i]]) << chosen[i];
  }
}

// Per undirected edge, how many triangles use it each way.
using Uses = std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<int, 2>>;

inline Uses edge_uses(const std::vector<Triangle>& triangles) {
  Uses uses;
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}][a < b ? 0 : 1];
    }
  return uses;
}

inline std::size_t edges_used(const Uses& uses, const std::array<int, 2>& as) {
  return static_cast<std::size_t>(
      std::ranges::count_if(uses, [&](const auto& use) { return use.second == as; }));
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

inline void expect_closed_manifold(const Ply& ply) {
  const Uses uses = edge_uses(ply.triangles);
  EXPECT_EQ(edges_used(uses, {1, 1}), uses.size());
  EXPECT_EQ(ply.positions.size() + ply.triangles.size(), uses.size() + 2) << "Euler characteristic";
  const std::set<Point> distinct(ply.positions.begin(), ply.positions.end());
  EXPECT_EQ(distinct.size(), ply.positions.size()) << "vertices at one position";
}

}  // namespace colossus::support
