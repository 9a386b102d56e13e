#include "verify/diamonds/faces.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <tuple>

#include "codec/coded/places.hpp"
#include "core/bytes.hpp"
#include "core/error.hpp"

namespace colossus::verify::diamonds {
namespace {

using hierarchy::Diamond;
using hierarchy::Point;
using hierarchy::Tetrahedron;

DirectedEdge reversed(const DirectedEdge& edge) { return {edge.to, edge.from}; }

// A directed edge of the mesh by vertex index.
struct IndexEdge {
  std::uint64_t key;  // lesser end, greater end
  bool is_forward;
};

std::array<Point, 3> face_corners(const Tetrahedron& t, std::size_t opposite) {
  std::array<Point, 3> corners;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (i != opposite) corners[count++] = t.corners[i];
  return corners;
}

// The same for all tetrahedra on one side of the face.
std::uint8_t side_of_face(const Tetrahedron& t, std::size_t opposite) {
  const geometry::Plane plane = t.face_plane(static_cast<int>(opposite));
  for (const auto component : plane.normal)
    if (component != 0) return component > 0 ? 1 : 0;
  return 0;
}

Chain in_canonical_direction(Chain chain, std::uint8_t side) {
  if (side == 1) {
    for (DirectedEdge& edge : chain) edge = reversed(edge);
    std::sort(chain.begin(), chain.end());
  }
  return chain;
}

core::Hash128 hash_of(const Chain& chain) {
  if (chain.empty()) return {};
  return core::hash128(core::as_bytes(chain));
}

FaceEntry face_entry(const Tetrahedron& t, std::size_t corner, const Chain& chain) {
  const auto corners = face_corners(t, corner);
  FaceEntry entry;
  entry.face = core::hash128(std::as_bytes(std::span(corners)));
  entry.side = side_of_face(t, corner);
  entry.polyline = hash_of(in_canonical_direction(chain, entry.side));
  entry.corner = static_cast<std::uint8_t>(corner);
  return entry;
}

bool contains_edge(const Tetrahedron& t, const std::array<Point, 2>& ends) {
  const auto has = [&](const Point& p) {
    return std::find(t.corners.begin(), t.corners.end(), p) != t.corners.end();
  };
  return has(ends[0]) && has(ends[1]);
}

Tetrahedron tetrahedron_at(const reader::diamonds::Statue& statue, reader::diamonds::TetrahedronRef ref) {
  return Diamond::at(statue.center(ref.row)).tetrahedra[ref.place];
}

std::string text(const codec::coded::ScaledPosition& p, int bits) {
  const double scale = 1.0 / static_cast<double>(std::int64_t{1} << bits);
  return fmt::format("({} {} {})", static_cast<double>(p[0]) * scale, static_cast<double>(p[1]) * scale,
                     static_cast<double>(p[2]) * scale);
}

std::string text(const Point& p) { return fmt::format("({} {} {})", p.x, p.y, p.z); }

std::string text(const reader::diamonds::Statue& statue, reader::diamonds::TetrahedronRef ref) {
  return fmt::format("place {} of the node at {}", ref.place, statue.name(ref.row));
}

// The chain of an entry, decoded again.
Chain decoded_chain(const reader::diamonds::Statue& statue, const FaceEntry& entry) {
  if (entry.state != FaceState::kKnown) return {};
  const auto node = statue.node(entry.tetrahedron.row);
  for (const auto& part : node->mesh.parts)
    if (part.place == entry.tetrahedron.place) {
      const auto chains = boundary_chains(part, node->diamond.tetrahedra[part.place]);
      return in_canonical_direction(chains.faces[entry.corner], entry.side);
    }
  return {};
}

std::string text(const reader::diamonds::Statue& statue, const FaceEntry& entry) {
  std::string who = text(statue, entry.tetrahedron);
  return entry.state == FaceState::kRowless ? "a half without node of " + who : who;
}

std::string describe_mismatch(const reader::diamonds::Statue& statue, const FaceEntry& a,
                              const FaceEntry& b) {
  const auto corners = face_corners(tetrahedron_at(statue, a.tetrahedron), a.corner);
  const Chain chain_a = decoded_chain(statue, a);
  const Chain chain_b = decoded_chain(statue, b);
  std::string example = fmt::format("face {} {} {}: {} edges from {} ({} side), {} edges from {} ({} side)",
                                    text(corners[0]), text(corners[1]), text(corners[2]), chain_a.size(),
                                    text(statue, a), a.side != 0 ? "upper" : "lower", chain_b.size(),
                                    text(statue, b), b.side != 0 ? "upper" : "lower");
  std::vector<DirectedEdge> difference;
  std::set_symmetric_difference(chain_a.begin(), chain_a.end(), chain_b.begin(), chain_b.end(),
                                std::back_inserter(difference));
  if (!difference.empty()) {
    const int bits = statue.metadata().position_bits;
    const bool in_first = std::binary_search(chain_a.begin(), chain_a.end(), difference.front());
    example += fmt::format("; first edge of only the {}: {} to {}", in_first ? "former" : "latter",
                           text(difference.front().from, bits), text(difference.front().to, bits));
  }
  return example;
}

bool is_nonempty(const FaceEntry& entry) { return entry.polyline != core::Hash128{}; }

// The groups of entries around one edge of the hierarchy.
class EdgeChecker {
 public:
  EdgeChecker(const reader::diamonds::Statue& statue, std::span<const EdgeEntry> group)
      : statue_(statue), ends_(group.front().edge.ends) {
    for (const EdgeEntry& entry : group) chains_[entry.tetrahedron] = &entry.edge.chain;
  }

  // What is wrong, or nothing.
  std::string check() const {
    std::set<reader::diamonds::TetrahedronRef> to_add_up;
    Chain terminal;
    for (const auto& [ref, chain] : chains_) {
      if (is_terminal(ref))
        terminal.insert(terminal.end(), chain->begin(), chain->end());
      else
        to_add_up.insert(ref);
      if (const reader::diamonds::TetrahedronRef parent = statue_.parent(ref);
          parent.exists() && contains_edge(tetrahedron_at(statue_, parent), ends_))
        to_add_up.insert(parent);
    }
    if (const Chain rest = normalized(terminal); !rest.empty())
      return fmt::format("the surfaces around it leave {} edges open, the first {} to {}", rest.size(),
                         text(rest.front().from, bits()), text(rest.front().to, bits()));
    for (const reader::diamonds::TetrahedronRef ref : to_add_up)
      if (!is_sum_of_halves(ref))
        return fmt::format("{} differs from its halves along it", text(statue_, ref));
    return {};
  }

 private:
  int bits() const { return statue_.metadata().position_bits; }
  // Leaves, and tetrahedra whose long edge this is.
  bool is_terminal(reader::diamonds::TetrahedronRef ref) const {
    return statue_.is_leaf(ref.row) || geometry::midpoint(ends_[0], ends_[1]) == statue_.center(ref.row);
  }
  bool is_sum_of_halves(reader::diamonds::TetrahedronRef ref) const {
    const Tetrahedron t = tetrahedron_at(statue_, ref);
    Chain sum;
    if (const auto own = chains_.find(ref); own != chains_.end())
      for (const DirectedEdge& edge : *own->second) sum.push_back(reversed(edge));
    for (int end = 0; end < 2; ++end) {
      const reader::diamonds::TetrahedronRef half = statue_.child(ref, end);
      if (!half.exists() || !contains_edge(t.child(end), ends_)) continue;
      if (const auto found = chains_.find(half); found != chains_.end())
        sum.insert(sum.end(), found->second->begin(), found->second->end());
    }
    return normalized(sum).empty();
  }

  const reader::diamonds::Statue& statue_;
  std::array<Point, 2> ends_;
  std::map<reader::diamonds::TetrahedronRef, const Chain*> chains_;
};

}  // namespace

Chain normalized(Chain chain) {
  std::erase_if(chain, [](const DirectedEdge& edge) { return edge.from == edge.to; });
  const auto undirected = [](const DirectedEdge& edge) {
    return edge.from < edge.to ? edge : reversed(edge);
  };
  std::sort(chain.begin(), chain.end(),
            [&](const DirectedEdge& a, const DirectedEdge& b) { return undirected(a) < undirected(b); });
  Chain kept;
  for (std::size_t i = 0; i < chain.size();) {
    const DirectedEdge edge = undirected(chain[i]);
    std::ptrdiff_t net = 0;
    for (; i < chain.size() && undirected(chain[i]) == edge; ++i) net += chain[i] == edge ? 1 : -1;
    kept.insert(kept.end(), static_cast<std::size_t>(net < 0 ? -net : net), net < 0 ? reversed(edge) : edge);
  }
  std::sort(kept.begin(), kept.end());
  return kept;
}

BoundaryChains boundary_chains(const codec::coded::CodedPart& part, const Tetrahedron& tetrahedron) {
  std::vector<IndexEdge> edges;
  for (const mesh::Triangle& t : part.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k];
      const std::uint64_t b = t[(k + 1) % 3];
      // Also the edges that merely lie in a face.
      if (!codec::coded::share_face(part.positions[a], part.positions[b])) continue;
      edges.push_back({std::min(a, b) << 32 | std::max(a, b), a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const IndexEdge& a, const IndexEdge& b) { return a.key < b.key; });
  BoundaryChains chains;
  std::map<std::uint8_t, Chain> along_edges;
  for (std::size_t i = 0; i < edges.size();) {
    const std::uint64_t key = edges[i].key;
    std::ptrdiff_t net = 0;
    for (; i < edges.size() && edges[i].key == key; ++i) net += edges[i].is_forward ? 1 : -1;
    if (net == 0) continue;
    const auto a = static_cast<std::size_t>(key >> 32);
    const auto b = static_cast<std::size_t>(key & 0xffffffffU);
    const auto common = static_cast<std::uint8_t>(codec::coded::marks_of(part.positions[a]) &
                                                  codec::coded::marks_of(part.positions[b]));
    DirectedEdge edge{codec::coded::scaled_position(part.positions[a], tetrahedron),
                      codec::coded::scaled_position(part.positions[b], tetrahedron)};
    if (net < 0) edge = reversed(edge);
    const auto times = static_cast<std::size_t>(net < 0 ? -net : net);
    Chain& chain = std::popcount(common) == 1
                       ? chains.faces[static_cast<std::size_t>(std::countr_zero(common))]
                       : along_edges[common];
    chain.insert(chain.end(), times, edge);
  }
  for (Chain& face : chains.faces) face = normalized(std::move(face));
  for (auto& [faces, chain] : along_edges) {
    EdgeChain found{{}, normalized(std::move(chain))};
    // Three common faces meet in a point, where nothing has a length.
    if (found.chain.empty() || std::popcount(faces) != 2) continue;
    std::size_t count = 0;
    for (std::size_t corner = 0; corner < 4; ++corner)
      if ((faces >> corner & 1) == 0) found.ends[count++] = tetrahedron.corners[corner];
    chains.edges.push_back(std::move(found));
  }
  return chains;
}

NodeBoundary node_boundary(const reader::diamonds::Statue& statue, reader::access::RowIndex row,
                           const Diamond& diamond,
                           const std::array<const BoundaryChains*, reader::diamonds::kMaxPlaces>& chains,
                           bool is_damaged) {
  NodeBoundary boundary;
  for (std::uint8_t place = 0; place < diamond.place_count; ++place) {
    const reader::diamonds::TetrahedronRef ref{row, place};
    if (!diamond.is_inside[place] || !statue.exists(ref)) continue;
    const Tetrahedron& t = diamond.tetrahedra[place];
    for (std::size_t corner = 0; corner < 4; ++corner) {
      boundary.faces.push_back(face_entry(t, corner, chains[place] ? chains[place]->faces[corner] : Chain{}));
      boundary.faces.back().tetrahedron = ref;
      if (is_damaged) boundary.faces.back().state = FaceState::kUnknown;
    }
    if (chains[place])
      for (const EdgeChain& edge : chains[place]->edges) boundary.edges.push_back({ref, edge});
    if (is_damaged && statue.has_geometry(ref))
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = a + 1; b < 4; ++b)
          boundary.edges.push_back({ref, {{t.corners[a], t.corners[b]}, {}}, FaceState::kUnknown});
    if (statue.is_leaf(row) || diamond.level >= hierarchy::kMaxLevel) continue;
    for (int end = 0; end < 2; ++end) {
      if (statue.child(ref, end).exists()) continue;
      const Tetrahedron half = t.child(end);
      for (std::size_t corner = 0; corner < 4; ++corner) {
        FaceEntry entry = face_entry(half, corner, {});
        entry.tetrahedron = ref;
        entry.state = FaceState::kRowless;
        boundary.faces.push_back(entry);
      }
    }
  }
  return boundary;
}

BoundaryReport check_faces(const reader::diamonds::Statue& statue, std::vector<FaceEntry>& entries,
                           std::size_t most_examples) {
  std::sort(entries.begin(), entries.end(), [](const FaceEntry& a, const FaceEntry& b) {
    return std::tie(a.face, a.state, a.tetrahedron, a.corner) <
           std::tie(b.face, b.state, b.tetrahedron, b.corner);
  });
  BoundaryReport report;
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin;
    while (end < entries.size() && entries[end].face == entries[begin].face) ++end;
    const std::span<const FaceEntry> group(&entries[begin], end - begin);
    begin = end;
    ++report.faces;
    const auto first = std::find_if(group.begin(), group.end(), is_nonempty);
    if (first == group.end()) continue;
    ++report.nonempty_faces;
    const auto other = std::find_if(group.begin(), group.end(), [&](const FaceEntry& entry) {
      return entry.state != FaceState::kUnknown && entry.polyline != first->polyline;
    });
    const bool has_both_sides = std::any_of(
        group.begin(), group.end(), [&](const FaceEntry& entry) { return entry.side != first->side; });
    if (other == group.end() && has_both_sides) continue;
    ++report.mismatches;
    if (report.examples.size() >= most_examples) continue;
    if (other != group.end()) {
      report.examples.push_back(describe_mismatch(statue, *first, *other));
    } else {
      const auto corners = face_corners(tetrahedron_at(statue, first->tetrahedron), first->corner);
      report.examples.push_back(fmt::format("face {} {} {}: {} edges from {}, and nothing on its other side",
                                            text(corners[0]), text(corners[1]), text(corners[2]),
                                            decoded_chain(statue, *first).size(), text(statue, *first)));
    }
  }
  return report;
}

BoundaryReport check_edges(const reader::diamonds::Statue& statue, std::vector<EdgeEntry>& entries,
                           std::size_t most_examples) {
  std::sort(entries.begin(), entries.end(), [](const EdgeEntry& a, const EdgeEntry& b) {
    return std::tie(a.edge.ends, a.tetrahedron) < std::tie(b.edge.ends, b.tetrahedron);
  });
  BoundaryReport report;
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin;
    while (end < entries.size() && entries[end].edge.ends == entries[begin].edge.ends) ++end;
    const std::span<const EdgeEntry> group(&entries[begin], end - begin);
    begin = end;
    if (std::any_of(group.begin(), group.end(),
                    [](const EdgeEntry& entry) { return entry.state == FaceState::kUnknown; }))
      continue;
    ++report.faces;
    ++report.nonempty_faces;
    const std::string wrong = EdgeChecker(statue, group).check();
    if (wrong.empty()) continue;
    ++report.mismatches;
    if (report.examples.size() < most_examples)
      report.examples.push_back(fmt::format("edge {} {}: {}", text(group.front().edge.ends[0]),
                                            text(group.front().edge.ends[1]), wrong));
  }
  return report;
}

}  // namespace colossus::verify::diamonds
