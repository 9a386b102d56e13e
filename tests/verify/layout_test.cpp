// What verify() says of containers that HDF5 has rearranged so that rows and chunk index agree.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstring>

#include "core/hash.hpp"
#include "support/blocks_fixture.hpp"
#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"

namespace colossus::verify {

using namespace support;
using blocks::verify;
using diamonds::verify;
namespace {

// Copies an object to the end of the file, and puts the copy in its place.
void move_to_end(hid_t file, const std::string& name) {
  ASSERT_GE(H5Ocopy(file, name.c_str(), file, "moved", H5P_DEFAULT, H5P_DEFAULT), 0);
  ASSERT_GE(H5Ldelete(file, name.c_str(), H5P_DEFAULT), 0);
  ASSERT_GE(H5Lmove(file, "moved", file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT), 0);
}

// Tells the rows of one class where their chunks are now, with the table's checksum.
void update_offsets(hid_t file, std::uint32_t capacity_class, const std::vector<container::NodeRow>& rows) {
  const hid_t chunks = H5Dopen2(file, fmt::format("chunks/class_{}", capacity_class).c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(chunks);
  const hid_t table = H5Dopen2(file, "nodes", H5P_DEFAULT);
  const hid_t type = H5Dget_type(table);
  const std::size_t row_bytes = H5Tget_size(type);
  const std::size_t at =
      H5Tget_member_offset(type, static_cast<unsigned>(H5Tget_member_index(type, "offset")));
  std::vector<std::byte> bytes(rows.size() * row_bytes);
  ASSERT_GE(H5Dread(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), 0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].capacity_class != capacity_class) continue;
    hsize_t offset = 0;
    unsigned mask = 0;
    haddr_t address = 0;
    hsize_t size = 0;
    ASSERT_GE(H5Dget_chunk_info(chunks, space, rows[i].chunk_index, &offset, &mask, &address, &size), 0);
    const std::uint64_t value = address;
    std::memcpy(&bytes[i * row_bytes + at], &value, sizeof(value));
  }
  ASSERT_GE(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), 0);
  const hid_t attribute = H5Aopen(table, "xxh3", H5P_DEFAULT);
  const std::uint64_t checksum = core::hash64(bytes);
  ASSERT_GE(H5Awrite(attribute, H5T_NATIVE_UINT64, &checksum), 0);
  H5Aclose(attribute);
  H5Tclose(type);
  H5Dclose(table);
  H5Sclose(space);
  H5Dclose(chunks);
}

template <typename Fixture>
void expect_layout_faults(Fixture& fixture) {
  const auto statue = fixture.open();
  const std::vector<container::NodeRow> rows = statue->rows();
  EXPECT_TRUE(verify(*statue).is_ok());
  using Opened = std::remove_cvref_t<decltype(*statue)>;

  hid_t file = H5Fopen(fixture.path().c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  move_to_end(file, "nodes");
  H5Fclose(file);
  const verify::measure::VerifyReport behind = verify(Opened(fixture.path()));
  EXPECT_EQ(behind.count(verify::measure::FindingKind::kStructure), 1U) << to_text(behind);
  EXPECT_EQ(behind.total(), 1U) << to_text(behind);
  EXPECT_NE(to_text(behind).find("the node table, at byte"), std::string::npos) << to_text(behind);

  fixture.write();
  file = H5Fopen(fixture.path().c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  move_to_end(file, fmt::format("chunks/class_{}", rows.front().capacity_class));
  update_offsets(file, rows.front().capacity_class, rows);
  H5Fclose(file);
  const Opened moved(fixture.path());
  ASSERT_TRUE(moved.container().offsets_hold());
  const verify::measure::VerifyReport disordered = verify(moved);
  EXPECT_GE(disordered.count(verify::measure::FindingKind::kStructure), 1U) << to_text(disordered);
  EXPECT_EQ(disordered.total(), disordered.count(verify::measure::FindingKind::kStructure))
      << to_text(disordered);
  EXPECT_NE(to_text(disordered).find("does not lie behind that of the row before it"), std::string::npos)
      << to_text(disordered);
}

TEST(Layout, FindsATableBehindChunksAndRowsOutOfOrder) {
  DiamondsFixture diamonds(torus(40, 24), 100);
  expect_layout_faults(diamonds);
  BlocksFixture blocks(torus(128, 40));
  expect_layout_faults(blocks);
}

}  // namespace
}  // namespace colossus::verify
