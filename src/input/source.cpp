#include "input/source.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "core/file.hpp"
#include "input/formats.hpp"
#include "input/text_reader.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

// Whether the first word that is no comment is an OBJ statement or an OFF keyword.
bool starts_with_obj(std::string_view word) {
  for (std::string_view known : {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"})
    if (word == known) return true;
  return false;
}
bool starts_with_off(std::string_view word) {
  return word.substr(0, word.find_first_of("0123456789", 1)).ends_with("OFF");
}

std::string_view trim(std::string_view text) {
  const auto is_white = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  while (!text.empty() && is_white(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_white(text.back())) text.remove_suffix(1);
  return text;
}

void append_list(const std::filesystem::path& list, std::vector<std::filesystem::path>& paths) {
  const core::Bytes bytes = core::read_file(list);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::size_t before = paths.size();
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trim(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line.front() != '#') paths.push_back(list.parent_path() / line);
  }
  if (paths.size() == before)
    fail(Status::kBadData, "{}: expected a list of input files, one per line, found none", list.string());
}

}  // namespace

BlockSink::~BlockSink() = default;
Source::~Source() = default;

void refuse_textures(const SourceInfo& info, const SourceOptions& options) {
  if (info.textures.empty() || options.drop_textures) return;
  fail(Status::kBadData,
       "{}: has texture coordinates or materials ({}), which cannot be kept; transfer them to vertex "
       "colours, or drop them "
       "with --drop-textures",
       info.path.string(), fmt::join(info.textures, ", "));
}

std::unique_ptr<Source> open_source(const std::filesystem::path& path, const SourceOptions& options) {
  core::File file = core::File::open_for_reading(path);
  std::array<std::byte, 5> bytes{};
  const std::size_t size = file.read_some_at(0, bytes);
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()), size);
  if (start.empty())
    fail(Status::kBadData, "{}: is empty; expected a PLY, OBJ, STL or OFF file", path.string());
  if (start.starts_with("\x1f\x8b"))
    fail(Status::kBadData, "{}: is compressed by gzip; expected a PLY, OBJ, STL or OFF file: unpack it",
         path.string());
  const std::string extension = lower_extension(path);
  const bool is_ply = start.starts_with("ply") && start.size() > 3 && trim(start.substr(3, 1)).empty();
  if (is_ply || extension == ".ply") return open_ply(std::move(file), options);
  if (extension == ".obj") return open_obj(std::move(file), options);
  if (extension == ".stl" || is_binary_stl(file)) return open_stl(std::move(file));
  if (extension == ".off" || extension == ".coff" || extension == ".noff" || extension == ".cnoff")
    return open_off(std::move(file), options);
  if (start == "solid") return open_stl(std::move(file));
  const std::string word(TextReader(file, 0, {.comments = true, .continuations = false}).word_of_any_line());
  if (starts_with_off(word)) return open_off(std::move(file), options);
  if (starts_with_obj(word)) return open_obj(std::move(file), options);
  fail(Status::kBadData, "{}: unknown format; expected a PLY, OBJ, STL or OFF file", path.string());
}

std::vector<std::filesystem::path> expand_inputs(std::span<const std::string> arguments) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& argument : arguments) {
    if (argument.starts_with('@')) {
      append_list(argument.substr(1), paths);
    } else {
      paths.emplace_back(argument);
    }
  }
  return paths;
}

}  // namespace colossus::input
