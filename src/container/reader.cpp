#include "container/reader.hpp"

#include "container/chunk.hpp"
#include "container/hdf5_support.hpp"
#include "container/metadata_io.hpp"
#include "container/node_table.hpp"
#include "container/table.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using core::Status;
using hdf5::Blame;
using hdf5::Handle;

Handle open_file(const Blame& blame) {
  const std::string what = "cannot open as an HDF5 file";
  const Handle access = blame.own(H5Pcreate(H5P_FILE_ACCESS), &H5Pclose, what);
  blame.check(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), what);
  blame.check(H5Pset_file_locking(access.get(), false, true), what);
  return blame.own(H5Fopen(blame.file.c_str(), H5F_ACC_RDONLY, access.get()), &H5Fclose, what);
}

// The datasets of the chunks are not needed for reading, but a table that does not fit them is a damaged
// file.
void check_chunk_class(const Blame& blame, hid_t group, std::uint32_t capacity_class,
                       std::uint64_t chunk_count) {
  const std::string name = fmt::format("class_{}", capacity_class);
  const std::string place = fmt::format("{}: /chunks/{}", blame.file, name);
  H5L_info_t link{};
  if (H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(blame.status, "{}: expected a dataset of {} chunks, found none", place, chunk_count);
  const Handle dataset =
      blame.own(H5Dopen2(group, name.c_str(), H5P_DEFAULT), &H5Dclose, "cannot open " + place);
  const Handle type = blame.own(H5Dget_type(dataset.get()), &H5Tclose, "cannot read the type of " + place);
  const Handle space =
      blame.own(H5Dget_space(dataset.get()), &H5Sclose, "cannot read the extent of " + place);
  const Handle properties = blame.own(H5Dget_create_plist(dataset.get()), &H5Pclose, "cannot read " + place);
  const hssize_t extent = H5Sget_simple_extent_npoints(space.get());
  const std::uint64_t capacity = class_capacity(capacity_class);
  hsize_t chunk = 0;
  if (H5Tequal(type.get(), H5T_STD_U8LE) <= 0 || H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Pget_layout(properties.get()) != H5D_CHUNKED || H5Pget_chunk(properties.get(), 1, &chunk) != 1 ||
      chunk != capacity)
    core::fail(blame.status, "{}: expected one dimension of bytes in chunks of {}, found another layout",
               place, capacity);
  if (extent < 0 || static_cast<std::uint64_t>(extent) != capacity * chunk_count)
    core::fail(blame.status, "{}: expected {} chunks of {} bytes, found an extent of {}", place, chunk_count,
               capacity, extent);
}

void check_chunks(const Blame& blame, hid_t file, const std::vector<NodeRow>& rows) {
  H5L_info_t link{};
  if (H5Lget_info(file, "chunks", &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(blame.status, "{}: /chunks: expected a group, found none", blame.file);
  const Handle group =
      blame.own(H5Gopen2(file, "chunks", H5P_DEFAULT), &H5Gclose, "cannot open group /chunks");
  const auto counts = chunk_counts(rows);
  for (std::uint32_t k = 0; k < kCapacityClassCount; ++k)
    if (counts[k] > 0) check_chunk_class(blame, group.get(), k, counts[k]);
}

}  // namespace

ContainerReader::ContainerReader(const std::filesystem::path& path) {
  const hdf5::QuietErrors quiet;
  bytes_ = core::File::open_for_reading(path);
  file_bytes_ = bytes_.size();
  const Blame blame{path.string(), Status::kBadData};
  const Handle file = open_file(blame);
  metadata_ = read_metadata(blame, file.get(), bytes_);
  rows_ = decode_rows(read_table(blame, file.get(), bytes_, "nodes"), metadata_, file_bytes_);
  check_chunks(blame, file.get(), rows_);
}

core::Result<core::Bytes> ContainerReader::read_payload(std::size_t row_index) const {
  COLOSSUS_CHECK(row_index < rows_.size(), "row {} of {}", row_index, rows_.size());
  const NodeRow& row = rows_[row_index];
  const auto defect = [&](const std::string& what) {
    return core::Defect{fmt::format("{}: node {} (level {}, centre {}, {}, {}): {}", bytes_.path().string(),
                                    row_index, row.level, row.center[0], row.center[1], row.center[2], what),
                        row.offset};
  };
  core::Bytes frame(row.stored_bytes);
  if (const std::size_t got = bytes_.read_some_at(row.offset, frame); got != frame.size())
    return defect(fmt::format("expected {} bytes at byte {}, found {}", frame.size(), row.offset, got));
  if (const std::uint64_t found = core::hash64(frame); found != row.checksum)
    return defect(fmt::format("chunk of {} bytes at byte {}: expected checksum {:016x}, found {:016x}",
                              frame.size(), row.offset, row.checksum, found));
  core::Result<core::Bytes> payload = unpack_chunk(frame, row.payload_bytes);
  if (!payload) return defect(payload.defect().message);
  return payload;
}

}  // namespace colossus::container
