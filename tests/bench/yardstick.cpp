// yardstick FILE: reads a mesh into memory and simplifies it to half with meshoptimizer, in one thread.
// Prints one JSON object; "seconds" is the simplification alone.
#include <meshoptimizer.h>

#include <chrono>
#include <limits>

#include "core/error.hpp"
#include "input/load.hpp"

namespace {

using namespace colossus;

void run(const std::string& file) {
  const input::LoadedMesh mesh = input::load_mesh(std::span(&file, 1));
  std::vector<float> positions;
  positions.reserve(3 * mesh.positions.size());
  for (const auto& p : mesh.positions)
    for (const double x : p) positions.push_back(static_cast<float>(x));
  const std::uint32_t* indices = mesh.triangles[0].data();
  const std::size_t index_count = 3 * mesh.triangles.size();
  std::vector<std::uint32_t> simplified(index_count);
  const auto start = std::chrono::steady_clock::now();
  const std::size_t kept = meshopt_simplify(
      simplified.data(), indices, index_count, positions.data(), mesh.positions.size(), 3 * sizeof(float),
      mesh.triangles.size() / 2 * 3, std::numeric_limits<float>::max(), 0, nullptr);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{{\"triangles\": {}, \"kept\": {}, \"seconds\": {:.6f}}}\n", mesh.triangles.size(), kept / 3,
             seconds);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: yardstick FILE\n");
    return 2;
  }
  try {
    run(argv[1]);
  } catch (const core::Error& error) {
    fmt::print(stderr, "yardstick: {}\n", error.what());
    return static_cast<int>(error.status());
  }
  return 0;
}
