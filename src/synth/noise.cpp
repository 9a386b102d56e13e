#include "synth/noise.hpp"

namespace colossus::synth {
namespace {

// One more turn per octave: a rational rotation, so that its powers are the same everywhere.
constexpr std::array<double, 9> kTurn = {2.0 / 3,  -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3,
                                         -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3};
constexpr std::uint32_t kStepX = 0x9e3779b1U, kStepY = 0x85ebca77U, kStepZ = 0xc2b2ae3dU;

std::array<double, 9> product(const std::array<double, 9>& a, const std::array<double, 9>& b) {
  std::array<double, 9> result{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      result[row * 3 + column] =
          (a[row * 3] * b[column] + a[row * 3 + 1] * b[3 + column]) + a[row * 3 + 2] * b[6 + column];
  return result;
}

inline std::int32_t floor_to_int(float x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole - static_cast<std::int32_t>(static_cast<float>(whole) > x);
}

// The corner's pseudo-random gradient (10 bits per component) times the offset from the corner.
inline float corner(std::uint32_t hash, float x, float y, float z) {
  hash ^= hash >> 15;
  hash *= 0x2c1b3c6dU;
  hash ^= hash >> 13;
  const auto gx = static_cast<float>(static_cast<std::int32_t>(hash) >> 22);
  const auto gy = static_cast<float>(static_cast<std::int32_t>(hash << 10) >> 22);
  const auto gz = static_cast<float>(static_cast<std::int32_t>(hash << 20) >> 22);
  return (gx * x + gy * y) + gz * z;
}

inline float fade(float t) { return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F); }
inline float mix(float a, float b, float t) { return a + (b - a) * t; }

inline float gradient_noise(float x, float y, float z, std::uint32_t seed) {
  const std::int32_t ix = floor_to_int(x), iy = floor_to_int(y), iz = floor_to_int(z);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy),
              fz = z - static_cast<float>(iz);
  const float gx = fx - 1.0F, gy = fy - 1.0F, gz = fz - 1.0F;
  const std::uint32_t h = static_cast<std::uint32_t>(ix) * kStepX + static_cast<std::uint32_t>(iy) * kStepY +
                          static_cast<std::uint32_t>(iz) * kStepZ + seed;
  const std::uint32_t hy = h + kStepY, hz = h + kStepZ, hyz = hy + kStepZ;
  const float u = fade(fx), v = fade(fy), w = fade(fz);
  const float a = mix(corner(h, fx, fy, fz), corner(h + kStepX, gx, fy, fz), u);
  const float b = mix(corner(hy, fx, gy, fz), corner(hy + kStepX, gx, gy, fz), u);
  const float c = mix(corner(hz, fx, fy, gz), corner(hz + kStepX, gx, fy, gz), u);
  const float d = mix(corner(hyz, fx, gy, gz), corner(hyz + kStepX, gx, gy, gz), u);
  return mix(mix(a, b, v), mix(c, d, v), w) * (1.0F / 512.0F);
}

}  // namespace

NoiseOctave make_octave(std::uint64_t seed, std::uint32_t index, double wavelength, double amplitude) {
  const std::uint64_t hash = core::mix64(core::mix64(seed + 0x632be59bd9b4e019ULL) + index);
  std::array<double, 9> turn = kTurn;
  for (std::uint32_t i = 0; i < index % 8; ++i) turn = product(turn, kTurn);
  NoiseOctave octave{};
  for (std::size_t i = 0; i < 9; ++i) octave.turn[i] = static_cast<float>(turn[i] / wavelength);
  for (unsigned i = 0; i < 3; ++i) octave.shift[i] = signed_unit(hash, 16 * i) * 64.0F;
  octave.amplitude = static_cast<float>(amplitude);
  octave.seed = static_cast<std::uint32_t>(core::mix64(hash) >> 32);
  return octave;
}

void add_noise(const NoiseOctave& octave, const PointBatch& points, std::size_t count, Lane& sum) {
  const auto turn = octave.turn;
  const auto shift = octave.shift;
  const float amplitude = octave.amplitude;
  const std::uint32_t seed = octave.seed;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = points.x.v[i], y = points.y.v[i], z = points.z.v[i];
    const float u = (turn[0] * x + turn[1] * y) + (turn[2] * z + shift[0]);
    const float v = (turn[3] * x + turn[4] * y) + (turn[5] * z + shift[1]);
    const float w = (turn[6] * x + turn[7] * y) + (turn[8] * z + shift[2]);
    sum.v[i] += amplitude * gradient_noise(u, v, w, seed);
  }
}

}  // namespace colossus::synth
