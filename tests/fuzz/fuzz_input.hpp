// What the fuzz targets of all formats share: any bytes, read as a file.
//
// Opening and reading must end in success or in core::Error(kBadData), within the memory of a few blocks;
// every triangle that a successful run delivers names a vertex that it delivered, polygons lie within their
// blocks, and what is strict passes leniently, too. Polygons are then cut as for verify. A build reads
// through the same calls.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/error.hpp"
#include "input/load.hpp"

namespace colossus::fuzz {

struct CountingSink : input::BlockSink {
  std::uint64_t vertex_count = 0;
  std::uint64_t largest_index = 0;
  std::uint64_t triangle_count = 0;
  input::Remarks noted;

  static void check(bool holds) {
    if (!holds) std::abort();
  }
  static void check_colors(std::size_t count, const std::vector<input::Color>& colors,
                           const std::vector<input::Color>& byte_colors) {
    check(colors.empty() || colors.size() == count);
    check(byte_colors.empty() || byte_colors.size() == count);
    check(byte_colors.empty() || !colors.empty());
  }

  void vertices(std::uint64_t, input::VertexBlock&& block) override {
    check(block.positions.size() <= input::kBlockElements);
    check(block.normals.empty() || block.normals.size() == block.positions.size());
    check_colors(block.positions.size(), block.colors, block.byte_colors);
    vertex_count += block.positions.size();
  }
  void triangles(input::TriangleBlock&& block) override {
    check(block.triangles.size() <= input::kBlockElements);
    check_colors(block.triangles.size(), block.colors, block.byte_colors);
    std::size_t end = 0;
    for (const input::Polygon& polygon : block.polygons) {
      check(polygon.corners > 3 && polygon.first >= end);
      end = polygon.first + polygon.corners - 2;
    }
    check(end <= block.triangles.size());
    triangle_count += block.triangles.size();
    for (const auto& triangle : block.triangles)
      for (const std::uint32_t index : triangle)
        largest_index = index > largest_index ? index : largest_index;
  }
  void remarks(const input::Remarks& remarks) override { noted.merge(remarks); }
};

inline void read_all(const std::string& path, bool is_lenient) {
  const auto source = input::open_source(path, {.drop_textures = true, .is_lenient = is_lenient});
  CountingSink sink;
  bool repeat = false;
  for (const input::Part& part : source->parts()) repeat |= !source->read(part, sink);
  if (repeat) {
    sink.largest_index = sink.triangle_count = 0;
    for (const input::Part& part : source->sequential_face_parts())
      CountingSink::check(source->read(part, sink));
  }
  CountingSink::check(sink.vertex_count > 0);
  CountingSink::check(sink.triangle_count == 0 || sink.largest_index < sink.vertex_count);
  warnings_of(source->info(), sink.noted);
  skipped_by(sink.noted);
  scale_of(source->info(), sink.noted);
}

// Whether it was read.
template <typename Read>
bool succeeds(const Read& read) {
  try {
    read();
    return true;
  } catch (const core::Error& error) {
    CountingSink::check(error.status() == core::Status::kBadData);
    return false;
  }
}

inline void read_input(const std::uint8_t* data, std::size_t size) {
  const int descriptor = memfd_create("input", MFD_CLOEXEC);
  if (descriptor < 0) std::abort();
  if (size > 0 && write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
  // Every other input leniently, since exceptions take most of the time.
  const bool is_lenient = size % 2 == 0;
  if (succeeds([&] { read_all(path, is_lenient); })) {
    CountingSink::check(is_lenient || succeeds([&] { read_all(path, true); }));
    succeeds([&] { input::load_mesh(std::span(&path, 1), {.drop_textures = true, .is_lenient = true}); });
  }
  close(descriptor);
}

}  // namespace colossus::fuzz
