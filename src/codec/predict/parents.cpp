#include "codec/predict/parents.hpp"

namespace colossus::codec::predict {
namespace {

// A choice of 0 to 3 is the parent of that neighbour; else a difference to the first one's follows.
constexpr std::uint32_t kOther = kMostNeighbors;
constexpr std::uint32_t kChoice = 0;  // by the number of neighbours
constexpr std::uint32_t kDifference = 2;

std::uint32_t choice_context(std::uint8_t kind) { return kChoice + (neighbors_of(kind) > 2 ? 1U : 0U); }

std::uint32_t base_of(const Links& links, const std::vector<std::uint32_t>& parents, std::size_t v) {
  if (neighbors_of(links.kinds[v]) > 0) return parents[links.of[v].neighbors[0]];
  return v > 0 ? parents[v - 1] : 0;
}

}  // namespace

void encode_parents(ValueEncoder& values, const Links& links, const coded::CodedPart& part) {
  const std::size_t count = part.parents.size();
  std::vector<std::uint32_t> differences;
  for (std::size_t v = 0; v < count; ++v) {
    std::uint32_t choice = kOther;
    for (std::uint32_t i = neighbors_of(links.kinds[v]); i-- > 0;)
      if (part.parents[links.of[v].neighbors[i]] == part.parents[v]) choice = i;
    values.put(choice_context(links.kinds[v]), choice);
    if (choice == kOther)
      differences.push_back(
          to_unsigned(static_cast<std::int32_t>(part.parents[v] - base_of(links, part.parents, v))));
  }
  values.end_batch();
  for (const std::uint32_t difference : differences) values.put(kDifference, difference);
  values.end_batch();
}

void decode_parents(ValueDecoder& values, const Links& links, coded::CodedPart& part) {
  const std::size_t count = part.parents.size();
  std::vector<std::uint32_t> choices(count);
  values.get_batch(choices, [&](std::size_t v) { return choice_context(links.kinds[v]); });
  std::size_t others = 0;
  for (std::size_t v = 0; v < count; ++v) others += choices[v] >= neighbors_of(links.kinds[v]) ? 1 : 0;
  std::vector<std::uint32_t> differences(others);
  values.get_batch(differences, [](std::size_t) { return kDifference; });
  std::size_t next = 0;
  for (std::size_t v = 0; v < count; ++v)
    part.parents[v] =
        choices[v] < neighbors_of(links.kinds[v])
            ? part.parents[links.of[v].neighbors[choices[v]]]
            : base_of(links, part.parents, v) + static_cast<std::uint32_t>(to_signed(differences[next++]));
}

}  // namespace colossus::codec::predict
