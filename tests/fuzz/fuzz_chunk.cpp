// unpack_chunk on arbitrary bytes: the first four are the payload's size, the rest is the frame. What it
// accepts must be of that size, and packing it again and unpacking must give the same payload.
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "container/chunk.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colossus;
  std::uint32_t payload_bytes = 0;
  if (size < sizeof(payload_bytes)) return 0;
  std::memcpy(&payload_bytes, data, sizeof(payload_bytes));
  const auto frame = std::as_bytes(std::span(data, size)).subspan(sizeof(payload_bytes));
  const auto payload = container::unpack_chunk(frame, payload_bytes);
  if (!payload) return 0;
  if (payload.value().size() != payload_bytes) std::abort();
  const container::PackedChunk again = container::pack_chunk(payload.value(), {1, {}});
  const auto same = container::unpack_chunk(again.frame, payload_bytes);
  if (!same || same.value() != payload.value()) std::abort();
  return 0;
}
