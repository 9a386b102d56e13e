#include "codec/predict/predict.hpp"

#include "codec/predict/adaptive_connectivity.hpp"
#include "codec/predict/colors.hpp"
#include "codec/predict/connectivity.hpp"
#include "codec/predict/normals.hpp"
#include "codec/predict/parents.hpp"
#include "codec/predict/positions.hpp"

namespace colossus::codec::predict {
namespace {

using core::Defect;
using namespace predict;

constexpr std::size_t index_of(coded::Component component) { return static_cast<std::size_t>(component); }

// Versions differ in their connectivity, in how tables are written, and in the first vertex's colour.
template <typename Connectivity>
std::optional<Defect> decode_sections(const coded::SectionViews& sections, coded::CodedNode& node,
                                      TableLayout layout, const mesh::Color& first_color) {
  const auto section = [&](coded::Component component) { return sections[index_of(component)]; };
  std::size_t triangle_count = 0;
  std::size_t most_vertices = 0;
  for (const coded::CodedPart& part : node.parts) {
    triangle_count += part.triangles.size();
    most_vertices = std::max(most_vertices, part.positions.size());
  }
  Connectivity connectivity(section(coded::Component::kConnectivity), triangle_count);
  FaceModel faces;
  ValueDecoder positions(section(coded::Component::kPositions), kPositionContexts, layout);
  auto normal_bytes = section(coded::Component::kNormals);
  auto mode = NormalMode::kSum;
  if (node.has_normals) {
    if (normal_bytes.empty() || std::to_integer<std::uint8_t>(normal_bytes.back()) >= kNormalModes)
      return Defect{"the normals' mode is unknown", 0};
    mode = static_cast<NormalMode>(normal_bytes.back());
    normal_bytes = normal_bytes.first(normal_bytes.size() - 1);
  }
  ValueDecoder normals(normal_bytes, node.has_normals ? kNormalContexts : 0, layout);
  ValueDecoder colors(section(coded::Component::kColors), node.has_colors ? kColorContexts : 0, layout);
  ValueDecoder parents(section(coded::Component::kParents), node.has_parents ? kParentContexts : 0, layout);
  LinkStore store(most_vertices);
  for (coded::CodedPart& part : node.parts) {
    if (!connectivity.decode(part, store)) return Defect{"the connectivity makes no sense", 0};
    const Links links = store.first(part.positions.size());
    decode_positions(connectivity.bits(), faces, positions, basis_of(part.frame), links, node, part);
    if (node.has_normals) decode_normals(normals, mode, links, node, part);
    if (node.has_colors) decode_colors(colors, links, part, first_color);
    if (node.has_parents) decode_parents(parents, links, part);
  }
  if (!connectivity.is_done()) return Defect{"the connectivity is not as long as it should be", 0};
  if (!positions.is_done()) return Defect{"the positions are not as long as they should be", 0};
  if (!normals.is_done()) return Defect{"the normals are not as long as they should be", 0};
  if (!colors.is_done()) return Defect{"the colours are not as long as they should be", 0};
  if (!parents.is_done()) return Defect{"the parents are not as long as they should be", 0};
  return std::nullopt;
}

}  // namespace

coded::Sections encode_predicted(const coded::CodedNode& node) {
  ConnectivityEncoder connectivity;
  FaceModel faces;
  ValueEncoder positions(kPositionContexts);
  ValueEncoder normals(kNormalContexts);
  ValueEncoder colors(kColorContexts);
  ValueEncoder parents(kParentContexts);
  std::vector<LinkStore> stores;
  std::vector<Links> links;
  for (const coded::CodedPart& part : node.parts) {
    const std::size_t count = part.positions.size();
    connectivity.encode(part, stores.emplace_back(count));
    links.push_back(stores.back().first(count));
    encode_positions(connectivity.bits(), faces, positions, basis_of(part.frame), links.back(), node, part);
    if (node.has_colors) encode_colors(colors, links.back(), part);
    if (node.has_parents) encode_parents(parents, links.back(), part);
  }
  coded::Sections sections;
  if (node.has_normals) {
    const NormalMode mode = choose_normal_mode(node, links);
    for (std::size_t i = 0; i < node.parts.size(); ++i)
      encode_normals(normals, mode, links[i], node, node.parts[i]);
    sections[index_of(coded::Component::kNormals)] = normals.finish();
    sections[index_of(coded::Component::kNormals)].push_back(static_cast<std::byte>(mode));
  }
  sections[index_of(coded::Component::kConnectivity)] = connectivity.finish();
  sections[index_of(coded::Component::kPositions)] = positions.finish();
  sections[index_of(coded::Component::kColors)] = colors.finish();
  sections[index_of(coded::Component::kParents)] = parents.finish();
  return sections;
}

std::optional<Defect> decode_predicted(const coded::SectionViews& sections, coded::CodedNode& node) {
  return decode_sections<ConnectivityDecoder>(sections, node, TableLayout::kRuns, kOpaqueBlack);
}

std::optional<Defect> decode_predicted_1(const coded::SectionViews& sections, coded::CodedNode& node) {
  return decode_sections<AdaptiveConnectivityDecoder>(sections, node, TableLayout::kEach, kTransparentBlack);
}

}  // namespace colossus::codec::predict
