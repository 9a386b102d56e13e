// The four tables with a line more in each: they take the place of pipeline/schemes.cpp, reader/schemes.cpp,
// verify/schemes.cpp and input/formats.cpp, which a linker takes from the libraries only where nobody else
// has them. Everything else is the program's own.
#include "toy/tables.hpp"

#include <array>

#include "pipeline/blocks/scheme.hpp"
#include "pipeline/diamonds/scheme.hpp"
#include "pipeline/schemes.hpp"
#include "reader/blocks/statue.hpp"
#include "reader/diamonds/statue.hpp"
#include "reader/open.hpp"
#include "toy/sketch.hpp"
#include "toy/sketch_reader.hpp"
#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"
#include "verify/verify.hpp"

namespace colossus {

std::span<const pipeline::nodes::Scheme* const> pipeline::schemes() {
  static constexpr std::array<const nodes::Scheme*, 3> kSchemes{&diamonds::kScheme, &blocks::kScheme,
                                                                &toy::kSketchScheme};
  return kSchemes;
}

namespace {
template <typename Statue>
std::unique_ptr<reader::access::Statue> open_as(container::ContainerReader container,
                                                const reader::access::StatueOptions& options) {
  return std::make_unique<Statue>(std::move(container), options);
}
}  // namespace

std::span<const reader::Scheme> reader::schemes() {
  static constexpr std::array<Scheme, 3> kSchemes{{{hierarchy::kDiamonds, &open_as<diamonds::Statue>},
                                                   {hierarchy::kBlocks, &open_as<blocks::Statue>},
                                                   {toy::kSketch, &open_as<toy::Statue>}}};
  return kSchemes;
}

std::span<const verify::Scheme> verify::schemes() {
  using reader::access::Statue;
  static constexpr std::array<Scheme, 3> kSchemes{
      {{hierarchy::kDiamonds,
        [](const Statue& statue, const measure::VerifyOptions& options) {
          return diamonds::verify(dynamic_cast<const reader::diamonds::Statue&>(statue), options);
        }},
       {hierarchy::kBlocks,
        [](const Statue& statue, const measure::VerifyOptions& options) {
          return blocks::verify(dynamic_cast<const reader::blocks::Statue&>(statue), options);
        }},
       {toy::kSketch, &toy::verify}}};
  return kSchemes;
}

std::span<const input::Format* const> input::formats() {
  static constexpr std::array<const Format*, 5> kFormats{&kPlyFormat, &kObjFormat, &kStlFormat, &kOffFormat,
                                                         &toy::kTrisFormat};
  return kFormats;
}

}  // namespace colossus
