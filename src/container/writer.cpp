#include "container/writer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <tuple>
#include <utility>

#include "container/chunk.hpp"
#include "container/descriptions.hpp"
#include "container/hdf5/file_driver.hpp"
#include "container/hdf5/support.hpp"
#include "container/metadata_io.hpp"
#include "container/node_table.hpp"
#include "container/reader.hpp"
#include "container/table.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using core::Status;
using hdf5::Blame;
using hdf5::Handle;

// All links of the root group stay in its header: simpler to read than a heap and a B-tree.
constexpr unsigned kMostTables = 64;

// File properties that keep the bytes a function of the calls: one file format and no object times.
Handle create_file(const Blame& blame, hdf5::Device& device, Handle& driver) {
  const std::string what = "cannot create the HDF5 file";
  const Handle access = blame.own(H5Pcreate(H5P_FILE_ACCESS), &H5Pclose, what);
  blame.check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110), what);
  blame.check(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), what);
  driver = use_device(blame, access.get(), device);
  const Handle creation = blame.own(H5Pcreate(H5P_FILE_CREATE), &H5Pclose, what);
  blame.check(H5Pset_obj_track_times(creation.get(), false), what);
  keep_attributes_in_header(blame, creation.get());
  blame.check(H5Pset_link_phase_change(creation.get(), kMostTables, kMostTables - 1), what);
  return blame.own(H5Fcreate(blame.file.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), &H5Fclose,
                   what);
}

Handle create_chunk_group(const Blame& blame, hid_t file) {
  const std::string what = "cannot create group /chunks";
  const Handle properties = blame.own(H5Pcreate(H5P_GROUP_CREATE), &H5Pclose, what);
  blame.check(H5Pset_obj_track_times(properties.get(), false), what);
  // All links in the group's header: simpler to read than a heap and a B-tree, and there are few.
  blame.check(H5Pset_link_phase_change(properties.get(), kCapacityClassCount, kCapacityClassCount - 1), what);
  Handle group =
      blame.own(H5Gcreate2(file, "chunks", H5P_DEFAULT, properties.get(), H5P_DEFAULT), &H5Gclose, what);
  describe(blame, group.get(), "chunks");
  return group;
}

// The extent is fixed, so HDF5 indexes the chunks by a fixed array.
Handle create_chunk_class(const Blame& blame, const Handle& group, std::uint32_t capacity_class,
                          std::uint64_t chunk_count) {
  const std::string name = fmt::format("class_{}", capacity_class);
  const std::string what = "cannot create dataset /chunks/" + name;
  const hsize_t capacity = class_capacity(capacity_class);
  const hsize_t extent = capacity * chunk_count;
  const Handle space = blame.own(H5Screate_simple(1, &extent, nullptr), &H5Sclose, what);
  const Handle properties = blame.own(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose, what);
  blame.check(H5Pset_chunk(properties.get(), 1, &capacity), what);
  blame.check(H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER), what);
  blame.check(H5Pset_obj_track_times(properties.get(), false), what);
  const unsigned level = 3;
  blame.check(H5Pset_filter(properties.get(), hdf5::kZstdFilter, H5Z_FLAG_MANDATORY, 1, &level), what);
  Handle dataset = blame.own(H5Dcreate2(group.get(), name.c_str(), H5T_STD_U8LE, space.get(), H5P_DEFAULT,
                                        properties.get(), H5P_DEFAULT),
                             &H5Dclose, what);
  describe_chunks(blame, dataset.get(), capacity_class);
  return dataset;
}

void sync_folder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) core::fail(Status::kIo, "{}: cannot open: {}", folder.string(), std::strerror(errno));
  // Some network file systems cannot flush a folder and say so; there is nothing more to be done on them.
  const int error = ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP ? 0 : errno;
  ::close(descriptor);
  if (error != 0)
    core::fail(core::write_status(error), "{}: is complete, but its folder cannot be flushed to disk: {}",
               file.string(), std::strerror(error));
}

}  // namespace

struct ContainerWriter::State {
  std::filesystem::path path;
  std::filesystem::path part;
  std::pair<dev_t, ino_t> inode;  // of the part
  bool is_committed = false;
  Blame blame;
  hdf5::Device device;
  Handle driver;
  Handle file;
  Handle group;
  Handle nodes;
  std::array<Handle, kCapacityClassCount> classes;
  std::vector<NodeRow> rows;
  bool has_nodes = false;
  std::size_t next_row = 0;
  core::Bytes read_back;

  void verify_chunk(const NodeRow& row, std::span<const std::byte> frame) {
    read_back.resize(frame.size());
    const std::size_t got = device.file.read_some_at(row.offset, read_back);
    if (got != frame.size() || !std::equal(frame.begin(), frame.end(), read_back.begin()))
      core::fail(Status::kIo, "{}: node {}: the {} bytes at {} are not those that were written", blame.file,
                 next_row, frame.size(), row.offset);
  }

  // A new file, even if there is one of this name that another process still writes to.
  void create_part() {
    ::unlink(part.c_str());
    device.file = core::File::create(part, true);
    struct stat info {};
    if (::fstat(device.file.descriptor(), &info) != 0)
      core::fail(Status::kIo, "{}: cannot stat: {}", part.string(), std::strerror(errno));
    inode = {info.st_dev, info.st_ino};
  }
  // Whether the name still leads to our file: another process may have begun another one since.
  bool has_part() const {
    struct stat info {};
    return ::stat(part.c_str(), &info) == 0 && inode == std::pair(info.st_dev, info.st_ino);
  }
  void check_part() const {
    if (!has_part())
      core::fail(Status::kIo,
                 "{}: was removed or replaced while it was written: does another build write it?",
                 part.string());
  }
  void remove_part() const {
    if (has_part()) ::unlink(part.c_str());
  }

  // What is found wrong in it is not the input's fault.
  void verify_rows() const {
    bool is_same = false;
    try {
      is_same = ContainerReader(part).rows() == rows;
    } catch (const core::Error& error) {
      core::fail(Status::kIo, "cannot read back {}", error.what());
    }
    if (!is_same) core::fail(Status::kIo, "{}: reads back differently: check the disk", blame.file);
  }

  // Also what a destructor does, therefore complete whatever fails; the first failure is reported.
  void close_file() {
    herr_t result = 0;
    for (Handle& dataset : classes) result = std::min(result, dataset.close());
    for (Handle* handle : {&nodes, &group, &file, &driver}) result = std::min(result, handle->close());
    device.check();
    blame.check(result, "cannot close");
  }
};

ContainerWriter::ContainerWriter(std::filesystem::path path) : state_(std::make_unique<State>()) {
  State& s = *state_;
  const hdf5::QuietErrors quiet;
  s.path = std::move(path);
  s.part = s.path;
  s.part += ".part";
  if (std::error_code ignored; std::filesystem::is_directory(s.path, ignored))
    core::fail(Status::kCannotCreate, "{}: cannot create: it is a folder", s.path.string());
  s.create_part();
  s.blame = {s.part.string(), Status::kIo};
  try {
    register_zstd_filter(s.blame);
    s.file = create_file(s.blame, s.device, s.driver);
    s.device.check();
  } catch (...) {
    s.remove_part();
    throw;
  }
}

ContainerWriter::~ContainerWriter() {
  State& s = *state_;
  if (s.is_committed) return;
  const hdf5::QuietErrors quiet;
  try {
    s.close_file();
  } catch (const core::Error&) {
    // The file is removed: what could not be written does not matter.
  }
  s.remove_part();
}

void ContainerWriter::add_nodes(const Metadata& metadata, std::vector<NodeRow> rows) {
  State& s = *state_;
  const hdf5::QuietErrors quiet;
  COLOSSUS_CHECK(!s.has_nodes, "add_nodes is called once");
  s.has_nodes = true;
  s.rows = std::move(rows);
  std::array<std::uint32_t, kCapacityClassCount> next_chunk{};
  for (std::size_t i = 0; i < s.rows.size(); ++i) {
    NodeRow& row = s.rows[i];
    COLOSSUS_CHECK(row.capacity_class == class_for(row.payload_bytes) && row.stored_bytes > 0, "row {}", i);
    COLOSSUS_CHECK(
        i == 0 || std::tie(s.rows[i - 1].level, s.rows[i - 1].center) < std::tie(row.level, row.center),
        "row {} is out of order", i);
    row.chunk_index = next_chunk[row.capacity_class]++;
    row.offset = 0;
  }
  s.nodes = create_table(s.blame, s.file.get(), "nodes", node_fields(), s.rows.size());
  describe_table(s.blame, s.nodes.get(), "nodes", node_fields());
  write_metadata(s.blame, s.file.get(), metadata);
  s.group = create_chunk_group(s.blame, s.file.get());
  for (std::uint32_t k = 0; k < kCapacityClassCount; ++k)
    if (next_chunk[k] > 0) s.classes[k] = create_chunk_class(s.blame, s.group, k, next_chunk[k]);
  s.device.check();
}

void ContainerWriter::append_chunk(std::span<const std::byte> frame) {
  State& s = *state_;
  const hdf5::QuietErrors quiet;
  COLOSSUS_CHECK(s.next_row < s.rows.size(), "{} rows, and one chunk more", s.rows.size());
  NodeRow& row = s.rows[s.next_row];
  if (frame.size() != row.stored_bytes || core::hash64(frame) != row.checksum)
    core::fail(Status::kIo, "{}: node {}: expected {} bytes with checksum {:016x}, found {} with {:016x}",
               s.blame.file, s.next_row, row.stored_bytes, row.checksum, frame.size(), core::hash64(frame));
  const hsize_t start = class_capacity(row.capacity_class) * row.chunk_index;
  s.device.raw_write_bytes = 0;
  s.blame.check(
      H5Dwrite_chunk(s.classes[row.capacity_class].get(), H5P_DEFAULT, 0, &start, frame.size(), frame.data()),
      fmt::format("cannot write node {}", s.next_row));
  s.device.check();
  COLOSSUS_CHECK(s.device.raw_write_bytes == frame.size(), "node {}: HDF5 wrote {} of {} bytes", s.next_row,
                 s.device.raw_write_bytes, frame.size());
  row.offset = s.device.raw_write_offset;
  s.verify_chunk(row, frame);
  ++s.next_row;
}

void ContainerWriter::commit() {
  State& s = *state_;
  const hdf5::QuietErrors quiet;
  COLOSSUS_CHECK(s.has_nodes && s.next_row == s.rows.size(), "{} of {} chunks appended", s.next_row,
                 s.rows.size());
  write_table(s.blame, s.nodes, encode_rows(s.rows));
  s.close_file();
  s.check_part();
  s.verify_rows();
  s.device.file.sync();
  s.check_part();
  s.device.file.close();
  if (::rename(s.part.c_str(), s.path.c_str()) != 0)
    core::fail(core::create_status(errno), "{}: cannot rename to {}: {}", s.part.string(), s.path.string(),
               std::strerror(errno));
  s.is_committed = true;
  sync_folder(s.path);
}

const std::vector<NodeRow>& ContainerWriter::rows() const { return state_->rows; }

}  // namespace colossus::container
