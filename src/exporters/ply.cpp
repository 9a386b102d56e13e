#include "exporters/ply.hpp"

#include <algorithm>
#include <cstring>

#include "core/bytes.hpp"
#include "core/output_file.hpp"
#include "geometry/octahedral.hpp"

namespace colossus::exporters {
namespace {

std::string ply_header(const reader::access::CutMesh& mesh, bool has_doubles) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment a cut of a Colossus container\n";
  header += fmt::format("element vertex {}\n", mesh.positions.size());
  for (const char* name : {"x", "y", "z"})
    header += fmt::format("property {} {}\n", has_doubles ? "double" : "float", name);
  if (!mesh.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.colors.empty())
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  header += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                        mesh.triangles.size());
  return header;
}

// Appends to a file in large writes.
class BufferedFile {
 public:
  explicit BufferedFile(const core::OutputTarget& target) : file_(target) {}
  template <typename T>
  void put(const T& value) {
    buffer_.put(value);
    if (buffer_.size() >= kBufferBytes) flush();
  }
  void put_text(const std::string& text) { buffer_.put_bytes(std::as_bytes(std::span(text))); }
  void finish() {
    flush();
    file_.commit(core::OutputFile::Durability::kOnTheDevice);
  }

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 22;
  void flush() {
    file_.append(buffer_.bytes());
    buffer_ = {};
  }
  core::OutputFile file_;
  core::ByteWriter buffer_;
};

void write_body(const reader::access::CutMesh& mesh, bool has_doubles, const core::OutputTarget& target) {
  BufferedFile file(target);
  file.put_text(ply_header(mesh, has_doubles));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto& p = mesh.positions[i];
    if (has_doubles)
      file.put(p);
    else
      file.put(
          std::array<float, 3>{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    if (!mesh.normals.empty()) {
      const auto n = geometry::decode_octahedral(mesh.normals[i]);
      file.put(
          std::array<float, 3>{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])});
    }
    if (!mesh.colors.empty()) file.put(mesh.colors[i]);
  }
  for (const mesh::Triangle& t : mesh.triangles) {
    std::array<std::byte, 13> face{};
    face[0] = std::byte{3};
    std::memcpy(face.data() + 1, t.data(), 12);
    file.put(face);
  }
  file.finish();
}

}  // namespace

bool fits_floats(const reader::access::CutMesh& mesh) {
  const auto is_exact = [](double c) { return static_cast<double>(static_cast<float>(c)) == c; };
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [&](const std::array<double, 3>& p) {
    return is_exact(p[0]) && is_exact(p[1]) && is_exact(p[2]);
  });
}

WrittenPly write_ply(const reader::access::CutMesh& mesh, const core::OutputTarget& target) {
  const bool has_doubles = !fits_floats(mesh);
  write_body(mesh, has_doubles, target);
  return {mesh.positions.size(), mesh.triangles.size(), has_doubles};
}

}  // namespace colossus::exporters
