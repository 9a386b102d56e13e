// Unit normals as two bytes: the octahedral parametrisation (Meyer et al. 2010, "On floating-point normal
// vectors").
#pragma once

#include <array>
#include <cstdint>

namespace colossus::geometry {

// A direction as three signed 16-bit integers; length about 32767, never all zero once it is valid.
using Normal16 = std::array<std::int16_t, 3>;

// A direction of any length to Normal16; a zero vector becomes +z, so that every vertex has a normal.
Normal16 to_normal16(double x, double y, double z);

// The code whose decoded direction is nearest among the four around the exact one; the largest error is below
// 1 degree.
std::array<std::uint8_t, 2> encode_octahedral(const Normal16& normal);

// A unit vector.
std::array<double, 3> decode_octahedral(std::array<std::uint8_t, 2> code);

}  // namespace colossus::geometry
