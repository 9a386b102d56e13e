#include "container/chunk.hpp"

#include <zstd.h>

#include <algorithm>
#include <memory>

#include "core/hash.hpp"

namespace colossus::container {
namespace {

constexpr std::size_t kMostHeaderBytes = 32;

using CompressionContext = std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)>;

}  // namespace

PackedChunk pack_chunk(std::span<const std::byte> payload, const PackOptions& options) {
  if (payload.size() > kMaxPayloadBytes)
    core::fail(core::Status::kNoResources,
               "a node of {} bytes does not fit into a chunk: expected at most {} bytes; use a smaller "
               "--leaf-triangles",
               payload.size(), kMaxPayloadBytes);
  PackedChunk packed;
  packed.capacity_class = class_for(payload.size());
  packed.payload_bytes = static_cast<std::uint32_t>(payload.size());
  core::Bytes content(class_capacity(packed.capacity_class));
  std::copy(payload.begin(), payload.end(), content.begin());

  // A fresh context each time: a reused one keeps tables of earlier payloads, and the bytes of a node must
  // not depend on which nodes the same rank packed before.
  const CompressionContext context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  if (!context)
    core::fail(core::Status::kNoResources, "not enough memory to compress {} bytes", content.size());
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, options.zstd_level);
  ZSTD_CCtx_setPledgedSrcSize(context.get(), content.size());
  // A block header and a frame header more for each piece than for all at once.
  packed.frame.resize(ZSTD_compressBound(content.size()) + kMostHeaderBytes * (options.cuts.size() + 1));
  ZSTD_outBuffer out{packed.frame.data(), packed.frame.size(), 0};
  ZSTD_inBuffer in{content.data(), 0, 0};
  const auto compress_until = [&](std::size_t end, ZSTD_EndDirective how) {
    const std::size_t before = out.pos;
    in.size = end;
    const std::size_t left = ZSTD_compressStream2(context.get(), &out, &in, how);
    if (ZSTD_isError(left))
      core::fail(core::Status::kNoResources, "cannot compress {} bytes: {}", content.size(),
                 ZSTD_getErrorName(left));
    COLOSSUS_CHECK(left == 0 && in.pos == end, "{} bytes left of a piece that ends at {}", left, end);
    packed.piece_bytes.push_back(out.pos - before);
  };
  for (const std::size_t cut : options.cuts) compress_until(cut, ZSTD_e_flush);
  compress_until(content.size(), ZSTD_e_end);
  packed.frame.resize(out.pos);
  packed.frame.shrink_to_fit();
  packed.checksum = core::hash64(packed.frame);
  return packed;
}

core::Result<core::Bytes> unpack_chunk(std::span<const std::byte> frame, std::uint64_t payload_bytes) {
  if (payload_bytes > kMaxPayloadBytes)
    return core::Defect{
        fmt::format("payload: expected at most {} bytes, found {}", kMaxPayloadBytes, payload_bytes), 0};
  const std::uint64_t capacity = class_capacity(class_for(payload_bytes));
  const unsigned long long found = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (found == ZSTD_CONTENTSIZE_ERROR || found == ZSTD_CONTENTSIZE_UNKNOWN)
    return core::Defect{
        fmt::format("expected a zstd frame that states its content size, found {} other bytes", frame.size()),
        0};
  if (found != capacity)
    return core::Defect{fmt::format("zstd frame: expected a content of {} bytes, found {}", capacity, found),
                        0};
  const std::size_t extent = ZSTD_findFrameCompressedSize(frame.data(), frame.size());
  if (ZSTD_isError(extent) || extent != frame.size())
    return core::Defect{
        fmt::format("zstd frame: expected one frame of {} bytes, found {}", frame.size(),
                    ZSTD_isError(extent) ? ZSTD_getErrorName(extent) : std::to_string(extent)),
        0};
  if (capacity / kMaxExpansion > frame.size())
    return core::Defect{
        fmt::format("zstd frame: {} bytes cannot hold a content of {}", frame.size(), capacity), 0};

  core::Bytes content(capacity);
  const std::size_t size = ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size());
  if (ZSTD_isError(size)) return core::Defect{fmt::format("zstd frame: {}", ZSTD_getErrorName(size)), 0};
  if (size != capacity)
    return core::Defect{fmt::format("zstd frame: expected a content of {} bytes, decoded {}", capacity, size),
                        0};
  const auto padding = content.begin() + static_cast<std::ptrdiff_t>(payload_bytes);
  if (!std::all_of(padding, content.end(), [](std::byte b) { return b == std::byte{0}; }))
    return core::Defect{fmt::format("content behind the {} bytes of payload: expected zeros", payload_bytes),
                        0};
  content.resize(payload_bytes);
  return content;
}

}  // namespace colossus::container
