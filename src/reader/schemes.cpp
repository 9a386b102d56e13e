#include <array>

#include "reader/blocks/statue.hpp"
#include "reader/diamonds/statue.hpp"
#include "reader/open.hpp"

namespace colossus::reader {
namespace {

template <typename Statue>
std::unique_ptr<access::Statue> open_as(container::ContainerReader container,
                                        const access::StatueOptions& options) {
  return std::make_unique<Statue>(std::move(container), options);
}

}  // namespace

// In a file of its own: a program with schemes of its own brings its own table (tests/toy).
std::span<const Scheme> schemes() {
  static constexpr std::array<Scheme, 2> kSchemes{
      {{hierarchy::kDiamonds, &open_as<diamonds::Statue>}, {hierarchy::kBlocks, &open_as<blocks::Statue>}}};
  return kSchemes;
}

}  // namespace colossus::reader
