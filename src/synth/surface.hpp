// The shapes that synth sculpts: closed grids and subdivided meshes whose vertices and triangles are pure
// functions of their numbers. Internal to src/synth.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "synth/noise.hpp"
#include "synth/synth.hpp"

namespace colossus::synth {

inline constexpr std::uint64_t kMaxSynthVertices = std::uint64_t{1} << 31;

// Points of a smooth shape.
struct SurfaceBatch {
  std::array<std::array<double, kSynthBatch>, 3> position;
  PointBatch local;   // position - origin of the surface: where the noise is evaluated
  PointBatch normal;  // outward; of unit length, but shorter where the relief is to fade out
  PointBatch color;   // 0 to 255, only if has_colors()
};

class SynthSurface {
 public:
  virtual ~SynthSurface() = default;

  virtual std::uint64_t vertex_count() const = 0;
  virtual std::uint64_t triangle_count() const = 0;
  virtual bool has_colors() const { return false; }
  // Sizes in units of the coordinates: of the whole, of the largest relief, of an edge, and the largest
  // coordinate.
  virtual double extent() const = 0;
  virtual double relief_wavelength() const = 0;
  virtual double mean_edge() const = 0;
  virtual double largest_coordinate() const = 0;

  // The vertices with these numbers, at most kSynthBatch.
  virtual void evaluate(std::span<const std::uint32_t> vertices, SurfaceBatch& batch) const = 0;
  // Adds what is carved on this shape in particular to the heights, as a function of the local position
  // alone.
  virtual void add_carving(const PointBatch& local, std::size_t count, Lane& height) const = 0;
  // The corners of consecutive triangles from number `first` on, counter-clockwise from outside.
  virtual void triangles(std::uint64_t first, std::span<std::array<std::uint32_t, 3>> corners) const = 0;
  // The same of the triangles with these numbers, as many as corners; fastest where the numbers ascend.
  virtual void triangles_at(std::span<const std::uint64_t> numbers,
                            std::span<std::array<std::uint32_t, 3>> corners) const = 0;
};

std::unique_ptr<SynthSurface> make_statue_surface(std::uint64_t triangles, std::uint64_t seed);
std::unique_ptr<SynthSurface> make_subdivided_surface(const BaseMesh& base, std::uint64_t triangles);

}  // namespace colossus::synth
