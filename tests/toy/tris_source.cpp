// A toy format, to show that the program knows a format in one file and one table line: "tris", then the nine
// coordinates of each triangle, with white space between the numbers, and comments behind #.
#include <array>

#include "core/error.hpp"
#include "input/blocks.hpp"
#include "input/text_reader.hpp"
#include "toy/tables.hpp"

namespace colossus::toy {
namespace {

using namespace input;

class TrisSource final : public Source {
 public:
  TrisSource(core::File opened, const SourceOptions& options) : Source(std::move(opened), options) {
    info_.format = "TRIS";
  }

  std::vector<Part> parts() const override { return {{PartKind::kWhole, 0, 0}}; }

  bool read(const Part&, BlockSink& sink) const override {
    Remarks remarks;
    VertexCollector vertices(info_, sink, remarks);
    FaceCollector faces(info_, sink, remarks);
    TextReader text(file(), 0, {.comments = true, .continuations = false});
    text.word_of_any_line();  // "tris"
    for (std::string_view word; !(word = text.word_of_any_line()).empty();) {
      VertexValues values;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (axis > 0) word = text.word_of_any_line();
        values.position[axis] = number(text, word, vertices.count());
      }
      faces.polygon_corner(static_cast<std::uint32_t>(vertices.count()));
      vertices.add(values);
      if (vertices.count() % 3 == 0) faces.end_polygon();
    }
    if (vertices.count() % 3 != 0) fail_at(text, vertices.count(), "the end of the file");
    vertices.finish();
    faces.finish();
    check_vertex_count(info_, vertices.count());
    sink.remarks(remarks);
    return true;
  }

 private:
  double number(const TextReader& text, std::string_view word, std::uint64_t vertex) const {
    const auto parsed = parse_double(word);
    if (!parsed) fail_at(text, vertex, word.empty() ? "the end of the file" : word);
    return *parsed;
  }

  [[noreturn]] void fail_at(const TextReader& text, std::uint64_t vertex, std::string_view found) const {
    core::fail(core::Status::kBadData, "{}: triangle {} (line {}): expected a number, found {}",
               info_.path.string(), vertex / 3, text.line(), found);
  }
};

}  // namespace

const Format kTrisFormat{"TRIS", ".tris", nullptr,
                         [](const FileStart& start) { return start.first_word == "tris"; },
                         [](core::File file, const SourceOptions& options) -> std::unique_ptr<Source> {
                           return std::make_unique<TrisSource>(std::move(file), options);
                         }};

}  // namespace colossus::toy
