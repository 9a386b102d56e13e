// What is asked of a statue of any scheme, and what comes of it.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "reader/access/cut_mesh.hpp"
#include "reader/access/eye.hpp"

namespace colossus::reader::access {

// Every node of this level, or the leaf above it.
struct AtLevel {
  std::uint32_t level = 0;
};
// The coarsest cut with at most this error, in world units.
struct WithError {
  double error = 0.0;
};
// The finest cut of a fixed order with at most so many triangles.
struct WithTriangles {
  std::uint64_t triangles = 0;
};
using CutRequest = std::variant<AtLevel, WithError, WithTriangles, Eye>;

struct Extraction {
  CutMesh mesh;
  std::vector<std::uint64_t> parts_by_level;  // how many of Statue::name_of_parts() are drawn
  std::string warning;                        // why the cut is not quite what was asked for; else empty
};

// By the functions of the scheme: cut_at_level(), cut_with_error(), cut_with_triangles(), cut_at_eye(),
// assemble() and parts_by_level(), found beside the statue.
template <typename Statue>
Extraction extract_cut(const Statue& statue, const CutRequest& request) {
  struct Cutter {
    const Statue& statue;
    auto operator()(const AtLevel& r) const { return cut_at_level(statue, r.level); }
    auto operator()(const WithError& r) const { return cut_with_error(statue, r.error); }
    auto operator()(const WithTriangles& r) const { return cut_with_triangles(statue, r.triangles); }
    auto operator()(const Eye& eye) const { return cut_at_eye(statue, eye); }
  };
  const auto cut = std::visit(Cutter{statue}, request);
  return {assemble(statue, cut), parts_by_level(statue, cut), cut.warning};
}

}  // namespace colossus::reader::access
