#include "codec/predict/predict.hpp"

#include "codec/predict/colors.hpp"
#include "codec/predict/connectivity.hpp"
#include "codec/predict/normals.hpp"
#include "codec/predict/parents.hpp"
#include "codec/predict/positions.hpp"

namespace colossus::codec {
namespace {

using core::Defect;
using namespace predict;

constexpr std::size_t index_of(Component component) { return static_cast<std::size_t>(component); }

}  // namespace

Sections encode_predicted(const CodedNode& node) {
  BitEncoder bits;
  SymbolModel symbols;
  FaceModel faces;
  ValueEncoder positions(kPositionContexts);
  ValueEncoder normals(kNormalContexts);
  ValueEncoder colors(kColorContexts);
  ValueEncoder parents(kParentContexts);
  std::vector<LinkStore> stores;
  std::vector<Links> links;
  for (const CodedPart& part : node.parts) {
    const std::size_t count = part.positions.size();
    encode_connectivity(bits, symbols, part, stores.emplace_back(count).links(count));
    links.push_back(stores.back().finish(count));
    encode_positions(bits, faces, positions, basis_of(part.frame), links.back(), node, part);
    if (node.has_colors) encode_colors(colors, links.back(), part);
    if (node.has_parents) encode_parents(parents, links.back(), part);
  }
  Sections sections;
  if (node.has_normals) {
    const NormalMode mode = choose_normal_mode(node, links);
    for (std::size_t i = 0; i < node.parts.size(); ++i)
      encode_normals(normals, mode, links[i], node, node.parts[i]);
    sections[index_of(Component::kNormals)] = normals.finish();
    sections[index_of(Component::kNormals)].push_back(static_cast<std::byte>(mode));
  }
  sections[index_of(Component::kConnectivity)] = bits.finish();
  sections[index_of(Component::kPositions)] = positions.finish();
  sections[index_of(Component::kColors)] = colors.finish();
  sections[index_of(Component::kParents)] = parents.finish();
  return sections;
}

std::optional<Defect> decode_predicted(const SectionViews& sections, CodedNode& node) {
  const auto section = [&](Component component) { return sections[index_of(component)]; };
  BitDecoder bits(section(Component::kConnectivity));
  SymbolModel symbols;
  FaceModel faces;
  ValueDecoder positions(section(Component::kPositions), kPositionContexts);
  auto normal_bytes = section(Component::kNormals);
  auto mode = NormalMode::kSum;
  if (node.has_normals) {
    if (normal_bytes.empty() || std::to_integer<std::uint8_t>(normal_bytes.back()) >= kNormalModes)
      return Defect{"the normals' mode is unknown", 0};
    mode = static_cast<NormalMode>(normal_bytes.back());
    normal_bytes = normal_bytes.first(normal_bytes.size() - 1);
  }
  ValueDecoder normals(normal_bytes, node.has_normals ? kNormalContexts : 0);
  ValueDecoder colors(section(Component::kColors), node.has_colors ? kColorContexts : 0);
  ValueDecoder parents(section(Component::kParents), node.has_parents ? kParentContexts : 0);
  std::size_t most = 0;
  for (const CodedPart& part : node.parts) most = std::max(most, part.positions.size());
  LinkStore store(most);
  for (CodedPart& part : node.parts) {
    const std::size_t count = part.positions.size();
    if (!decode_connectivity(bits, symbols, part, store.links(count)))
      return Defect{"the connectivity makes no sense", 0};
    const Links links = store.finish(count);
    decode_positions(bits, faces, positions, basis_of(part.frame), links, node, part);
    if (node.has_normals) decode_normals(normals, mode, links, node, part);
    if (node.has_colors) decode_colors(colors, links, part);
    if (node.has_parents) decode_parents(parents, links, part);
  }
  if (!positions.is_done()) return Defect{"the positions are not as long as they should be", 0};
  if (!normals.is_done()) return Defect{"the normals are not as long as they should be", 0};
  if (!colors.is_done()) return Defect{"the colours are not as long as they should be", 0};
  if (!parents.is_done()) return Defect{"the parents are not as long as they should be", 0};
  return std::nullopt;
}

}  // namespace colossus::codec
