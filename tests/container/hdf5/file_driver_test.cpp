#include "container/hdf5/file_driver.hpp"

#include <gtest/gtest.h>

#include "container/fixtures.hpp"

namespace colossus::container::hdf5 {
namespace {

// Writes so many bytes as one dataset through the driver. HDF5 must never learn of a failure.
void write_dataset(Device& device, const std::filesystem::path& path, hsize_t bytes) {
  const Blame blame{path.string()};
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Handle driver = use_device(blame, access.get(), device);
  Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose);
  ASSERT_GE(file.get(), 0);
  const Handle space(H5Screate_simple(1, &bytes, nullptr), H5Sclose);
  Handle dataset(
      H5Dcreate2(file.get(), "bytes", H5T_STD_U8LE, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  const std::vector<std::uint8_t> content(bytes, 7);
  EXPECT_GE(H5Dwrite(dataset.get(), H5T_STD_U8LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, content.data()), 0);
  EXPECT_GE(dataset.close(), 0);
  EXPECT_GE(file.close(), 0);
}

TEST(FileDriver, SaysWhereRawDataWent) {
  const test::Folder folder;
  const auto path = folder / "out.h5";
  Device device;
  device.file = core::File::create(path);
  write_dataset(device, path, 5000);
  EXPECT_NO_THROW(device.check());
  EXPECT_EQ(device.raw_write_bytes, 5000U);
  std::vector<std::uint8_t> found(5000);
  const core::File file = core::File::open_for_reading(path);
  file.read_at(device.raw_write_offset, std::as_writable_bytes(std::span(found)));
  EXPECT_EQ(found, std::vector<std::uint8_t>(5000, 7));
}

TEST(FileDriver, KeepsTheFirstFailureAndGoesOnForHdf5) {
  const test::Folder folder;
  const auto path = folder / "full";
  std::filesystem::create_symlink("/dev/full", path);
  Device device;
  device.file = core::File::create(path);
  write_dataset(device, path, 100'000);
  try {
    device.check();
    FAIL() << "a full device went unnoticed";
  } catch (const core::Error& error) {
    EXPECT_NE(std::string(error.what()).find("full"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace colossus::container::hdf5
