#include "scratch/mapped_spool.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace colossus::scratch {

MappedSpool::~MappedSpool() {
  for (const auto& [ref, mapping] : mappings_) ::munmap(mapping.address, mapping.size);
}

std::span<const std::byte> MappedSpool::map(const RecordRef& ref) {
  if (const auto found = mappings_.find(ref); found != mappings_.end()) return found->second.payload;
  const core::File file = open_records(location_, ref.file);
  check_record_fits(file.path(), ref, file.size());

  const auto page_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t begin = ref.offset - kRecordHeaderBytes;
  const std::uint64_t first_page = begin / page_bytes * page_bytes;
  const std::size_t size = record_end(ref) - first_page;
  void* const address =
      ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.descriptor(), static_cast<off_t>(first_page));
  if (address == MAP_FAILED)
    core::fail(errno == ENOMEM ? core::Status::kNoResources : core::Status::kIo,
               "{}: cannot map {} bytes at byte {}: {}", file.path().string(), size, first_page,
               std::strerror(errno));
  const std::span<const std::byte> record =
      std::span(static_cast<const std::byte*>(address), size).subspan(begin - first_page);
  try {
    check_record(file.path(), location_.key, ref, record.first(kRecordHeaderBytes),
                 record.subspan(kRecordHeaderBytes));
    const std::span<const std::byte> payload = record.subspan(kRecordHeaderBytes, ref.size);
    mappings_.emplace(ref, Mapping{address, size, payload});
    return payload;
  } catch (...) {
    ::munmap(address, size);
    throw;
  }
}

void MappedSpool::fail_size(const RecordRef& ref, std::size_t value_size) const {
  core::fail(core::Status::kIo,
             "{}: scratch record at byte {}: expected a whole number of values of {} bytes, found {} bytes",
             path_of(location_.folder, ref.file).string(), ref.offset, value_size, ref.size);
}

}  // namespace colossus::scratch
