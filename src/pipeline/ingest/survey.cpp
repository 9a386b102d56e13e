#include "pipeline/ingest/survey.hpp"

#include <xxhash.h>

#include <cmath>

#include "cluster/stop.hpp"
#include "core/file.hpp"
#include "core/log.hpp"
#include "pipeline/run/phase.hpp"

namespace colossus::pipeline::ingest {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;

// A survey task: one part of one file, or the hash of its whole content.
struct SurveyTask {
  std::uint32_t file = 0;
  std::uint32_t is_hash = 0;
  input::Part part;

  // Member by member: what lies between them would make equal tasks differ.
  Bytes to_bytes() const {
    ByteWriter writer;
    writer.put(file);
    writer.put(is_hash);
    writer.put(part.kind);
    writer.put(part.first);
    writer.put(part.count);
    return writer.take();
  }
  static SurveyTask from_bytes(std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    SurveyTask task;
    task.file = reader.get<std::uint32_t>();
    task.is_hash = reader.get<std::uint32_t>();
    task.part.kind = reader.get<input::PartKind>();
    task.part.first = reader.get<std::uint64_t>();
    task.part.count = reader.get<std::uint64_t>();
    COLOSSUS_CHECK(!reader.failed());
    return task;
  }
};

// Counts different numbers, roughly: how many of so many bits they hit (Whang et al., A linear-time
// probabilistic counting algorithm, 1990).
class DistinctCounter {
 public:
  void add(std::uint32_t number) {
    const std::uint32_t bit = number * 2654435761U >> (32 - kBits);
    std::uint64_t& word = hit_[bit / 64];
    count_ += ~word >> bit % 64 & 1;
    word |= std::uint64_t{1} << bit % 64;
  }
  // How many there were since the last call.
  std::uint64_t take() {
    const double free = 1.0 - std::min(std::ldexp(static_cast<double>(count_), -kBits), 0.999);
    std::fill(hit_.begin(), hit_.end(), 0);
    count_ = 0;
    return static_cast<std::uint64_t>(std::llround(std::ldexp(-std::log(free), kBits)));
  }

 private:
  static constexpr int kBits = 20;
  std::vector<std::uint64_t> hit_ = std::vector<std::uint64_t>(std::size_t{1} << kBits >> 6);
  std::uint64_t count_ = 0;
};

struct PartCounts {
  std::uint64_t input_block_vertices = 0;
  std::uint64_t is_uniform = 1;  // 0: faces are not all triangles, the file must be read sequentially
  input::Remarks remarks;
};

// 0: no colours; 2: also their other reading.
std::uint32_t readings(const std::vector<input::Color>& colors,
                       const std::vector<input::Color>& byte_colors) {
  return colors.empty() ? 0 : byte_colors.empty() ? 1 : 2;
}

// Writes blocks to scratch as they come, unless a stop is requested: a part may be a whole file.
class ScratchSink : public input::BlockSink {
 public:
  ScratchSink(const run::Workspace& workspace, std::uint32_t file) : workspace_(workspace), file_(file) {}

  void vertices(std::uint64_t first, input::VertexBlock&& block) override {
    cluster::throw_if_stop_requested();
    facts::VertexBlockRef ref;
    ref.file = file_;
    ref.count = static_cast<std::uint32_t>(block.positions.size());
    ref.first = first;
    const facts::RawVerticesHeader header{block.normals.empty() ? 0U : 1U,
                                          readings(block.colors, block.byte_colors)};
    ref.record = workspace_.writer.append(
        static_cast<std::uint32_t>(facts::RecordKind::kRawVertices),
        {std::as_bytes(std::span(&header, 1)), core::as_bytes(block.positions), core::as_bytes(block.normals),
         core::as_bytes(block.colors), core::as_bytes(block.byte_colors)});
    vertex_blocks.push_back(ref);
  }

  void triangles(input::TriangleBlock&& block) override {
    cluster::throw_if_stop_requested();
    if (block.triangles.empty()) return;
    facts::TriangleBlockRef ref;
    ref.file = file_;
    ref.count = static_cast<std::uint32_t>(block.triangles.size());
    const facts::RawTrianglesHeader header{static_cast<std::uint32_t>(block.polygons.size()),
                                           readings(block.colors, block.byte_colors)};
    ref.record = workspace_.writer.append(
        static_cast<std::uint32_t>(facts::RecordKind::kTriangles),
        {std::as_bytes(std::span(&header, 1)), core::as_bytes(block.triangles),
         core::as_bytes(block.polygons), core::as_bytes(block.colors), core::as_bytes(block.byte_colors)});
    triangle_blocks.push_back(ref);
    workspace_.reporter.add_triangles(ref.count);
    if (!block.colors.empty()) {
      counts.input_block_vertices += 3 * block.triangles.size();  // load_group() gives each corner a vertex
      return;
    }
    for (const mesh::Triangle& t : block.triangles)
      for (const auto v : t) distinct_.add(v);
    counts.input_block_vertices += distinct_.take();
  }

  void remarks(const input::Remarks& remarks) override { counts.remarks.merge(remarks); }

  PartCounts counts;
  std::vector<facts::VertexBlockRef> vertex_blocks;
  std::vector<facts::TriangleBlockRef> triangle_blocks;

 private:
  const run::Workspace& workspace_;
  std::uint32_t file_;
  DistinctCounter distinct_;
};

Bytes hash_of_file(const std::filesystem::path& path) {
  const core::File file = core::File::open_for_reading(path);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  XXH3_128bits_reset(state.get());
  Bytes buffer(std::size_t{4} << 20);
  for (std::uint64_t offset = 0;;) {
    cluster::throw_if_stop_requested();  // a task may take minutes
    const std::size_t got = file.read_some_at(offset, buffer);
    if (got == 0) break;
    XXH3_128bits_update(state.get(), buffer.data(), got);
    offset += got;
  }
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  const std::string text = fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class Survey {
 public:
  explicit Survey(const run::Workspace& workspace) : workspace_(workspace) {}

  facts::Catalog run() {
    open_sources();
    std::vector<SurveyTask> tasks;
    for (std::uint32_t f = 0; f < sources_.size(); ++f) {
      tasks.push_back({f, 1, {}});
      for (const input::Part& part : sources_[f]->parts()) tasks.push_back({f, 0, part});
    }
    run_tasks("survey", tasks);
    reread_irregular_files();
    number_through();
    workspace_.ranks.attempt([&] {
      if (workspace_.ranks.is_root()) settle_files();
    });
    share();
    return std::move(catalog_);
  }

 private:
  void open_sources() {
    workspace_.ranks.attempt([&] {
      for (const auto& path : input::expand_inputs(workspace_.options.inputs)) {
        sources_.push_back(
            input::open_source(path, {workspace_.options.drop_textures, workspace_.options.is_lenient}));
        sources_.back()->close();
        const input::SourceInfo& info = sources_.back()->info();
        catalog_.files.push_back(
            {path.filename().string(), info.bytes, "", info.has_normals, info.has_colors});
        catalog_.has_normals |= info.has_normals;
        core::log("input {}: {}, {} vertices, {} faces{}{}", path.string(), info.format, info.vertex_count,
                  info.face_count, info.has_normals ? ", normals" : "",
                  !info.has_colors       ? ""
                  : info.has_face_colors ? ", colours of faces"
                                         : ", colours");
        for (const std::string& name : info.skipped)
          core::log("input {}: {} is skipped", path.string(), name);
        for (const std::string& name : info.textures)
          core::log("input {}: {} is dropped", path.string(), name);
      }
    });
    remarks_.resize(sources_.size());
    face_remarks_.resize(sources_.size());
  }

  void run_tasks(const std::string& phase, const std::vector<SurveyTask>& tasks) {
    // Results arrive in any order; they are kept by task, so that blocks come in the order of the files'
    // faces.
    std::vector<Bytes> results(tasks.size());
    run_phase(
        workspace_, phase, tasks.size(), [&](std::size_t i) { return tasks[i].to_bytes(); },
        [&](std::span<const std::byte> bytes) {
          const SurveyTask task = SurveyTask::from_bytes(bytes);
          return task.is_hash != 0 ? hash_of_file(sources_[task.file]->info().path) : read_part(task);
        },
        [&](std::size_t i, Bytes result) { results[i] = std::move(result); });
    if (!workspace_.ranks.is_root()) return;
    is_irregular_.resize(sources_.size(), false);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (tasks[i].is_hash != 0)
        catalog_.files[tasks[i].file].hash.assign(reinterpret_cast<const char*>(results[i].data()),
                                                  results[i].size());
      else
        take_part(tasks[i], results[i]);
    }
  }

  Bytes read_part(const SurveyTask& task) {
    if (open_ != task.file) sources_[open_]->close();
    open_ = task.file;
    ScratchSink sink(workspace_, task.file);
    if (!sources_[task.file]->read(task.part, sink)) sink.counts.is_uniform = 0;
    ByteWriter writer;
    writer.put(sink.counts);
    writer.put(sink.vertex_blocks.size());
    writer.put_array<facts::VertexBlockRef>(sink.vertex_blocks);
    writer.put(sink.triangle_blocks.size());
    writer.put_array<facts::TriangleBlockRef>(sink.triangle_blocks);
    return writer.take();
  }

  void take_part(const SurveyTask& task, const Bytes& result) {
    ByteReader reader(result);
    const auto part = reader.get<PartCounts>();
    (task.part.kind == input::PartKind::kFaces ? face_remarks_ : remarks_)[task.file].merge(part.remarks);
    catalog_.input_block_vertices += part.input_block_vertices;
    if (part.is_uniform == 0) is_irregular_[task.file] = true;
    const auto vertex_blocks = reader.get_array<facts::VertexBlockRef>(reader.get<std::size_t>());
    catalog_.vertex_blocks.insert(catalog_.vertex_blocks.end(), vertex_blocks.begin(), vertex_blocks.end());
    const auto triangle_blocks = reader.get_array<facts::TriangleBlockRef>(reader.get<std::size_t>());
    catalog_.triangle_blocks.insert(catalog_.triangle_blocks.end(), triangle_blocks.begin(),
                                    triangle_blocks.end());
    COLOSSUS_CHECK(!reader.failed());
  }

  // A file that looked like triangles only, but is not: its triangles are read again, one after the other.
  void reread_irregular_files() {
    std::vector<std::uint32_t> files;
    for (std::uint32_t f = 0; f < is_irregular_.size(); ++f)
      if (is_irregular_[f]) files.push_back(f);
    broadcast_values(workspace_.ranks, files);
    if (files.empty()) return;
    std::vector<SurveyTask> tasks;
    for (const auto f : files) {
      std::erase_if(catalog_.triangle_blocks,
                    [&](const facts::TriangleBlockRef& block) { return block.file == f; });
      face_remarks_[f] = {};
      for (const input::Part& part : sources_[f]->sequential_face_parts()) tasks.push_back({f, 0, part});
    }
    run_tasks("survey of irregular files", tasks);
    std::stable_sort(
        catalog_.triangle_blocks.begin(), catalog_.triangle_blocks.end(),
        [](const facts::TriangleBlockRef& a, const facts::TriangleBlockRef& b) { return a.file < b.file; });
  }

  // Numbers vertices over all files, in the order of files.
  void number_through() {
    if (!workspace_.ranks.is_root()) return;
    auto& blocks = catalog_.vertex_blocks;
    std::stable_sort(blocks.begin(), blocks.end(),
                     [](const facts::VertexBlockRef& a, const facts::VertexBlockRef& b) {
                       return a.file != b.file ? a.file < b.file : a.first < b.first;
                     });
    std::vector<std::uint64_t> first_of_file(sources_.size(), 0);
    std::uint64_t next = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (i == 0 || blocks[i].file != blocks[i - 1].file) first_of_file[blocks[i].file] = next;
      blocks[i].first = next;
      next += blocks[i].count;
    }
    catalog_.counts.vertices = next;
    for (facts::TriangleBlockRef& block : catalog_.triangle_blocks) {
      block.first_vertex = first_of_file[block.file];
      catalog_.counts.triangles += block.count;
    }
  }

  static void log_scale(const input::SourceInfo& info, const input::Remarks& remarks,
                        const input::ColorScale& scale) {
    const auto text = [](bool is_unit) { return is_unit ? "0 to 1" : "0 to 255"; };
    if (remarks.has_open_colors())
      core::log("input {}: colours from {}", info.path.string(), text(scale.is_color_unit));
    if (remarks.has_open_alpha() &&
        (!remarks.has_open_colors() || scale.is_alpha_unit != scale.is_color_unit))
      core::log("input {}: alpha of colours from {}", info.path.string(), text(scale.is_alpha_unit));
  }

  // What only all parts of a file tell. On rank 0.
  void settle_files() {
    for (std::size_t f = 0; f < sources_.size(); ++f) {
      const input::SourceInfo& info = sources_[f]->info();
      input::Remarks& remarks = remarks_[f];
      remarks.merge(face_remarks_[f]);
      for (const std::string& name : input::skipped_by(remarks))
        core::log("input {}: {} is skipped", info.path.string(), name);
      for (const std::string& warning : input::warnings_of(info, remarks)) core::warn_line(warning);
      const input::ColorScale scale = input::scale_of(info, remarks);
      catalog_.color_scales.push_back(scale);
      log_scale(info, remarks, scale);
      if (remarks.has_colors != 0 && !info.has_colors)
        core::log("input {}: has colours of faces", info.path.string());
      catalog_.files[f].has_colors = remarks.has_colors != 0;
      catalog_.has_colors |= catalog_.files[f].has_colors;
      catalog_.has_face_colors |= catalog_.files[f].has_colors && info.has_face_colors;
      catalog_.has_both_readings |= catalog_.files[f].has_colors && info.has_both_readings;
      catalog_.counts.polygons += remarks.polygons;
      catalog_.counts.small_faces += remarks.small;
    }
    for (std::size_t f = 0; f < sources_.size(); ++f) {
      if (catalog_.has_colors && !catalog_.files[f].has_colors)
        core::warn("{}: has no colours, where other inputs have: it becomes white",
                   sources_[f]->info().path.string());
      if (catalog_.has_normals && !catalog_.files[f].has_normals)
        core::log("input {}: has no normals, where other inputs have: they are computed",
                  sources_[f]->info().path.string());
    }
  }

  void share() {
    std::array<bool, 3> colors{catalog_.has_colors, catalog_.has_face_colors, catalog_.has_both_readings};
    broadcast_value(workspace_.ranks, colors);
    catalog_.has_colors = colors[0];
    catalog_.has_face_colors = colors[1];
    catalog_.has_both_readings = colors[2];
    broadcast_values(workspace_.ranks, catalog_.color_scales);
    broadcast_values(workspace_.ranks, catalog_.vertex_blocks);
    broadcast_values(workspace_.ranks, catalog_.triangle_blocks);
    broadcast_value(workspace_.ranks, catalog_.counts);
    if (catalog_.counts.triangles == 0)
      throw cluster::AgreedError(
          core::Status::kBadData,
          fmt::format("{}: the input has {} vertices but no triangles; nothing can be built",
                      sources_.size() == 1 ? sources_[0]->info().path.string() : "all inputs",
                      catalog_.counts.vertices));
  }

  const run::Workspace& workspace_;
  std::vector<std::unique_ptr<input::Source>> sources_;
  std::uint32_t open_ = 0;  // all others are closed
  // By file, on rank 0; apart, those of parts that may have to be read again.
  std::vector<input::Remarks> remarks_;
  std::vector<input::Remarks> face_remarks_;
  std::vector<bool> is_irregular_;
  facts::Catalog catalog_;
};

}  // namespace

facts::Catalog survey(const run::Workspace& workspace) { return Survey(workspace).run(); }

}  // namespace colossus::pipeline::ingest
