// Changes to a container by HDF5's own means, after which every checksum is right again.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

#include "core/bytes.hpp"
#include "core/hash.hpp"

namespace colossus::container::test {

// Bytes of a row and of its fields, as schemas/container.md says; written down here again on purpose.
inline constexpr std::size_t kRowBytes = 122;
inline constexpr std::size_t kLevelAt = 0;
inline constexpr std::size_t kCenterAt = 4;
inline constexpr std::size_t kMaskAt = 16;
inline constexpr std::size_t kErrorAt = 26;
inline constexpr std::size_t kBoundsAt = 34;
inline constexpr std::size_t kClassAt = 82;
inline constexpr std::size_t kIndexAt = 86;
inline constexpr std::size_t kOffsetAt = 90;
inline constexpr std::size_t kStoredAt = 98;
inline constexpr std::size_t kPayloadAt = 106;

// Applies `edit` to an open container.
inline void edit_file(const std::filesystem::path& path, const std::function<void(hid_t)>& edit) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  edit(file);
  ASSERT_GE(H5Fclose(file), 0);
}

// Writes a value into a row of the node table and makes the table's checksum right again.
template <typename T>
void edit_row(const std::filesystem::path& path, std::size_t row, std::size_t at, T value,
              const std::string& table = "nodes") {
  edit_file(path, [&](hid_t file) {
    const hid_t nodes = H5Dopen2(file, table.c_str(), H5P_DEFAULT);
    const hid_t type = H5Dget_type(nodes);
    ASSERT_EQ(H5Tget_size(type), kRowBytes);
    const hid_t space = H5Dget_space(nodes);
    core::Bytes rows(kRowBytes * static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    ASSERT_GE(H5Dread(nodes, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), 0);
    std::memcpy(rows.data() + row * kRowBytes + at, &value, sizeof(value));
    ASSERT_GE(H5Dwrite(nodes, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), 0);
    const std::uint64_t checksum = core::hash64(rows);
    const hid_t attribute = H5Aopen(nodes, "xxh3", H5P_DEFAULT);
    ASSERT_GE(H5Awrite(attribute, H5T_STD_U64LE, &checksum), 0);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(nodes);
  });
}

}  // namespace colossus::container::test
