// What is estimated of a container comes from its codec's own measurements.
#include <gtest/gtest.h>

#include "codec/codec.hpp"
#include "hierarchy/diamond.hpp"
#include "hierarchy/octree.hpp"
#include "pipeline/estimate.hpp"

namespace colossus::pipeline {
namespace {

constexpr double kTriangles = 1e6;

double estimated_output(const facts::BuildOptions& options, bool has_colors) {
  facts::Catalog catalog;
  catalog.counts.triangles = static_cast<std::uint64_t>(kTriangles);
  catalog.counts.vertices = catalog.counts.triangles / 2;
  catalog.input_block_vertices = catalog.counts.triangles;
  catalog.has_colors = has_colors;
  const ingest::Occupancy occupancy{{{{1, 2, 3}, 0, static_cast<std::uint32_t>(kTriangles / 2)}}};
  return static_cast<double>(estimate(options, catalog, occupancy, 0).output_bytes);
}

facts::BuildOptions options_for(const std::string& scheme, const codec::Codec& codec,
                                int position_bits = 12) {
  facts::BuildOptions options;
  options.scheme = scheme;
  options.codec = codec.name;
  options.position_bits = position_bits;
  return options;
}

class EstimateOfCodecs : public testing::TestWithParam<const char*> {
 protected:
  double output(const codec::Codec& codec, bool has_colors = true, int position_bits = 12) const {
    return estimated_output(options_for(GetParam(), codec, position_bits), has_colors);
  }
};

TEST_P(EstimateOfCodecs, TakesWhatTheCodecSays) {
  const codec::Codec& first = codec::codecs().front();
  // The same number of triangles is stored by all: colours show how many.
  const double stored = (output(first) - output(first, false)) / first.measured.color;
  ASSERT_GT(stored, kTriangles);
  const double within = 1e-5 * output(first);  // estimates are whole bytes
  for (const codec::Codec& codec : codec::codecs()) {
    SCOPED_TRACE(codec.name);
    const codec::MeasuredBytes& bytes = codec.measured;
    EXPECT_NEAR(output(codec) - output(first), stored * (bytes.triangle - first.measured.triangle), within);
    EXPECT_NEAR(output(codec) - output(codec, false), stored * bytes.color, within);
    EXPECT_NEAR(output(codec, true, 14) - output(codec), stored * 2 * bytes.finer_bit, within);
    EXPECT_NEAR(output(codec) - output(codec, true, 9), stored * 3 * bytes.coarser_bit, within);
  }
}

TEST_P(EstimateOfCodecs, RefusesACodecThatNobodyHasMeasured) {
  facts::BuildOptions options;
  options.scheme = GetParam();
  options.codec = "none";
  EXPECT_THROW(estimated_output(options, true), core::Error);
}

INSTANTIATE_TEST_SUITE_P(OfAnyScheme, EstimateOfCodecs,
                         testing::Values(hierarchy::kDiamonds, hierarchy::kBlocks));

}  // namespace
}  // namespace colossus::pipeline
