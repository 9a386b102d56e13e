#include "input/ply_header.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "core/error.hpp"

namespace colossus::input {
namespace {

constexpr std::size_t kMaxHeader = std::size_t{1} << 20;
// Of elements, and of properties per element; names are looked up linearly.
constexpr std::size_t kMaxEntries = 1000;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::optional<PlyType> type_by_name(std::string_view name) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::kInt8},       {"int8", PlyType::kInt8},      {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},     {"short", PlyType::kInt16},    {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16},   {"uint16", PlyType::kUint16},  {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},     {"uint", PlyType::kUint32},    {"uint32", PlyType::kUint32},
      {"int64", PlyType::kInt64},     {"uint64", PlyType::kUint64},  {"float", PlyType::kFloat32},
      {"float32", PlyType::kFloat32}, {"double", PlyType::kFloat64}, {"float64", PlyType::kFloat64}};
  for (const auto& [known, type] : kNames)
    if (known == name) return type;
  return {};
}

class Parser {
 public:
  Parser(const core::File& file, std::string_view text, bool is_lenient)
      : file_(file), text_(text), is_lenient_(is_lenient), at_(text.starts_with(kByteOrderMark) ? 3 : 0) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    if (end + 1 < text.size() && text[end] == '\r' && text[end + 1] != '\n') line_end_ = '\r';
  }

  PlyHeader parse() {
    next_line();
    if (take_word() != "ply") bad("expected 'ply'");
    while (true) {
      next_line();
      const std::string_view keyword = take_word();
      if (keyword == "end_header") break;
      if (keyword == "format") {
        parse_format();
      } else if (keyword == "element") {
        parse_element();
      } else if (keyword == "property") {
        parse_property();
      } else if (keyword == "comment") {
        if (take_word() == "TextureFile") header_.texture_comments.emplace_back(line_);
      } else if (keyword == "obj_info") {
        header_.has_object_info = true;
      } else if (!keyword.empty()) {
        take_prose();
      }
    }
    if (!has_format_) bad("expected a format line before it");
    header_.bytes = at_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void bad(std::string_view expected) const {
    core::fail(core::Status::kBadData, "{}: header line {}: {}, found '{}'", file_.path().string(),
               line_number_, expected, line_.substr(0, 200));
  }

  void next_line() {
    ++line_number_;
    const std::size_t end = text_.find(line_end_, at_);
    if (end == std::string_view::npos)
      core::fail(core::Status::kBadData,
                 "{}: header: expected end_header within {} bytes, found the end after line {}",
                 file_.path().string(), kMaxHeader, line_number_ - 1);
    line_ = text_.substr(at_, end - at_);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    rest_ = line_;
    at_ = end + 1;
  }

  void take_prose() {
    if (!is_lenient_)
      bad("expected format, element, property, comment, obj_info or end_header (--lenient passes over "
          "prose)");
    if (header_.prose_lines++ == 0) header_.first_prose_line = line_number_;
  }

  std::string_view take_word() {
    const std::size_t begin = std::min(rest_.find_first_not_of(" \t"), rest_.size());
    const std::size_t end = std::min(rest_.find_first_of(" \t", begin), rest_.size());
    const std::string_view word = rest_.substr(begin, end - begin);
    rest_.remove_prefix(end);
    return word;
  }
  void expect_line_end() {
    if (!take_word().empty()) bad("expected nothing more on this line");
  }

  void parse_format() {
    if (has_format_) bad("expected one format line only");
    has_format_ = true;
    const std::string_view name = take_word();
    if (name == "ascii") {
      header_.format = PlyFormat::kAscii;
    } else if (name == "binary_little_endian") {
      header_.format = PlyFormat::kLittleEndian;
    } else if (name == "binary_big_endian") {
      header_.format = PlyFormat::kBigEndian;
    } else {
      bad("expected format ascii, binary_little_endian or binary_big_endian");
    }
    if (take_word() != "1.0") bad("expected format version 1.0");
    expect_line_end();
  }

  void parse_element() {
    PlyElement element;
    element.name = take_word();
    if (element.name.empty()) bad("expected the name of an element");
    if (header_.find(element.name) != nullptr) bad("expected elements with different names");
    const std::string_view count = take_word();
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (header_.elements.size() == kMaxEntries) bad("expected at most 1000 elements");
    if (count.empty() || error != std::errc() || end != count.data() + count.size())
      bad("expected a count from 0 to 2^64 - 1");
    expect_line_end();
    header_.elements.push_back(std::move(element));
  }

  PlyType take_type() {
    const auto type = type_by_name(take_word());
    if (!type) bad("expected a type such as uchar, int or float");
    return *type;
  }

  void parse_property() {
    if (header_.elements.empty()) bad("expected an element before its properties");
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    const std::string_view before = rest_;
    property.is_list = take_word() == "list";
    if (property.is_list) {
      property.count_type = take_type();
      if (is_float(property.count_type) && !is_lenient_)
        bad("expected an integer type for a list's count (--lenient lets floats pass)");
    } else {
      rest_ = before;
    }
    property.type = take_type();
    property.name = take_word();
    if (element.properties.size() == kMaxEntries) bad("expected at most 1000 properties per element");
    if (property.name.empty()) bad("expected the name of a property");
    if (element.find(property.name) >= 0) bad("expected properties with different names");
    expect_line_end();
    element.has_list |= property.is_list;
    element.row_bytes += ply_size(property.is_list ? property.count_type : property.type);
    element.properties.push_back(std::move(property));
  }

  const core::File& file_;
  std::string_view text_;
  bool is_lenient_;
  char line_end_ = '\n';
  std::size_t at_;
  std::uint64_t line_number_ = 0;
  std::string_view line_;
  std::string_view rest_;
  bool has_format_ = false;
  PlyHeader header_;
};

}  // namespace

int PlyElement::find(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i)
    if (properties[i].name == property) return static_cast<int>(i);
  return -1;
}

const PlyElement* PlyHeader::find(std::string_view element) const {
  for (const PlyElement& candidate : elements)
    if (candidate.name == element) return &candidate;
  return nullptr;
}

PlyHeader read_ply_header(const core::File& file, bool is_lenient) {
  // Most headers are short; the whole limit is only read for those that are not.
  for (std::size_t size : {std::size_t{1} << 12, kMaxHeader}) {
    std::string text(size, '\0');
    text.resize(file.read_some_at(0, std::as_writable_bytes(std::span(text))));
    const bool last = size == kMaxHeader || text.size() < size;
    if (last || text.find("end_header\n") != std::string::npos ||
        text.find("end_header\r\n") != std::string::npos)
      return Parser(file, text, is_lenient).parse();
  }
  return {};
}

}  // namespace colossus::input
