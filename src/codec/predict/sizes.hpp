// Sizes in bytes of seven bits, the lowest first; all but the last have bit 7 set.
#pragma once

#include "core/bytes.hpp"

namespace colossus::codec::predict {

inline void put_size(core::ByteWriter& writer, std::size_t size) {
  for (; size >= 128; size >>= 7) writer.put(static_cast<std::uint8_t>(size | 128));
  writer.put(static_cast<std::uint8_t>(size));
}

// Below 2^35, whatever the bytes.
inline std::size_t get_size(core::ByteReader& reader) {
  std::size_t size = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    const auto byte = reader.get<std::uint8_t>();
    size |= static_cast<std::size_t>(byte & 127U) << shift;
    if (byte < 128) break;
  }
  return size;
}

}  // namespace colossus::codec::predict
