// Arbitrary bytes as a cube's payload. What decodes keeps what decode_cube() promises, and encodes to the
// same bytes again.
#include <cstdint>
#include <cstdlib>

#include "codec/cube_codec.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

void expect_valid(const codec::CubeMesh& cube) {
  const std::size_t count = cube.positions.size();
  for (const geometry::Point& p : cube.positions)
    for (int axis = 0; axis < 3; ++axis) expect(p[axis] >= -geometry::kRootSide);
  expect(cube.normals.size() == (cube.has_normals ? count : 0));
  expect(cube.colors.size() == (cube.has_colors ? count : 0));
  expect(cube.parents.size() == (cube.has_parents ? count : 0));
  std::uint32_t next = 0;
  for (const mesh::Triangle& t : cube.triangles)
    for (const std::uint32_t v : t) {
      expect(v < count && v <= next);
      next += v == next ? 1 : 0;
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto cube = codec::decode_cube(bytes);
  if (!cube) return 0;
  expect_valid(cube.value());
  expect(codec::encode(cube.value()) == core::Bytes(bytes.begin(), bytes.end()));
  return 0;
}
