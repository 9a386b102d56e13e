// An opened sketch, see sketch.hpp.
#pragma once

#include "reader/access/statue.hpp"

namespace colossus::toy {

class Statue final : public reader::access::Statue {
 public:
  // Throws Error(kBadData) when the container is damaged or has other levels than a sketch has.
  Statue(container::ContainerReader container, const reader::access::StatueOptions& options);

  reader::access::Extraction extract(const reader::access::CutRequest& request) const override;
  std::string_view name_of_parts() const override { return "nodes"; }
  double lattice_error() const override;
  std::string_view position_bits_meaning() const override { return "bits that mean nothing"; }

  // See Statue::decode_node().
  codec::coded::CodedNode load(reader::access::RowIndex row) const;
  std::array<double, 3> world(const geometry::Point& p) const;
};

}  // namespace colossus::toy
