#include "container/chunk_index.hpp"

namespace colossus::container {

using hdf5::Blame;
using hdf5::Handle;

ChunkIndex::ChunkIndex(const Blame& blame, hid_t container, hdf5::ReadDevice& device,
                       std::span<const NodeRow> rows)
    : blame_(blame), device_(device), rows_(rows) {
  H5L_info_t link{};
  if (H5Lget_info(container, "chunks", &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(blame.status, "{}: expected a group, found none", blame.place("/chunks"));
  const Handle group =
      blame.own(H5Gopen2(container, "chunks", H5P_DEFAULT), &H5Gclose, "cannot open group /chunks");
  const auto counts = chunk_counts(rows);
  for (std::uint32_t k = 0; k < kCapacityClassCount; ++k)
    if (counts[k] > 0) open_class(group.get(), k, counts[k]);
}

void ChunkIndex::open_class(hid_t group, std::uint32_t capacity_class, std::uint64_t chunk_count) {
  const std::string name = fmt::format("class_{}", capacity_class);
  const std::string place = blame_.place("/chunks/" + name);
  H5L_info_t link{};
  if (H5Lget_info(group, name.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    core::fail(
        blame_.status,
        "{}: expected a dataset of {} chunks, found none; h5repack with -f or -l drops it, with a warning "
        "only, where it has no plugin for zstd: copy without these options",
        place, chunk_count);
  Handle dataset = blame_.own(H5Dopen2(group, name.c_str(), H5P_DEFAULT), &H5Dclose, "cannot open " + place);
  const Handle type = blame_.own(H5Dget_type(dataset.get()), &H5Tclose, "cannot read the type of " + place);
  const Handle space =
      blame_.own(H5Dget_space(dataset.get()), &H5Sclose, "cannot read the extent of " + place);
  const Handle properties = blame_.own(H5Dget_create_plist(dataset.get()), &H5Pclose, "cannot read " + place);
  const hssize_t extent = H5Sget_simple_extent_npoints(space.get());
  const std::uint64_t capacity = class_capacity(capacity_class);
  hsize_t chunk = 0;
  if (H5Tequal(type.get(), H5T_STD_U8LE) <= 0 || H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Pget_layout(properties.get()) != H5D_CHUNKED || H5Pget_chunk(properties.get(), 1, &chunk) != 1 ||
      chunk != capacity)
    core::fail(blame_.status, "{}: expected one dimension of bytes in chunks of {}, found another layout",
               place, capacity);
  if (extent < 0 || static_cast<std::uint64_t>(extent) != capacity * chunk_count)
    core::fail(blame_.status, "{}: expected {} chunks of {} bytes, found an extent of {}", place, chunk_count,
               capacity, extent);
  unsigned flags = 0;
  std::size_t parameters = 0;
  has_frames_[capacity_class] = H5Pget_nfilters(properties.get()) == 1 &&
                                H5Pget_filter2(properties.get(), 0, &flags, &parameters, nullptr, 0, nullptr,
                                               nullptr) == hdf5::kZstdFilter;
  classes_[capacity_class] = std::move(dataset);
}

std::string ChunkIndex::place_of(const NodeRow& row) const {
  return blame_.place(fmt::format("/chunks/class_{}: chunk {} (row {})", row.capacity_class, row.chunk_index,
                                  &row - rows_.data()));
}

FramePlace ChunkIndex::find(std::size_t index) {
  const NodeRow& row = rows_[index];
  const hid_t dataset = classes_[row.capacity_class].get();
  const hsize_t start = class_capacity(row.capacity_class) * row.chunk_index;
  hsize_t size = 0;
  if (H5Dget_chunk_storage_size(dataset, &start, &size) < 0 || size == 0 || size > device_.bytes)
    core::fail(blame_.status,
               "{}: expected a chunk within the file's {} bytes, found none in the chunk index",
               place_of(row), device_.bytes);
  // The driver writes nothing while it traces, but that is not for HDF5 to know.
  if (size > buffer_bytes_) {
    buffer_ = std::make_unique_for_overwrite<std::byte[]>(size);
    buffer_bytes_ = size;
  }
  std::uint32_t skipped_filters = 0;
  device_.raw_bytes = 0;
  device_.is_tracing = true;
  const herr_t result = H5Dread_chunk(dataset, H5P_DEFAULT, &start, &skipped_filters, buffer_.get());
  device_.is_tracing = false;
  if (result < 0) blame_.fail(place_of(row) + ": the chunk index is damaged");
  if (device_.raw_bytes != size || skipped_filters != 0)
    core::fail(blame_.status, "{}: expected {} bytes and filter mask 0, found {} and {}", place_of(row), size,
               device_.raw_bytes, skipped_filters);
  return {device_.raw_offset, size};
}

core::Bytes ChunkIndex::read(std::size_t index) const {
  const NodeRow& row = rows_[index];
  const std::string what = place_of(row) + ": cannot read";
  const hid_t dataset = classes_[row.capacity_class].get();
  const hsize_t start = class_capacity(row.capacity_class) * row.chunk_index;
  const hsize_t count = row.payload_bytes;
  core::Bytes content(count);
  if (count == 0) return content;
  const Handle space = blame_.own(H5Dget_space(dataset), &H5Sclose, what);
  blame_.check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &start, nullptr, &count, nullptr), what);
  const Handle memory = blame_.own(H5Screate_simple(1, &count, nullptr), &H5Sclose, what);
  blame_.check(H5Dread(dataset, H5T_STD_U8LE, memory.get(), space.get(), H5P_DEFAULT, content.data()), what);
  return content;
}

}  // namespace colossus::container
