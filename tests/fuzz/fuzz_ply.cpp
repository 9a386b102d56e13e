// Any bytes, read as a file of any format: opening and reading must end in success or in
// core::Error(kBadData), within the memory of a few blocks, and every triangle that a successful run delivers
// names a vertex that it delivered.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/error.hpp"
#include "input/source.hpp"

namespace {

using namespace colossus;

struct CountingSink : input::BlockSink {
  std::uint64_t vertex_count = 0;
  std::uint64_t largest_index = 0;
  std::uint64_t triangle_count = 0;

  void vertices(std::uint64_t, input::VertexBlock&& block) override {
    if (block.positions.size() > input::kBlockElements) std::abort();
    if (!block.normals.empty() && block.normals.size() != block.positions.size()) std::abort();
    if (!block.colors.empty() && block.colors.size() != block.positions.size()) std::abort();
    vertex_count += block.positions.size();
  }
  void triangles(input::TriangleBlock&& block) override {
    if (block.triangles.size() > input::kBlockElements) std::abort();
    triangle_count += block.triangles.size();
    for (const auto& triangle : block.triangles)
      for (const std::uint32_t index : triangle)
        largest_index = index > largest_index ? index : largest_index;
  }
};

void read_all(const std::string& path) {
  const auto source = input::open_source(path, {.drop_textures = true});
  CountingSink sink;
  bool repeat = false;
  for (const input::Part& part : source->parts()) repeat |= !source->read(part, sink);
  if (repeat) {
    sink.largest_index = sink.triangle_count = 0;
    for (const input::Part& part : source->sequential_face_parts())
      if (!source->read(part, sink)) std::abort();
  }
  if (sink.vertex_count == 0) std::abort();
  if (sink.triangle_count > 0 && sink.largest_index >= sink.vertex_count) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int descriptor = memfd_create("input", MFD_CLOEXEC);
  if (descriptor < 0) std::abort();
  if (size > 0 && write(descriptor, data, size) != static_cast<ssize_t>(size)) std::abort();
  try {
    read_all("/proc/self/fd/" + std::to_string(descriptor));
  } catch (const core::Error& error) {
    if (error.status() != core::Status::kBadData) std::abort();
  }
  close(descriptor);
  return 0;
}
