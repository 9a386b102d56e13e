#include "scratch/spool.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace colossus::scratch {
namespace {

std::uint16_t checked_kind(std::uint32_t kind) {
  COLOSSUS_CHECK(kind <= std::numeric_limits<std::uint16_t>::max(), "{}", kind);
  return static_cast<std::uint16_t>(kind);
}

}  // namespace

SpoolWriter::SpoolWriter(Location location, std::uint16_t attempt, std::uint16_t rank)
    : location_(std::move(location)), attempt_(attempt), rank_(rank) {}

void SpoolWriter::begin_stream(std::uint16_t stream) {
  COLOSSUS_CHECK(stream > kKeptStream && stream < kJournalStream, "{}", stream);
  stream_file_.reset();
  stream_ = stream;
}

RecordFile& SpoolWriter::open(std::optional<RecordFile>& file, std::uint16_t stream) {
  if (!file) file.emplace(location_, FileId{attempt_, rank_, stream});
  return *file;
}

RecordRef SpoolWriter::append(std::uint32_t kind, std::initializer_list<std::span<const std::byte>> parts) {
  return open(stream_file_, stream_).append(checked_kind(kind), parts);
}

RecordRef SpoolWriter::append_kept(std::uint32_t kind, std::span<const std::byte> payload) {
  return open(kept_file_, kKeptStream).append(checked_kind(kind), {payload});
}

void SpoolWriter::flush() {
  if (kept_file_) kept_file_->flush();
  if (stream_file_) stream_file_->flush();
}

SpoolWriter::Ends SpoolWriter::ends() const {
  return {kept_file_ ? kept_file_->size() : 0, stream_file_ ? stream_file_->size() : 0};
}

std::vector<Extent> SpoolWriter::extents_since(const Ends& before) const {
  std::vector<Extent> extents;
  const auto add = [&](std::uint16_t stream, std::uint64_t begin, std::uint64_t end) {
    if (begin < end) extents.push_back({{attempt_, rank_, stream}, 0, begin, end});
  };
  const Ends now = ends();
  add(kKeptStream, before.kept, now.kept);
  add(stream_, before.stream, now.stream);
  return extents;
}

SpoolReader::SpoolReader(Location location, std::size_t most_open_files)
    : location_(std::move(location)), most_open_files_(std::max<std::size_t>(1, most_open_files)) {}

core::Bytes SpoolReader::read(const RecordRef& ref) {
  const std::uint64_t end = record_end(ref);
  const OpenFile& open = open_file(ref.file, end);
  check_record_fits(open.file.path(), ref, open.size);
  std::array<std::byte, kRecordHeaderBytes> header{};
  core::Bytes bytes(end - ref.offset);
  // A file that was cut since it was opened leaves zeros here, which the check finds.
  open.file.read_some_at(ref.offset - kRecordHeaderBytes, header);
  open.file.read_some_at(ref.offset, bytes);
  check_record(open.file.path(), location_.key, ref, header, bytes);
  bytes.resize(ref.size);
  return bytes;
}

void SpoolReader::forget(std::uint16_t first_stream, std::uint16_t last_stream) {
  open_files_.remove_if(
      [&](const OpenFile& open) { return open.id.stream >= first_stream && open.id.stream <= last_stream; });
}

const SpoolReader::OpenFile& SpoolReader::open_file(const FileId& id, std::uint64_t least_size) {
  const auto found = std::find_if(open_files_.begin(), open_files_.end(),
                                  [&](const OpenFile& open) { return open.id == id; });
  if (found != open_files_.end()) {
    open_files_.splice(open_files_.begin(), open_files_, found);
    if (open_files_.front().size >= least_size) return open_files_.front();
    // The file has grown since. It is opened anew, since a network file system looks for the new size only
    // then.
    open_files_.pop_front();
  }
  core::File file = open_records(location_, id);
  const std::uint64_t size = file.size();
  while (open_files_.size() >= most_open_files_) open_files_.pop_back();
  open_files_.push_front({id, size, std::move(file)});
  return open_files_.front();
}

}  // namespace colossus::scratch
