#include "synth/synth.hpp"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

#include "core/file.hpp"
#include "core/outputs.hpp"
#include "synth/order.hpp"
#include "synth/surface.hpp"

namespace colossus::synth {
namespace {

// Each octave of relief is this part of its wavelength deep: a slope that stays clear of overhangs, like
// worked stone.
constexpr double kReliefDepth = 0.11;
// The finest relief has a wavelength of 4 to 8 edges.
constexpr double kFinestWavelengthInEdges = 4;
// The scanner's noise is within this part of an edge, along the normal.
constexpr float kScannerNoiseInEdges = 0.05F;

// Raises a smooth surface by its carving, the relief and the scanner's noise, and colours it.
class Sculptor {
 public:
  Sculptor(const SynthSurface& surface, const SynthOptions& options);

  struct Vertices {
    SurfaceBatch base;  // positions as raised; normals of unit length, if asked for; colours from 0 to 255
    Lane roughness, relief, height, low, middle, fine;
  };
  // At most kSynthBatch vertices.
  void sculpt(std::span<const std::uint32_t> vertices, Vertices& result) const;

 private:
  void measure_heights(const PointBatch& local, std::size_t count, const Lane& roughness, Lane& relief,
                       Lane& height) const;
  void tilt_normals(std::size_t count, Vertices& batch) const;
  void paint(std::span<const std::uint32_t> vertices, Vertices& batch) const;

  const SynthSurface& surface_;
  bool colors_, normals_;
  std::uint64_t hash_seed_;
  float edge_;
  std::vector<NoiseOctave> relief_, low_, middle_, fine_;
};

Sculptor::Sculptor(const SynthSurface& surface, const SynthOptions& options)
    : surface_(surface),
      colors_(options.colors),
      normals_(options.normals),
      hash_seed_(core::mix64(options.seed ^ 0x5bd1e995c2b2ae35ULL)),
      edge_(static_cast<float>(surface.mean_edge())) {
  const double edge = surface.mean_edge(), extent = surface.extent();
  std::uint32_t index = 0;
  for (double wavelength = surface.relief_wavelength(); wavelength >= kFinestWavelengthInEdges * edge;
       wavelength /= 2)
    relief_.push_back(make_octave(options.seed, index++, wavelength, kReliefDepth * wavelength));
  low_ = {make_octave(options.seed, 100, 0.20 * extent, 1.6),
          make_octave(options.seed, 101, 0.07 * extent, 0.9)};
  middle_ = {make_octave(options.seed, 102, 0.02 * extent, 1.0)};
  fine_ = {make_octave(options.seed, 103, 12 * edge, 1.0), make_octave(options.seed, 104, 4 * edge, 0.8)};
}

void clear(Lane& lane, std::size_t count) { std::fill_n(lane.v.begin(), count, 0.0F); }

void add_octaves(const std::vector<NoiseOctave>& octaves, const PointBatch& points, std::size_t count,
                 Lane& sum) {
  for (const NoiseOctave& octave : octaves) add_noise(octave, points, count, sum);
}

void Sculptor::measure_heights(const PointBatch& local, std::size_t count, const Lane& roughness,
                               Lane& relief, Lane& height) const {
  clear(relief, count);
  add_octaves(relief_, local, count, relief);
  clear(height, count);
  surface_.add_carving(local, count, height);
  for (std::size_t i = 0; i < count; ++i) height.v[i] += roughness.v[i] * relief.v[i];
}

void Sculptor::sculpt(std::span<const std::uint32_t> vertices, Vertices& result) const {
  const std::size_t count = vertices.size();
  SurfaceBatch& base = result.base;
  surface_.evaluate(vertices, base);
  // Smooth and rough places, so that not all parts of a statue are equally hard to simplify.
  clear(result.low, count);
  add_octaves(low_, base.local, count, result.low);
  for (std::size_t i = 0; i < count; ++i) result.roughness[i] = std::max(0.65F + result.low[i], 0.25F);
  measure_heights(base.local, count, result.roughness, result.relief, result.height);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t hash = core::mix64(hash_seed_ + vertices[i]);
    const float noise = 0.5F * (signed_unit(hash, 0) + signed_unit(hash, 16));
    const float height = result.height[i] + kScannerNoiseInEdges * edge_ * noise;
    base.position[0][i] += static_cast<double>(base.normal.x[i] * height);
    base.position[1][i] += static_cast<double>(base.normal.y[i] * height);
    base.position[2][i] += static_cast<double>(base.normal.z[i] * height);
  }
  if (colors_) paint(vertices, result);
  if (normals_) tilt_normals(count, result);
}

// Tilts the smooth surface's normals by the slope of the heights, measured over half an edge in two
// directions. The roughness varies too slowly to matter.
void Sculptor::tilt_normals(std::size_t count, Vertices& batch) const {
  PointBatch& normal = batch.base.normal;
  const PointBatch& local = batch.base.local;
  const float step = 0.5F * edge_;
  PointBatch shifted, tilt;
  Lane height;
  for (Lane* lane : {&tilt.x, &tilt.y, &tilt.z}) clear(*lane, count);
  for (int direction = 0; direction < 2; ++direction) {
    PointBatch tangent;
    for (std::size_t i = 0; i < count; ++i) {
      const float nx = normal.x[i], ny = normal.y[i], nz = normal.z[i];
      // Across the axis that the normal is farthest from; then across both.
      const float ax = std::abs(nx), ay = std::abs(ny), az = std::abs(nz);
      float tx = 0.0F, ty = -nz, tz = ny;
      if (ay < ax && ay <= az) {
        tx = nz, ty = 0.0F, tz = -nx;
      } else if (az < ax && az < ay) {
        tx = -ny, ty = nx, tz = 0.0F;
      }
      if (direction == 1) {
        const float cx = ny * tz - nz * ty, cy = nz * tx - nx * tz, cz = nx * ty - ny * tx;
        tx = cx, ty = cy, tz = cz;
      }
      const float squared = tx * tx + ty * ty + tz * tz;
      const float scale = squared > 0.0F ? 1.0F / std::sqrt(squared) : 0.0F;
      tangent.x[i] = tx * scale, tangent.y[i] = ty * scale, tangent.z[i] = tz * scale;
      shifted.x[i] = local.x[i] + step * tangent.x[i];
      shifted.y[i] = local.y[i] + step * tangent.y[i];
      shifted.z[i] = local.z[i] + step * tangent.z[i];
    }
    measure_heights(shifted, count, batch.roughness, batch.relief, height);
    for (std::size_t i = 0; i < count; ++i) {
      const float slope = (height[i] - batch.height[i]) / step;
      tilt.x[i] -= slope * tangent.x[i], tilt.y[i] -= slope * tangent.y[i], tilt.z[i] -= slope * tangent.z[i];
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float length2 = normal.x[i] * normal.x[i] + normal.y[i] * normal.y[i] + normal.z[i] * normal.z[i];
    // Where a base mesh has no normal, there is no relief either, and any direction is as good.
    const float x = normal.x[i] + length2 * tilt.x[i], y = normal.y[i] + length2 * tilt.y[i];
    const float z = length2 > 0.0F ? normal.z[i] + length2 * tilt.z[i] : 1.0F;
    const float scale = 1.0F / std::sqrt(x * x + y * y + z * z);
    normal.x[i] = x * scale, normal.y[i] = y * scale, normal.z[i] = z * scale;
  }
}

// Weathered limestone: two stones in large patches, blotches, dirt in the hollows, grain, and a little noise
// of the camera's. A base mesh's own colours get grain and noise only.
void Sculptor::paint(std::span<const std::uint32_t> vertices, Vertices& batch) const {
  const std::size_t count = vertices.size();
  clear(batch.middle, count);
  clear(batch.fine, count);
  add_octaves(fine_, batch.base.local, count, batch.fine);
  const bool own = surface_.has_colors();
  if (!own) add_octaves(middle_, batch.base.local, count, batch.middle);
  PointBatch& color = batch.base.color;
  const auto depth = static_cast<float>(1 / (kReliefDepth * surface_.relief_wavelength()));
  for (std::size_t i = 0; i < count; ++i) {
    const float patch = std::min(std::max(0.5F + batch.low[i], 0.0F), 1.0F);
    const float hollow = std::min(std::max(1.0F + 0.35F * depth * batch.relief[i], 0.6F), 1.2F);
    const float light = hollow * (1.0F + 0.22F * batch.middle[i] + 0.12F * batch.fine[i]);
    const float grain = 10.0F * batch.fine[i];
    const float red = own ? color.x[i] + grain : (176.0F + 26.0F * patch) * light;
    const float green = own ? color.y[i] + grain : (168.0F + 16.0F * patch) * light;
    const float blue = own ? color.z[i] + grain : (148.0F - 8.0F * patch) * light;
    color.x[i] = red, color.y[i] = green, color.z[i] = blue;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t hash = core::mix64(~hash_seed_ + vertices[i]);
    color.x[i] = std::min(std::max(color.x[i] + 2.0F * signed_unit(hash, 0), 0.0F), 255.0F);
    color.y[i] = std::min(std::max(color.y[i] + 2.0F * signed_unit(hash, 16), 0.0F), 255.0F);
    color.z[i] = std::min(std::max(color.z[i] + 2.0F * signed_unit(hash, 32), 0.0F), 255.0F);
  }
}

constexpr std::uint64_t kElementsPerWrite = 64 * kSynthBatch;
static_assert(kElementsPerWrite <= std::uint64_t{1} << SynthSlot::kPlaceBits);
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::int32_t);

// Writes the file block by block; each block is computed from its number alone.
class Writer {
 public:
  Writer(const SynthSurface& surface, const SynthOptions& options, core::File& file);
  // By `threads` threads, this one among them. Throws the first error met, when all have stopped.
  void write(unsigned threads);

 private:
  std::string header() const;
  void work();
  void write_vertices(std::uint64_t first, std::size_t count);
  void write_faces(std::uint64_t first, std::size_t count);
  void put_shuffled_faces(std::uint64_t first, std::size_t count, core::Bytes& bytes) const;
  void put_vertex(std::size_t i, const SurfaceBatch& batch, std::byte* to) const;

  const SynthSurface& surface_;
  const SynthOptions& options_;
  core::File& file_;
  Sculptor sculptor_;
  SynthOrder vertex_order_, face_order_;
  bool doubles_;
  std::size_t vertex_bytes_;
  std::uint64_t vertices_offset_ = 0, faces_offset_ = 0;
  std::uint64_t vertex_blocks_, face_blocks_;
  std::atomic<std::uint64_t> next_block_{0};
  std::mutex mutex_;
  std::exception_ptr error_;
};

Writer::Writer(const SynthSurface& surface, const SynthOptions& options, core::File& file)
    : surface_(surface),
      options_(options),
      file_(file),
      sculptor_(surface, options),
      vertex_order_(surface.vertex_count(), options.seed),
      face_order_(surface.triangle_count(), ~options.seed),
      // Floats round to 2^-24 of the coordinate; the scanner's noise must remain.
      doubles_(surface.largest_coordinate() / (1 << 24) > surface.mean_edge() / 64),
      vertex_bytes_((doubles_ ? 24U : 12U) + (options.normals ? 12U : 0U) + (options.colors ? 3U : 0U)),
      vertex_blocks_((surface.vertex_count() + kElementsPerWrite - 1) / kElementsPerWrite),
      face_blocks_((surface.triangle_count() + kElementsPerWrite - 1) / kElementsPerWrite) {
  const std::string text = header();
  vertices_offset_ = text.size();
  faces_offset_ = vertices_offset_ + surface.vertex_count() * vertex_bytes_;
  file_.write_at(0, std::as_bytes(std::span(text)));
}

std::string Writer::header() const {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  text += fmt::format("comment colossus synth, seed {}\n", options_.seed);
  text += fmt::format("element vertex {}\n", surface_.vertex_count());
  for (const char axis : {'x', 'y', 'z'})
    text += fmt::format("property {} {}\n", doubles_ ? "double" : "float", axis);
  if (options_.normals) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (options_.colors) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      surface_.triangle_count());
  return text;
}

void Writer::write(unsigned threads) {
  std::vector<std::thread> others;
  const std::uint64_t useful = std::min<std::uint64_t>(threads, vertex_blocks_ + face_blocks_);
  for (std::uint64_t i = 1; i < useful; ++i) {
    try {
      others.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      break;  // fewer threads make the same file
    }
  }
  work();
  for (std::thread& other : others) other.join();
  if (error_) std::rethrow_exception(error_);
}

void Writer::work() {
  try {
    for (;;) {
      const std::uint64_t block = next_block_.fetch_add(1);
      if (block >= vertex_blocks_ + face_blocks_) return;
      const bool is_vertices = block < vertex_blocks_;
      const std::uint64_t first = (is_vertices ? block : block - vertex_blocks_) * kElementsPerWrite;
      const std::uint64_t end = is_vertices ? surface_.vertex_count() : surface_.triangle_count();
      const std::uint64_t count = std::min(kElementsPerWrite, end - first);
      if (is_vertices)
        write_vertices(first, count);
      else
        write_faces(first, count);
    }
  } catch (...) {
    next_block_ = vertex_blocks_ + face_blocks_;
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::current_exception();
  }
}

template <typename T>
std::byte* put(T value, std::byte* to) {
  std::memcpy(to, &value, sizeof(T));
  return to + sizeof(T);
}

void Writer::put_vertex(std::size_t i, const SurfaceBatch& batch, std::byte* to) const {
  for (const auto& axis : batch.position)
    to = doubles_ ? put(axis[i], to) : put(static_cast<float>(axis[i]), to);
  if (options_.normals) to = put(batch.normal.z[i], put(batch.normal.y[i], put(batch.normal.x[i], to)));
  if (!options_.colors) return;
  for (const Lane* lane : {&batch.color.x, &batch.color.y, &batch.color.z})
    // No colour is negative. NOLINTNEXTLINE(bugprone-incorrect-roundings)
    to = put(static_cast<std::uint8_t>(static_cast<int>((*lane)[i] + 0.5F)), to);
}

std::vector<SynthSlot> successive_slots(std::uint64_t first, std::size_t count) {
  std::vector<SynthSlot> slots(count);
  for (std::size_t i = 0; i < count; ++i) slots[i] = {first + i, i};
  return slots;
}

void Writer::write_vertices(std::uint64_t first, std::size_t count) {
  const std::vector<SynthSlot> slots =
      options_.shuffle ? vertex_order_.block(first, count) : successive_slots(first, count);
  core::Bytes bytes(count * vertex_bytes_);
  const auto vertices = std::make_unique<Sculptor::Vertices>();
  std::array<std::uint32_t, kSynthBatch> numbers{};
  // Batches of near vertices can skip what is carved elsewhere: the slots are sorted.
  for (std::size_t done = 0; done < count; done += kSynthBatch) {
    const std::size_t size = std::min(kSynthBatch, count - done);
    for (std::size_t i = 0; i < size; ++i) numbers[i] = static_cast<std::uint32_t>(slots[done + i].number());
    sculptor_.sculpt(std::span(numbers).first(size), *vertices);
    for (std::size_t i = 0; i < size; ++i)
      put_vertex(i, vertices->base, bytes.data() + slots[done + i].place() * vertex_bytes_);
  }
  file_.write_at(vertices_offset_ + first * vertex_bytes_, bytes);
}

void Writer::write_faces(std::uint64_t first, std::size_t count) {
  core::Bytes bytes(count * kFaceBytes);
  if (options_.shuffle) {
    put_shuffled_faces(first, count, bytes);
  } else {
    std::vector<std::array<std::uint32_t, 3>> triangles(count);
    surface_.triangles(first, triangles);
    std::byte* to = bytes.data();
    for (const auto& triangle : triangles) to = put(triangle, put(std::uint8_t{3}, to));
  }
  file_.write_at(faces_offset_ + first * kFaceBytes, bytes);
}

void Writer::put_shuffled_faces(std::uint64_t first, std::size_t count, core::Bytes& bytes) const {
  const std::vector<SynthSlot> slots = face_order_.block(first, count);
  std::array<std::uint64_t, kSynthBatch> numbers{};
  std::array<std::array<std::uint32_t, 3>, kSynthBatch> triangles{};
  for (std::size_t done = 0; done < count; done += kSynthBatch) {
    const std::size_t size = std::min(kSynthBatch, count - done);
    for (std::size_t i = 0; i < size; ++i) numbers[i] = slots[done + i].number();
    surface_.triangles_at(std::span(numbers).first(size), std::span(triangles).first(size));
    for (auto& triangle : std::span(triangles).first(size))
      for (std::uint32_t& v : triangle) v = static_cast<std::uint32_t>(vertex_order_.backward(v));
    for (std::size_t i = 0; i < size; ++i)
      put(triangles[i], put(std::uint8_t{3}, bytes.data() + slots[done + i].place() * kFaceBytes));
  }
}

unsigned usable_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return static_cast<unsigned>(CPU_COUNT(&set));
  return std::max(1U, std::thread::hardware_concurrency());
}

// Removes the unfinished file unless it was kept.
struct PartGuard {
  std::filesystem::path path;
  bool kept = false;
  ~PartGuard() {
    std::error_code ignored;
    if (!kept) std::filesystem::remove(path, ignored);
  }
};

SynthReport write_statue(const SynthSurface& surface, const SynthOptions& options) {
  const std::filesystem::path part = core::part_of(options.output);
  core::File file = core::File::create_anew(part);
  PartGuard guard{part};
  Writer(surface, options, file).write(options.threads == 0 ? usable_processors() : options.threads);
  file.close();
  std::error_code error;
  std::filesystem::rename(part, options.output, error);
  if (error)
    core::fail(core::Status::kCannotCreate, "cannot rename {} to {}: {}", part.string(),
               options.output.string(), error.message());
  guard.kept = true;
  return {surface.vertex_count(), surface.triangle_count()};
}

void check_request(const SynthOptions& options) {
  constexpr std::uint64_t kMaxTriangles = 2 * kMaxSynthVertices;
  if (options.triangles == 0 || options.triangles > kMaxTriangles)
    core::fail(core::Status::kUsage, "synth: {} triangles asked for; between 1 and {} can be made",
               options.triangles, kMaxTriangles);
}

}  // namespace

SynthReport synthesize(const SynthOptions& options) {
  check_request(options);
  return write_statue(*make_statue_surface(options.triangles, options.seed), options);
}

SynthReport synthesize(const SynthOptions& options, const BaseMesh& base) {
  check_request(options);
  return write_statue(*make_subdivided_surface(base, options.triangles), options);
}

}  // namespace colossus::synth
