#include "codec/predict/projections.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace colossus::codec::predict {

// One after the other, without branches and without shifts by variable numbers, which are what compilers can
// do for several at a time: powers of two are made as exponents of floating point. All numbers are exact.
Projections project(const Buffer<FaceSum>& sums) {
  Projections projections{Buffer<std::uint32_t>(sums.size()), Buffer<std::uint32_t>(sums.size())};
  std::uint32_t* const us = projections.u.all().data();
  std::uint32_t* const vs = projections.v.all().data();
  const FaceSum* const all = &sums[0];
  const std::size_t count = sums.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t z = all[i].components[0];
    const std::int32_t x = all[i].components[1];
    const std::int32_t y = all[i].components[2];
    // The highest bit, without the one below it, cannot be rounded up to the next power.
    const std::int32_t size = (x ^ x >> 31) | (y ^ y >> 31) | (z ^ z >> 31);
    const auto exponent = std::bit_cast<std::int32_t>(static_cast<float>(size & ~(size >> 1))) >> 23;
    constexpr std::int32_t kOne = 127;
    const std::int32_t excess = std::max(exponent - (kOne + kSumBits - 1), 0);
    const auto unit = std::bit_cast<float>((kOne + excess) << 23);
    const auto inverse = std::bit_cast<float>((kOne - excess) << 23);
    const std::int32_t kept = -static_cast<std::int32_t>(unit);
    const float a = static_cast<float>(x & kept) * inverse;
    const float b = static_cast<float>(y & kept) * inverse;
    const float c = static_cast<float>(z & kept) * inverse;
    const float sum = std::abs(a) + std::abs(b) + std::abs(c);
    // 255 * (x / sum + 1) / 2, with one division for both. Zero lies in the middle, and a little further.
    const std::int32_t zero = sum == 0 ? 1 : 0;
    const double quotient = 255 * kHalf / static_cast<double>(sum + static_cast<float>(zero));
    const auto scale = static_cast<std::uint32_t>(static_cast<std::int32_t>(quotient));
    const std::uint32_t half = kHalf + (static_cast<std::uint32_t>(zero) << 31);
    const std::uint32_t u = static_cast<std::uint32_t>(static_cast<std::int32_t>(a + sum)) * scale + half;
    const std::uint32_t v = static_cast<std::uint32_t>(static_cast<std::int32_t>(b + sum)) * scale + half;
    us[i] = (u & ~1U) | static_cast<std::uint32_t>(z) >> 31;
    vs[i] = v;
  }
  return projections;
}

}  // namespace colossus::codec::predict
