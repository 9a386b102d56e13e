#include "codec/coded/renumber.hpp"

namespace colossus::codec::coded {

std::vector<std::uint32_t> renumber_by_first_use(std::vector<mesh::Triangle>& triangles,
                                                 std::size_t vertex_count) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> numbers(vertex_count, kNone);
  std::vector<std::uint32_t> before;
  before.reserve(vertex_count);
  const auto number_of = [&](std::uint32_t v) {
    if (numbers[v] == kNone) {
      numbers[v] = static_cast<std::uint32_t>(before.size());
      before.push_back(v);
    }
    return numbers[v];
  };
  for (mesh::Triangle& t : triangles)
    for (auto& v : t) v = number_of(v);
  for (std::uint32_t v = 0; v < vertex_count; ++v) number_of(v);
  return before;
}

}  // namespace colossus::codec::coded
