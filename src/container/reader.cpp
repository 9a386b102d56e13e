#include "container/reader.hpp"

#include <cstring>
#include <mutex>
#include <utility>

#include "container/chunk.hpp"
#include "container/chunk_index.hpp"
#include "container/metadata_io.hpp"
#include "container/node_table.hpp"
#include "container/open_container.hpp"
#include "container/table.hpp"
#include "core/hash.hpp"

namespace colossus::container {
namespace {

using core::Status;

// A look into the chunk index takes a microsecond or two: all rows up to so many, and of more so many.
constexpr std::size_t kMostLookups = 1 << 16;

// Whether all rows that are looked up lie where they say; spread over all, with the first and the last chunk
// of each class, which is what moves when another program copies a dataset.
bool offsets_are_right(ChunkIndex& index, std::span<const NodeRow> rows, std::uint64_t file_bytes) {
  if (place_defect(stated_places(rows), file_bytes)) return false;
  const auto counts = chunk_counts(rows);
  const std::size_t step = (rows.size() + kMostLookups - 1) / kMostLookups;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NodeRow& row = rows[i];
    const bool is_end = row.chunk_index == 0 || row.chunk_index + 1 == counts[row.capacity_class];
    if (i % step != 0 && !is_end) continue;
    const FramePlace place = index.find(i);
    if (place.offset != row.offset || place.bytes != row.stored_bytes ||
        !index.has_frames(row.capacity_class))
      return false;
  }
  return true;
}

// Classes whose chunks are no longer the frames that were written: the whole dataset has moved, and frames
// have other sizes, or it has other filters.
std::bitset<kCapacityClassCount> recoded_classes(const ChunkIndex& index, std::span<const NodeRow> rows,
                                                 const std::vector<FramePlace>& places) {
  std::bitset<kCapacityClassCount> is_recoded;
  std::bitset<kCapacityClassCount> has_stayed;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::uint32_t k = rows[i].capacity_class;
    if (places[i].bytes != rows[i].stored_bytes) is_recoded[k] = true;
    if (places[i].offset == rows[i].offset) has_stayed[k] = true;
  }
  for (std::uint32_t k = 0; k < kCapacityClassCount; ++k)
    is_recoded[k] = (is_recoded[k] && !has_stayed[k]) || !index.has_frames(k);
  return is_recoded;
}

// The last eight bytes of every payload are the XXH3-64 of all before them: what is left to compare where the
// frame is another one than was written.
bool has_own_checksum(std::span<const std::byte> payload) {
  std::uint64_t checksum = 0;
  if (payload.size() < sizeof(checksum)) return false;
  const auto content = payload.first(payload.size() - sizeof(checksum));
  std::memcpy(&checksum, payload.data() + content.size(), sizeof(checksum));
  return core::hash64(content) == checksum;
}

}  // namespace

// Keeps the file open for HDF5.
struct ContainerReader::Recoded {
  Recoded(std::unique_ptr<OpenContainer> container, std::unique_ptr<ChunkIndex> chunk_index,
          const Classes& recoded)
      : open(std::move(container)), index(std::move(chunk_index)), classes(recoded) {}
  ~Recoded() {
    const std::lock_guard lock(library_mutex());
    index.reset();
    open.reset();
  }
  Recoded(const Recoded&) = delete;
  Recoded& operator=(const Recoded&) = delete;

  core::Result<core::Bytes> read(std::size_t row) const {
    const std::lock_guard lock(library_mutex());
    const hdf5::QuietErrors quiet;
    try {
      return index->read(row);
    } catch (const core::Error& error) {
      if (open->device.failure) std::rethrow_exception(open->device.failure);
      return core::Defect{error.what(), 0};
    }
  }

  std::unique_ptr<OpenContainer> open;
  std::unique_ptr<ChunkIndex> index;
  Classes classes;
};

ContainerReader::ContainerReader(const std::filesystem::path& path)
    : bytes_(std::make_shared<core::File>(core::File::open_for_reading(path))), file_bytes_(bytes_->size()) {
  const std::lock_guard lock(library_mutex());
  const hdf5::QuietErrors quiet;
  auto open = std::make_unique<OpenContainer>(bytes_);
  try {
    metadata_ = read_metadata(open->blame, open->group.get(), *bytes_);
    const Table table = read_table(open->blame, open->group.get(), *bytes_, "nodes");
    table_offset_ = table.offset;
    rows_ = decode_rows(table, metadata_);
    auto index = std::make_unique<ChunkIndex>(open->blame, open->group.get(), open->device, rows_);
    if (offsets_are_right(*index, rows_, file_bytes_)) return;
    const Classes recoded = find_frames(*index, table.place);
    if (recoded.any()) recoded_ = std::make_shared<Recoded>(std::move(open), std::move(index), recoded);
  } catch (const core::Error&) {
    open->rethrow();
  }
}

// Where offsets do not hold: all of them from the index. Returns the classes that were encoded anew.
ContainerReader::Classes ContainerReader::find_frames(ChunkIndex& index, const std::string& place) {
  std::vector<FramePlace> places;
  places.reserve(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) places.push_back(index.find(i));
  if (const auto defect = place_defect(places, file_bytes_))
    core::fail(Status::kBadData, "{}: {}, by the chunk index", place, *defect);
  const Classes recoded = recoded_classes(index, rows_, places);
  frames_.reserve(rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const NodeRow& row = rows_[i];
    const bool is_recoded = recoded[row.capacity_class];
    if (!is_recoded && places[i].bytes != row.stored_bytes)
      core::fail(Status::kBadData, "{}: row {}: expected {} stored bytes, as the chunk index says, found {}",
                 place, i, places[i].bytes, row.stored_bytes);
    if (is_recoded && class_capacity(row.capacity_class) / kMaxExpansion > places[i].bytes)
      core::fail(Status::kBadData, "{}: row {}: expected a chunk that can hold {} bytes, found {} bytes",
                 place, i, class_capacity(row.capacity_class), places[i].bytes);
    frames_.push_back(places[i].offset);
  }
  return recoded;
}

core::Result<core::Bytes> ContainerReader::read_payload(std::size_t row_index) const {
  COLOSSUS_CHECK(row_index < rows_.size(), "row {} of {}", row_index, rows_.size());
  const NodeRow& row = rows_[row_index];
  const std::uint64_t offset = frame_offset(row_index);
  const auto defect = [&](const std::string& what) {
    return core::Defect{fmt::format("{}: node {} (level {}, centre {}, {}, {}): {}", path().string(),
                                    row_index, row.level, row.center[0], row.center[1], row.center[2], what),
                        offset};
  };
  if (recoded_ && recoded_->classes[row.capacity_class]) {
    core::Result<core::Bytes> payload = recoded_->read(row_index);
    if (!payload) return defect(payload.defect().message);
    if (!has_own_checksum(payload.value()))
      return defect(
          "chunk that another program has encoded anew: expected a payload that ends with its checksum");
    return payload;
  }
  core::Bytes frame(row.stored_bytes);
  if (const std::size_t got = bytes_->read_some_at(offset, frame); got != frame.size())
    return defect(fmt::format("expected {} bytes at byte {}, found {}", frame.size(), offset, got));
  if (const std::uint64_t found = core::hash64(frame); found != row.checksum)
    return defect(fmt::format("chunk of {} bytes at byte {}: expected checksum {:016x}, found {:016x}",
                              frame.size(), offset, row.checksum, found));
  core::Result<core::Bytes> payload = unpack_chunk(frame, row.payload_bytes);
  if (!payload) return defect(payload.defect().message);
  return payload;
}

}  // namespace colossus::container
