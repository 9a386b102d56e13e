// A node's payload as the bytes of one HDF5 chunk, made and read without HDF5, so that workers can do it.
//
// HDF5 demands that every chunk of a dataset decodes to the same number of bytes, its capacity. Payloads
// differ in size, so there are several datasets, one per capacity class, and a payload is padded with zeros
// to the smallest capacity that holds it. Classes grow by quarters of a power of two: the padding is at most
// a quarter of the payload (or 4 KiB), a tenth on average, and costs a reader memory only, since a run of
// zeros compresses to a few bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::container {

// Class k holds 1024 * (4 + k % 4) * 2^(k / 4) bytes: 4, 5, 6, 7, 8, 10, 12, 14, 16, 20 KiB ... 1 GiB.
inline constexpr std::uint32_t kCapacityClassCount = 73;
inline constexpr std::uint64_t kMaxPayloadBytes = std::uint64_t{1} << 30;
// A zstd block of a frame decodes to at most 128 KiB and takes at least 4 bytes (an RLE block: header and
// value).
inline constexpr std::uint64_t kMaxExpansion = (std::uint64_t{128} << 10) / 4;

// The bytes that a chunk of the class decodes to. capacity_class < kCapacityClassCount.
constexpr std::uint64_t class_capacity(std::uint32_t capacity_class) {
  return std::uint64_t{1024} * (4 + capacity_class % 4) << (capacity_class / 4);
}

// The smallest class that holds payload_bytes; kCapacityClassCount when none does.
constexpr std::uint32_t class_for(std::uint64_t payload_bytes) {
  std::uint32_t k = 0;
  while (k < kCapacityClassCount && class_capacity(k) < payload_bytes) ++k;
  return k;
}

struct PackedChunk {
  std::uint32_t capacity_class = 0;
  std::uint32_t payload_bytes = 0;
  core::Bytes frame;  // one zstd frame that decodes to class_capacity() bytes: the payload, then zeros
  std::uint64_t checksum = 0;  // XXH3-64 of frame
  // What each piece of the payload takes in the frame; the last is the rest behind the last cut.
  std::vector<std::uint64_t> piece_bytes;
};

struct PackOptions {
  int zstd_level = 3;
  // Where pieces of the payload end that are to be told apart in piece_bytes: ascending offsets within it.
  std::span<const std::size_t> cuts;
};

// Packs a payload. Equal payloads and options give equal frames (for one version of zstd), whatever was
// packed before. Throws Error(kNoResources) when the payload has more than kMaxPayloadBytes. Not collective.
PackedChunk pack_chunk(std::span<const std::byte> payload, const PackOptions& options = {});

// The first payload_bytes of what the frame decodes to. The frame must be exactly what pack_chunk makes: one
// zstd frame, nothing behind it, whose content is the capacity of payload_bytes' class and zero behind the
// payload. Total on any input: never allocates more than that capacity (at most a quarter above
// payload_bytes, or 4 KiB) and a constant, and nothing at all when the frame is too small to hold so much.
// The defect's offset counts in the frame.
core::Result<core::Bytes> unpack_chunk(std::span<const std::byte> frame, std::uint64_t payload_bytes);

}  // namespace colossus::container
