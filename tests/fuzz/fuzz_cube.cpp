// Arbitrary bytes as a cube's payload, under a checksum that is made right first: what decodes keeps what
// decode_cube() promises, and in any codec's order it survives encoding and decoding by that codec.
#include <cstdint>
#include <cstdlib>

#include "codec/coded/renumber.hpp"
#include "codec/cube_codec.hpp"
#include "core/hash.hpp"

namespace {

using namespace colossus;

void expect(bool condition) {
  if (!condition) std::abort();
}

void expect_valid(const codec::coded::CubeMesh& cube) {
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
  const auto input = std::as_bytes(std::span(data, size));
  core::Bytes sealed(input.begin(), input.end());
  core::ByteWriter checksum;
  checksum.put(core::hash64(input));
  sealed.insert(sealed.end(), checksum.bytes().begin(), checksum.bytes().end());
  constexpr codec::NodeCounts kMost{10000, 10000};
  auto decoded = codec::decode_cube(sealed, kMost);
  if (!decoded) return 0;
  codec::coded::CubeMesh& cube = decoded.value();
  expect_valid(cube);
  for (const codec::Codec& codec : codec::codecs()) {
    codec.order(cube.triangles, cube.positions.size());
    const auto before = codec::coded::renumber_by_first_use(cube.triangles, cube.positions.size());
    codec::coded::permute(cube.positions, before);
    codec::coded::permute(cube.normals, before);
    codec::coded::permute(cube.colors, before);
    codec::coded::permute(cube.parents, before);
    const auto again = codec::decode_cube(codec::encode(cube, codec).bytes, kMost);
    expect(again.ok() && again.value() == cube);
  }
  return 0;
}
