// Synthetic statues of any size, for scaling studies on machines where no scan lies.
//
// A statue is a smooth shape (built in, or a mesh of the user's), sculpted with relief over many octaves down
// to a few edge lengths, a little scanner noise, and textured colours. It is streamed: every vertex and
// triangle is a pure function of its number, so memory does not grow with the size (beyond the user's mesh)
// and the bytes depend neither on threads nor on the machine.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace colossus::synth {

// A mesh of the user's as the base shape. Vertices at equal positions are taken as one, triangles with two
// equal corners are dropped. `colors` is empty or as long as `positions`.
struct BaseMesh {
  std::string name;  // for messages: the file it came from
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint8_t, 3>> colors;
};

struct SynthOptions {
  std::filesystem::path output;         // a regular file, or nothing yet
  std::uint64_t triangles = 2'000'000;  // about so many; SynthReport has the number written
  std::uint64_t seed = 1;
  bool colors = true;
  bool normals = false;  // of the relief, without the scanner noise
  bool shuffle = false;  // vertices and faces in an order without locality
  unsigned threads = 0;  // 0: one per processor that this process may use
};

struct SynthReport {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

// Writes a binary little-endian PLY: float (double where floats would not resolve the base mesh's
// coordinates) x y z, then nx ny nz and uchar red green blue as asked for; faces as list uchar int
// vertex_indices. It is written to `output` + ".part" and renamed, not flushed to the device; after an error
// nothing is left behind.
//
// The built-in statue stands 2 m tall on the plane z = 0, in millimetres, facing -y: closed, manifold,
// oriented outward, with at least 12 triangles, within 1 % of the request above 10,000.
//
// Throws core::Error: kUsage when the request is 0 or would need more than 2^31 vertices, kCannotCreate, kIo,
// kNoResources when the disk is full. Cost: 0.2 to 0.6 microseconds per vertex and core. Not collective.
SynthReport synthesize(const SynthOptions& options);

// The same on a base mesh: its F triangles become k x k or, the larger ones, (k + 1) x (k + 1), on a smooth
// (point-normal) surface through its vertices. A request of N >= F is nearly always met exactly or but for
// one triangle, at worst but for k = sqrt(N / F) (more, if most edges have three triangles or more); for less
// the base stays as it is. Edges keep their number of triangles: closed stays closed, and border and
// non-manifold edges stay straight and in place. Throws also kBadData for a mesh without triangles, an index
// out of range or a coordinate that is not finite. Memory: about 200 bytes per base triangle.
SynthReport synthesize(const SynthOptions& options, const BaseMesh& base);

}  // namespace colossus::synth
