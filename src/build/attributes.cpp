// Phase 2: lattice positions, normals of the whole mesh, equal attributes at equal positions.
#include <algorithm>

#include "build/survey.hpp"

namespace colossus::build {
namespace {

using core::ByteReader;
using core::Bytes;
using core::ByteWriter;
using mesh::Vertex;
using Wide = __int128;

// What triangles add to a vertex of another rank: cross products of lattice vectors, twice the area long.
struct Contribution {
  std::uint64_t vertex;
  std::array<std::int64_t, 3> normal;
};

struct WideNormal {
  std::array<Wide, 3> sum{};
  void add(const std::array<std::int64_t, 3>& n) {
    for (std::size_t i = 0; i < 3; ++i) sum[i] += n[i];
  }
};

// A vertex that shares its position with others, on its way to the rank that merges them and back.
struct SharedVertex {
  geometry::Point position;
  mesh::Normal16 normal;  // as read, or zero
  mesh::Color color;
  std::array<std::uint64_t, 6> computed;  // the three 128-bit sums, low halves first
};

struct MergedAttributes {
  mesh::Normal16 normal;
  mesh::Color color;
};

bool is_unknown(const mesh::Normal16& n) { return n[0] == 0 && n[1] == 0 && n[2] == 0; }

mesh::Normal16 normal_of(const WideNormal& wide) {
  return geometry::to_normal16(static_cast<double>(wide.sum[0]), static_cast<double>(wide.sum[1]),
                               static_cast<double>(wide.sum[2]));
}

class LatticePlacement {
 public:
  LatticePlacement(const Workspace& workspace, Catalog& catalog) : workspace_(workspace), catalog_(catalog) {}

  void run() {
    catalog_.lattice = geometry::Lattice::fit(catalog_.bounds);
    place();
    load();
    if (workspace_.ranks.max<std::uint64_t>(has_unknown_normals_ ? 1 : 0) != 0) sum_normals();
    merge_positions();
    std::array<std::uint64_t, 2> sums{merged_vertices_, attribute_seams_};
    workspace_.ranks.all_sum(std::span<std::uint64_t>(sums));
    catalog_.counts.merged_vertices = sums[0];
    catalog_.counts.attribute_seams = sums[1];
    store();
  }

  void round(std::int32_t spacing) {
    load();
    for (auto& block : mine_)
      for (Vertex& v : block)
        for (int axis = 0; axis < 3; ++axis)
          v.position[axis] = (v.position[axis] + spacing / 2) & ~(spacing - 1);
    merge_positions();
    store();
  }

 private:
  std::size_t owner(std::size_t block) const {
    return block % static_cast<std::size_t>(workspace_.ranks.size());
  }

  Vertex placed(const std::array<double, 3>& position) const {
    Vertex v;
    v.position = catalog_.lattice.input_vertex(position);
    v.normal = {0, 0, 0};
    return v;
  }

  // Every rank turns its share of raw blocks into vertices; then all know where all blocks lie.
  void place() {
    workspace_.ranks.attempt([&] {
      for_my_share(workspace_.ranks, catalog_.vertex_blocks.size(), [&](std::size_t i) {
        const Bytes raw = workspace_.reader.read(catalog_.vertex_blocks[i].record);
        ByteReader reader(raw);
        const std::uint64_t count = catalog_.vertex_blocks[i].count;
        const auto present = reader.get<std::array<std::uint64_t, 2>>();
        const auto positions = reader.get_array<std::array<double, 3>>(count);
        const auto normals = reader.get_array<std::array<float, 3>>(present[0] != 0 ? count : 0);
        const auto colors = reader.get_array<mesh::Color>(present[1] != 0 ? count : 0);
        COLOSSUS_CHECK(!reader.failed());
        std::vector<Vertex> vertices;
        vertices.reserve(count);
        for (std::size_t v = 0; v < count; ++v) {
          vertices.push_back(placed(positions[v]));
          if (!normals.empty() && (normals[v][0] != 0.0F || normals[v][1] != 0.0F || normals[v][2] != 0.0F))
            vertices.back().normal = geometry::to_normal16(normals[v][0], normals[v][1], normals[v][2]);
          if (!colors.empty()) vertices.back().color = colors[v];
        }
        catalog_.vertex_blocks[i].record = workspace_.writer.append(
            static_cast<std::uint32_t>(RecordKind::kVertices), core::as_bytes(vertices));
      });
    });
    share_records();
  }

  void share_records() {
    std::vector<scratch::RecordRef> mine;
    for_my_share(workspace_.ranks, catalog_.vertex_blocks.size(),
                 [&](std::size_t i) { mine.push_back(catalog_.vertex_blocks[i].record); });
    workspace_.writer.flush();
    const auto all = workspace_.ranks.all_gather(core::as_bytes(mine));
    for (std::size_t i = 0; i < catalog_.vertex_blocks.size(); ++i) {
      ByteReader reader(all[owner(i)]);
      reader.get_bytes(i / all.size() * sizeof(scratch::RecordRef));
      catalog_.vertex_blocks[i].record = reader.get<scratch::RecordRef>();
    }
  }

  void load() {
    workspace_.ranks.attempt([&] {
      for_my_share(workspace_.ranks, catalog_.vertex_blocks.size(), [&](std::size_t i) {
        const Bytes bytes = workspace_.reader.read(catalog_.vertex_blocks[i].record);
        mine_.push_back(ByteReader(bytes).get_array<Vertex>(catalog_.vertex_blocks[i].count));
        sums_.emplace_back();
        for (const Vertex& v : mine_.back()) has_unknown_normals_ |= is_unknown(v.normal);
      });
    });
  }

  // In rounds of one triangle block per rank: cross products go to the ranks that own the vertices.
  void sum_normals() {
    for (std::size_t i = 0; i < mine_.size(); ++i) sums_[i].resize(mine_[i].size());
    scratch::MappedSpool mapped(workspace_.scratch);
    std::optional<VertexStore> store;
    workspace_.ranks.attempt([&] { store.emplace(catalog_.vertex_blocks, mapped); });
    const auto size = static_cast<std::size_t>(workspace_.ranks.size());
    const auto rank = static_cast<std::size_t>(workspace_.ranks.rank());
    for (std::size_t round = 0; round * size < catalog_.triangle_blocks.size(); ++round) {
      std::vector<std::vector<Contribution>> outgoing(size);
      workspace_.ranks.attempt([&] {
        if (round * size + rank < catalog_.triangle_blocks.size())
          contribute(catalog_.triangle_blocks[round * size + rank], *store, outgoing);
      });
      if (size == 1) continue;
      std::vector<Bytes> to_each(size);
      for (std::size_t r = 0; r < size; ++r) {
        const auto view = core::as_bytes(outgoing[r]);
        to_each[r].assign(view.begin(), view.end());
      }
      for (const Bytes& bytes : workspace_.ranks.exchange(std::move(to_each)))
        for (const Contribution& c :
             ByteReader(bytes).get_array<Contribution>(bytes.size() / sizeof(Contribution)))
          add(*store, c);
    }
  }

  void contribute(const TriangleBlockRef& block, const VertexStore& store,
                  std::vector<std::vector<Contribution>>& outgoing) {
    const Bytes bytes = workspace_.reader.read(block.record);
    for (const auto& t : ByteReader(bytes).get_array<mesh::Triangle>(block.count)) {
      const std::array<std::uint64_t, 3> v{block.first_vertex + t[0], block.first_vertex + t[1],
                                           block.first_vertex + t[2]};
      const auto& p = store[v[0]].position;
      const auto& q = store[v[1]].position;
      const auto& r = store[v[2]].position;
      const std::array<std::int64_t, 3> a{std::int64_t{q.x} - p.x, std::int64_t{q.y} - p.y,
                                          std::int64_t{q.z} - p.z};
      const std::array<std::int64_t, 3> b{std::int64_t{r.x} - p.x, std::int64_t{r.y} - p.y,
                                          std::int64_t{r.z} - p.z};
      const std::array<std::int64_t, 3> n{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                          a[0] * b[1] - a[1] * b[0]};
      for (const std::uint64_t vertex : v) {
        const std::size_t to = owner(store.find(vertex));
        if (to == static_cast<std::size_t>(workspace_.ranks.rank()))
          add(store, {vertex, n});
        else
          outgoing[to].push_back({vertex, n});
      }
    }
  }

  void add(const VertexStore& store, const Contribution& c) {
    const std::size_t block = store.find(c.vertex);
    sums_[block / static_cast<std::size_t>(workspace_.ranks.size())]
         [c.vertex - catalog_.vertex_blocks[block].first]
             .add(c.normal);
  }

  template <typename T>
  static std::vector<Bytes> to_bytes(const std::vector<std::vector<T>>& values) {
    std::vector<Bytes> bytes(values.size());
    for (std::size_t r = 0; r < values.size(); ++r) {
      const auto view = core::as_bytes(values[r]);
      bytes[r].assign(view.begin(), view.end());
    }
    return bytes;
  }

  // First only hashes of positions travel, to find which may be shared; then these vertices alone.
  void merge_positions() {
    const auto size = static_cast<std::size_t>(workspace_.ranks.size());
    std::vector<std::vector<std::uint64_t>> hashes(size);
    for_each_vertex([&](std::size_t, std::size_t, const Vertex& v) {
      const std::uint64_t hash = geometry::PointHash{}(v.position);
      hashes[hash % size].push_back(hash);
    });
    std::vector<Bytes> flags_back;
    {
      std::vector<std::vector<std::uint64_t>> received;
      std::vector<std::uint64_t> all;
      for (const Bytes& bytes : workspace_.ranks.exchange(to_bytes(hashes))) {
        received.push_back(ByteReader(bytes).get_array<std::uint64_t>(bytes.size() / 8));
        all.insert(all.end(), received.back().begin(), received.back().end());
      }
      hashes.clear();
      std::sort(all.begin(), all.end());
      std::vector<std::uint64_t> repeated;
      for (std::size_t i = 1; i < all.size(); ++i)
        if (all[i] == all[i - 1] && (repeated.empty() || repeated.back() != all[i]))
          repeated.push_back(all[i]);
      std::vector<std::vector<std::uint8_t>> flags(size);
      for (std::size_t r = 0; r < size; ++r)
        for (const std::uint64_t hash : received[r])
          flags[r].push_back(
              !repeated.empty() && std::binary_search(repeated.begin(), repeated.end(), hash) ? 1 : 0);
      flags_back = workspace_.ranks.exchange(to_bytes(flags));
    }
    std::vector<std::vector<SharedVertex>> outgoing(size);
    std::vector<std::vector<std::array<std::size_t, 2>>> senders(size);
    std::vector<std::size_t> cursor(size, 0);
    for_each_vertex([&](std::size_t block, std::size_t index, const Vertex& v) {
      const std::size_t to = geometry::PointHash{}(v.position) % size;
      if (std::to_integer<int>(flags_back[to][cursor[to]++]) == 0) return;
      outgoing[to].push_back(shared_vertex(block, index, v));
      senders[to].push_back({block, index});
    });
    std::vector<std::vector<SharedVertex>> arrived;
    for (const Bytes& bytes : workspace_.ranks.exchange(to_bytes(outgoing)))
      arrived.push_back(ByteReader(bytes).get_array<SharedVertex>(bytes.size() / sizeof(SharedVertex)));
    const auto answers = workspace_.ranks.exchange(to_bytes(merge(arrived)));
    for (std::size_t r = 0; r < size; ++r) {
      ByteReader reader(answers[r]);
      for (const auto& [block, index] : senders[r]) {
        const auto merged = reader.get<MergedAttributes>();
        mine_[block][index].normal = merged.normal;
        mine_[block][index].color = merged.color;
      }
    }
  }

  template <typename Visit>
  void for_each_vertex(const Visit& visit) {
    for (std::size_t block = 0; block < mine_.size(); ++block)
      for (std::size_t index = 0; index < mine_[block].size(); ++index)
        visit(block, index, mine_[block][index]);
  }

  SharedVertex shared_vertex(std::size_t block, std::size_t index, const Vertex& v) const {
    SharedVertex shared{v.position, v.normal, v.color, {}};
    if (!sums_[block].empty())
      for (std::size_t i = 0; i < 3; ++i) {
        const auto value = static_cast<unsigned __int128>(sums_[block][index].sum[i]);
        shared.computed[2 * i] = static_cast<std::uint64_t>(value);
        shared.computed[2 * i + 1] = static_cast<std::uint64_t>(value >> 64);
      }
    return shared;
  }

  // Normals that were read are summed, else the computed ones; colours are averaged. No sum depends on the
  // order.
  std::vector<std::vector<MergedAttributes>> merge(const std::vector<std::vector<SharedVertex>>& arrived) {
    struct Entry {
      const SharedVertex* vertex;
      std::array<std::size_t, 2> slot;
    };
    std::vector<Entry> entries;
    std::vector<std::vector<MergedAttributes>> answers(arrived.size());
    for (std::size_t r = 0; r < arrived.size(); ++r) {
      answers[r].resize(arrived[r].size());
      for (std::size_t i = 0; i < arrived[r].size(); ++i) entries.push_back({&arrived[r][i], {r, i}});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.vertex->position != b.vertex->position ? a.vertex->position < b.vertex->position
                                                      : a.slot < b.slot;
    });
    for (std::size_t i = 0; i < entries.size();) {
      std::size_t end = i;
      WideNormal read;
      WideNormal computed;
      std::array<std::uint64_t, 4> color{};
      bool differed = false;
      for (; end < entries.size() && entries[end].vertex->position == entries[i].vertex->position; ++end) {
        const SharedVertex& v = *entries[end].vertex;
        read.add({v.normal[0], v.normal[1], v.normal[2]});
        for (std::size_t k = 0; k < 3; ++k)
          computed.sum[k] += static_cast<Wide>(static_cast<unsigned __int128>(v.computed[2 * k + 1]) << 64 |
                                               v.computed[2 * k]);
        for (std::size_t k = 0; k < 4; ++k) color[k] += v.color[k];
        differed |= v.normal != entries[i].vertex->normal || v.color != entries[i].vertex->color;
      }
      const std::uint64_t count = end - i;
      const bool was_read = read.sum[0] != 0 || read.sum[1] != 0 || read.sum[2] != 0;
      MergedAttributes merged{};
      merged.normal = was_read ? normal_of(read) : normal_of(computed);
      for (std::size_t k = 0; k < 4; ++k)
        merged.color[k] = static_cast<std::uint8_t>((2 * color[k] + count) / (2 * count));
      for (std::size_t k = i; k < end; ++k) answers[entries[k].slot[0]][entries[k].slot[1]] = merged;
      merged_vertices_ += count - 1;
      attribute_seams_ += differed ? 1 : 0;
      i = end;
    }
    return answers;
  }

  void store() {
    workspace_.ranks.attempt([&] {
      std::size_t k = 0;
      for_my_share(workspace_.ranks, catalog_.vertex_blocks.size(), [&](std::size_t i) {
        for (std::size_t v = 0; v < mine_[k].size(); ++v)
          if (is_unknown(mine_[k][v].normal))
            mine_[k][v].normal = normal_of(sums_[k].empty() ? WideNormal{} : sums_[k][v]);
        catalog_.vertex_blocks[i].record = workspace_.writer.append(
            static_cast<std::uint32_t>(RecordKind::kFinalVertices), core::as_bytes(mine_[k]));
        ++k;
      });
    });
    share_records();
  }

  const Workspace& workspace_;
  Catalog& catalog_;
  std::vector<std::vector<Vertex>> mine_;      // of the blocks that this rank owns
  std::vector<std::vector<WideNormal>> sums_;  // parallel, or empty where nothing is to be computed
  bool has_unknown_normals_ = false;
  std::uint64_t merged_vertices_ = 0;
  std::uint64_t attribute_seams_ = 0;
};

}  // namespace

void place_on_lattice(const Workspace& workspace, Catalog& catalog) {
  LatticePlacement(workspace, catalog).run();
}

void round_positions(const Workspace& workspace, Catalog& catalog, std::int32_t spacing) {
  LatticePlacement(workspace, catalog).round(spacing);
}

}  // namespace colossus::build
