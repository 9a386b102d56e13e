// Gradient noise over batches of points, and hashes of numbers: what the relief and the colours of synth are
// made of.
//
// Only + - * / and integer arithmetic in a fixed order per point, written as loops over arrays that compilers
// turn into SSE2 code: the values are the same whether or not they do.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/hash.hpp"

namespace colossus::synth {

inline constexpr std::size_t kSynthBatch = 512;

// One value per point of a batch.
struct alignas(64) Lane {
  std::array<float, kSynthBatch> v;
  float& operator[](std::size_t i) { return v[i]; }
  float operator[](std::size_t i) const { return v[i]; }
};

struct PointBatch {
  Lane x, y, z;
};

// Noise of one wavelength. Every octave has its own lattice, turned and moved, so that the lattices of
// several octaves do not show as stripes.
struct NoiseOctave {
  std::array<float, 9> turn;  // rotation divided by the wavelength, row by row
  std::array<float, 3> shift;
  float amplitude;
  std::uint32_t seed;
};

// `index` tells octaves of one seed apart.
NoiseOctave make_octave(std::uint64_t seed, std::uint32_t index, double wavelength, double amplitude);

// sum[i] += amplitude * noise(point i), noise being between -1 and 1, of mean 0 and a standard deviation of
// about 0.25.
void add_noise(const NoiseOctave& octave, const PointBatch& points, std::size_t count, Lane& sum);

// Uniform in [-1, 1), from the upper or any other 16 bits of a hash.
inline float signed_unit(std::uint64_t hash, unsigned shift) {
  const auto bits = static_cast<int>((hash >> shift) & 0xffffU);
  return static_cast<float>(bits - 0x8000) * (1.0F / 32768.0F);
}

}  // namespace colossus::synth
