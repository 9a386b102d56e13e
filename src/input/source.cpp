#include "input/source.hpp"

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "core/file.hpp"
#include "input/detect_format.hpp"

namespace colossus::input {
namespace {

using core::fail;
using core::Status;

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
  if (text.find('\0') != std::string_view::npos)
    fail(Status::kBadData, "{}: is no text; expected a list of input files, one per line", list.string());
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

Source::Source(core::File file, const SourceOptions& options) : options_(options), file_(std::move(file)) {
  info_.path = file_.path();
  info_.bytes = file_.size();
}

void Source::close() {
  const std::lock_guard lock(mutex_);
  file_.close();
}

const core::File& Source::file() const {
  const std::lock_guard lock(mutex_);
  if (file_.is_open()) return file_;
  file_ = core::File::open_for_reading(info_.path);
  if (file_.size() != info_.bytes)
    fail(Status::kBadData, "{}: was changed while it was read: expected {} bytes, found {}",
         info_.path.string(), info_.bytes, file_.size());
  return file_;
}

std::unique_ptr<Source> open_source(const std::filesystem::path& path, const SourceOptions& options) {
  core::File file = core::File::open_for_reading(path);
  const Format& format = detect_format(file);
  return format.open(std::move(file), options);
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

std::vector<std::filesystem::path> lists_of(std::span<const std::string> arguments) {
  std::vector<std::filesystem::path> lists;
  for (const std::string& argument : arguments)
    if (argument.starts_with('@')) lists.emplace_back(argument.substr(1));
  return lists;
}

}  // namespace colossus::input
