#include "input/load.hpp"

#include <limits>

#include "core/error.hpp"
#include "core/log.hpp"
#include "geometry/lattice.hpp"
#include "input/blocks.hpp"
#include "input/polygons.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;
using Triangle = std::array<std::uint32_t, 3>;

// One file as it is delivered.
class FileSink : public BlockSink {
 public:
  void vertices(std::uint64_t first, VertexBlock&& block) override {
    put(first, block.positions, positions);
    put(first, block.colors, colors);
    put(first, block.byte_colors.empty() ? block.colors : block.byte_colors, byte_colors);
  }

  void triangles(TriangleBlock&& block) override {
    for (const Polygon& polygon : block.polygons)
      polygons.push_back({static_cast<std::uint32_t>(faces.size()) + polygon.first, polygon.corners});
    put(faces.size(), block.colors, face_colors);
    put(faces.size(), block.byte_colors.empty() ? block.colors : block.byte_colors, byte_face_colors);
    faces.insert(faces.end(), block.triangles.begin(), block.triangles.end());
  }

  void remarks(const Remarks& remarks) override { noted.merge(remarks); }

  std::vector<std::array<double, 3>> positions;
  std::vector<Color> colors, byte_colors;  // may be shorter, or empty
  std::vector<Triangle> faces;
  std::vector<Polygon> polygons;  // of the file's triangles
  std::vector<Color> face_colors, byte_face_colors;
  Remarks noted;

 private:
  template <typename T>
  static void put(std::size_t first, const std::vector<T>& from, std::vector<T>& to) {
    if (from.empty()) return;
    if (to.size() < first + from.size()) {
      if constexpr (std::is_same_v<T, Color>)
        to.resize(first + from.size(), kNoColor);
      else
        to.resize(first + from.size());
    }
    std::copy(from.begin(), from.end(), to.begin() + static_cast<std::ptrdiff_t>(first));
  }
};

FileSink read_all(const Source& source) {
  FileSink sink;
  FileSink faces;  // of parts that count on triangles only
  bool is_uniform = true;
  for (const Part& part : source.parts())
    is_uniform &= source.read(part, part.kind == PartKind::kFaces ? faces : sink);
  if (is_uniform) {
    sink.triangles(
        {std::move(faces.faces), {}, std::move(faces.face_colors), std::move(faces.byte_face_colors)});
    sink.noted.merge(faces.noted);
  } else {
    for (const Part& part : source.sequential_face_parts()) source.read(part, sink);
  }
  return sink;
}

// The colours of a file's vertices; those of its faces averaged over the triangles around.
std::vector<Color> colors_of(const FileSink& file, const ColorScale& scale) {
  std::vector<Color> colors(file.positions.size(), kNoColor);
  for (std::size_t i = 0; i < file.colors.size(); ++i)
    colors[i] = scale.pick(file.colors[i], file.byte_colors[i]);
  if (file.face_colors.empty()) return colors;
  std::vector<std::array<std::uint32_t, 5>> sums(colors.size());  // and the count
  for (std::size_t i = 0; i < file.face_colors.size(); ++i) {
    const Color color = scale.pick(file.face_colors[i], file.byte_face_colors[i]);
    for (const std::uint32_t v : file.faces[i]) {
      for (std::size_t k = 0; k < 4; ++k) sums[v][k] += color[k];
      ++sums[v][4];
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v)
    for (std::size_t k = 0; k < 4 && sums[v][4] > 0; ++k)
      colors[v][k] = static_cast<std::uint8_t>((2 * sums[v][k] + sums[v][4]) / (2 * sums[v][4]));
  return colors;
}

class Loader {
 public:
  explicit Loader(const SourceOptions& options) : options_(options) {}

  void add(const std::filesystem::path& path) {
    const auto source = open_source(path, options_);
    FileSink file = read_all(*source);
    for (const std::string& warning : warnings_of(source->info(), file.noted)) core::warn_line(warning);
    check_used(source->info(), file);
    const std::size_t base = mesh_.positions.size();
    if (base + file.positions.size() > std::numeric_limits<std::uint32_t>::max())
      fail(Status::kBadData, "the inputs have more than {} vertices together, too many to hold in memory",
           std::numeric_limits<std::uint32_t>::max());
    const std::vector<Color> colors = colors_of(file, scale_of(source->info(), file.noted));
    has_colors_ = has_colors_ || file.noted.has_colors != 0;
    mesh_.colors.insert(mesh_.colors.end(), colors.begin(), colors.end());
    mesh_.positions.insert(mesh_.positions.end(), file.positions.begin(), file.positions.end());
    for (const Polygon& polygon : file.polygons)
      polygons_.push_back({mesh_.triangles.size() + polygon.first, polygon.corners});
    for (Triangle& t : file.faces) {
      for (auto& v : t) v += static_cast<std::uint32_t>(base);
      mesh_.triangles.push_back(t);
    }
  }

  LoadedMesh take() {
    if (!has_colors_) mesh_.colors.clear();
    if (!polygons_.empty()) cut_polygons();
    return std::move(mesh_);
  }

 private:
  static void check_used(const SourceInfo& info, const FileSink& file) {
    if (file.noted.undefined_positions.count == 0) return;
    for (const Triangle& t : file.faces)
      for (const std::uint32_t v : t)
        if (!is_finite(file.positions[v])) fail_position(info.path, v, file.positions[v]);
  }

  // As a build does it: on the lattice that it fits to what triangles use.
  void cut_polygons() {
    geometry::Bounds bounds;
    for (const Triangle& t : mesh_.triangles)
      for (const std::uint32_t v : t) bounds.add(mesh_.positions[v]);
    if (!(bounds.extent() <= std::numeric_limits<double>::max())) return;  // nothing that could be built
    const geometry::Lattice lattice = geometry::Lattice::fit(bounds);
    PolygonCutter cutter;
    for (const auto& [first, corners] : polygons_)
      cutter.cut(std::span(mesh_.triangles).subspan(first, corners - 2),
                 [&](std::uint32_t v) { return lattice.input_vertex(mesh_.positions[v]); });
  }

  struct MeshPolygon {
    std::size_t first;
    std::uint32_t corners;
  };

  SourceOptions options_;
  LoadedMesh mesh_;
  std::vector<MeshPolygon> polygons_;
  bool has_colors_ = false;
};

}  // namespace

LoadedMesh load_mesh(std::span<const std::string> inputs, const SourceOptions& options) {
  Loader loader(options);
  for (const auto& path : expand_inputs(inputs)) loader.add(path);
  LoadedMesh mesh = loader.take();
  if (mesh.triangles.empty())
    fail(Status::kBadData, "{}: the input has {} vertices but no triangles", inputs.empty() ? "" : inputs[0],
         mesh.positions.size());
  return mesh;
}

}  // namespace colossus::input
