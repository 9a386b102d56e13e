// Payloads of every version of every codec, in golden/<codec>_<version>_<scheme>: they decode for ever to
// what they were made of, and the present version still writes its own. With COLOSSUS_WRITE_GOLDEN set to a
// folder, the test writes those of the present versions there; a change of their bytes is a new version, in
// schemas/ too.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "codec/coded/lattice_node.hpp"
#include "codec/coded/weights.hpp"
#include "codec/node_codec.hpp"
#include "core/hash.hpp"

namespace colossus::codec {
namespace {

using mesh::Triangle;

constexpr NodeCounts kMost{1000, 2000};

std::uint8_t noise(std::uint32_t i, std::uint32_t channel) {
  const std::uint32_t x = (i * 4 + channel) * 2654435761U;
  return static_cast<std::uint8_t>(x >> 24);
}

// A grid of quads with a hole, then an edge of three triangles, a triangle on its own, and one that names a
// vertex twice.
constexpr std::uint32_t kColumns = 9;
constexpr std::uint32_t kRows = 7;
constexpr std::uint32_t kGrid = kColumns * kRows;
constexpr std::uint32_t kVertices = kGrid + 4;

std::vector<Triangle> nasty_triangles() {
  std::vector<Triangle> triangles;
  for (std::uint32_t y = 0; y + 1 < kRows; ++y)
    for (std::uint32_t x = 0; x + 1 < kColumns; ++x) {
      if (x == 4 && y == 3) continue;
      const std::uint32_t i = y * kColumns + x;
      triangles.push_back({i, i + 1, i + kColumns});
      triangles.push_back({i + 1, i + kColumns + 1, i + kColumns});
    }
  triangles.push_back({0, 1, kGrid});
  triangles.push_back({kGrid + 1, kGrid + 2, kGrid + 3});
  triangles.push_back({kGrid + 1, kGrid + 1, 5});
  return triangles;
}

coded::CodedNode golden_node() {
  coded::CodedNode node;
  node.position_bits = 12;
  node.has_normals = node.has_colors = true;
  for (const std::uint8_t place : std::array<std::uint8_t, 2>{1, 4}) {
    coded::CodedPart part;
    part.place = place;
    part.frame = place == 1 ? coded::Frame{{{2, 0, 0}, {1, 1, 1}, {1, 1, -1}}}
                            : coded::Frame{{{1, 0, 0}, {1, 1, 0}, {1, 1, 1}}};
    part.triangles = nasty_triangles();
    for (std::uint32_t v = 0; v < kVertices; ++v) {
      const std::uint32_t x = v % kColumns;
      const std::uint32_t y = v / kColumns;
      // The left column lies on a face, one corner on two.
      coded::Weights w{x * 150, 200 + y * 170 + noise(v, 9) % 16U, 300U + noise(v, 10) % 8U, 0};
      if (v == 0) w[1] = 0;
      w[3] = 4096 - w[0] - w[1] - w[2];
      part.positions.push_back(w);
      part.normals.push_back({static_cast<std::uint8_t>(120 + noise(v, 0) % 12), noise(v, 1)});
      part.colors.push_back({noise(v, 2), static_cast<std::uint8_t>(100 + x), noise(v, 3), 255});
    }
    node.parts.push_back(std::move(part));
  }
  return node;
}

coded::CodedNode golden_cube() {
  coded::CodedNode node = coded::lattice_node();
  node.has_normals = node.has_colors = node.has_parents = true;
  coded::CodedPart& cube = node.parts[0];
  cube.triangles = nasty_triangles();
  std::vector<geometry::Point> positions;
  // The last three are used by no triangle.
  for (std::uint32_t v = 0; v < kVertices + 3; ++v) {
    const auto x = static_cast<std::int32_t>(v % kColumns);
    const auto y = static_cast<std::int32_t>(v / kColumns);
    positions.push_back({(1 << 20) + 1000 * x, -5000 + 900 * y + noise(v, 4), noise(v, 5)});
    cube.normals.push_back({noise(v, 6), 255});
    cube.colors.push_back({static_cast<std::uint8_t>(3 * x), noise(v, 7), 9, noise(v, 8)});
    cube.parents.push_back(v / 3 + (v % 11 == 0 ? 100 : 0));
  }
  set_lattice_positions(node, positions);
  return node;
}

coded::CodedNode in_order(coded::CodedNode node, const Codec& codec) {
  for (coded::CodedPart& part : node.parts) put_in_order(part, codec);
  return node;
}

core::Bytes read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(content));
  return {bytes.begin(), bytes.end()};
}

// The golden bytes; those of the present version after writing them, if it is to be written.
core::Bytes golden_bytes(const Codec& codec, const char* scheme, const core::Bytes& now) {
  const std::string name = fmt::format("{}_{}_{}", codec.name, int{codec.version}, scheme);
  if (const char* folder = std::getenv("COLOSSUS_WRITE_GOLDEN"); folder != nullptr && !now.empty()) {
    std::ofstream file(std::filesystem::path(folder) / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(now.data()), static_cast<std::streamsize>(now.size()));
    return now;
  }
  return read_file(std::filesystem::path(GOLDEN_FOLDER) / name);
}

template <typename Decode>
void expect_every_damage_is_refused(const core::Bytes& golden, Decode decode) {
  for (std::size_t size = 0; size < golden.size(); ++size)
    EXPECT_FALSE(decode(std::span(golden).first(size))) << "cut to " << size;
  core::Bytes bytes = golden;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= std::byte{1} << bit % 8;
    EXPECT_FALSE(decode(std::span<const std::byte>(bytes))) << "bit " << bit;
    bytes[bit / 8] ^= std::byte{1} << bit % 8;
  }
}

TEST(Golden, NodesOfEveryVersionDecodeToWhatTheyWereMadeOf) {
  for (const Codec& codec : codecs()) {
    SCOPED_TRACE(codec.name);
    const coded::CodedNode node = in_order(golden_node(), codec);
    const core::Bytes now = encode(node, codec).bytes;
    const core::Bytes golden = golden_bytes(codec, "diamonds", now);
    ASSERT_FALSE(golden.empty());
    EXPECT_EQ(now, golden);
    const auto decoded = decode_with_weights(golden, kMost);
    ASSERT_TRUE(decoded) << decoded.defect().message;
    EXPECT_TRUE(decoded.value() == node);
    expect_every_damage_is_refused(
        golden, [](std::span<const std::byte> b) { return decode_with_weights(b, kMost).ok(); });
  }
}

TEST(Golden, CubesOfEveryVersionDecodeToWhatTheyWereMadeOf) {
  for (const Codec& codec : codecs()) {
    SCOPED_TRACE(codec.name);
    const coded::CodedNode cube = in_order(golden_cube(), codec);
    const core::Bytes now = encode(cube, codec).bytes;
    const core::Bytes golden = golden_bytes(codec, "blocks", now);
    ASSERT_FALSE(golden.empty());
    EXPECT_EQ(now, golden);
    const auto decoded = decode_on_lattice(golden, kMost);
    ASSERT_TRUE(decoded) << decoded.defect().message;
    EXPECT_TRUE(decoded.value() == cube);
    expect_every_damage_is_refused(
        golden, [](std::span<const std::byte> b) { return decode_on_lattice(b, kMost).ok(); });
  }
}

// Orders of triangles have not changed since.
TEST(Golden, OldVersionsDecodeToWhatTheyWereMadeOf) {
  ASSERT_FALSE(old_versions().empty());
  for (const Codec& codec : old_versions()) {
    SCOPED_TRACE(testing::Message() << codec.name << " version " << int{codec.version});
    const Codec& present = codec_named(codec.name);
    const core::Bytes golden_diamonds = golden_bytes(codec, "diamonds", {});
    const auto node = decode_with_weights(golden_diamonds, kMost);
    ASSERT_TRUE(node) << node.defect().message;
    EXPECT_TRUE(node.value() == in_order(golden_node(), present));
    const core::Bytes golden_blocks = golden_bytes(codec, "blocks", {});
    const auto cube = decode_on_lattice(golden_blocks, kMost);
    ASSERT_TRUE(cube) << cube.defect().message;
    EXPECT_TRUE(cube.value() == in_order(golden_cube(), present));
    expect_every_damage_is_refused(
        golden_diamonds, [](std::span<const std::byte> b) { return decode_with_weights(b, kMost).ok(); });
  }
}

}  // namespace
}  // namespace colossus::codec
