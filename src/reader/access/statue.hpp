// What a statue of any scheme is: an open container whose rows make sense by themselves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codec/coded/coded_node.hpp"
#include "codec/payload.hpp"
#include "container/reader.hpp"
#include "geometry/point.hpp"
#include "reader/access/extraction.hpp"

namespace colossus::reader::access {

// Index into rows(); kNoRow where there is none.
using RowIndex = std::uint32_t;
inline constexpr RowIndex kNoRow = ~RowIndex{0};

// Rows of one level are consecutive: first <= row < last.
struct RowRange {
  RowIndex first = 0;
  RowIndex last = 0;
  std::size_t size() const { return last - first; }
};

// "level 5, centre 1, 2, 3", for messages.
std::string name_of(const container::NodeRow& row);

struct StatueOptions {
  std::size_t cache_bytes = std::size_t{256}
                            << 20;  // decoded nodes kept by node(), least recently used go first
};

class Statue {
 public:
  virtual ~Statue() = default;
  Statue(const Statue&) = delete;
  Statue& operator=(const Statue&) = delete;

  const container::ContainerReader& container() const { return container_; }
  const container::Metadata& metadata() const { return container_.metadata(); }
  const std::vector<container::NodeRow>& rows() const { return container_.rows(); }
  std::uint32_t deepest_level() const { return rows().empty() ? 0 : rows().back().level; }
  bool is_leaf(RowIndex row) const { return (rows()[row].flags & container::kNodeIsLeaf) != 0; }
  // The value of the metadata's count of that name.
  std::optional<std::uint64_t> count_of(std::string_view name) const;
  // Likewise of the measure of that name.
  std::optional<double> measure_of(std::string_view name) const;

  // The row of this level and centre; kNoRow when there is none. log n.
  RowIndex find_row(std::uint32_t level, const geometry::Point& center) const;
  // level <= deepest_level().
  RowRange rows_of_level(std::uint32_t level) const;

  // The largest distance, in world units, between a vertex of the input and its place on the lattice.
  virtual double lattice_error() const = 0;
  // Cuts and assembles, as the scheme's own functions do, which say more; throws like them.
  virtual Extraction extract(const CutRequest& request) const = 0;
  // What a cut consists of, for people: "cubes".
  virtual std::string_view name_of_parts() const = 0;
  // What the metadata's position bits are bits of, for people.
  virtual std::string_view position_bits_meaning() const = 0;

  // name_of() the row.
  std::string name(RowIndex row) const { return name_of(rows()[row]); }

 protected:
  // Throws Error(kBadData) when the container is of another scheme. That rows are in order, and their errors
  // and bounds finite, the container's reader has seen to.
  Statue(container::ContainerReader container, std::string_view scheme);
  [[noreturn]] void fail_node(RowIndex row, const std::string& message) const;
  // The value of the metadata's parameter of that name. Throws Error(kBadData) when there is none.
  double parameter(std::string_view name) const;

  // codec::decode_with_weights() or codec::decode_on_lattice().
  using Decode = core::Result<codec::coded::CodedNode> (*)(std::span<const std::byte> payload,
                                                           const codec::NodeCounts& most);
  // Reads, decodes and checks a node as far as no scheme differs: its attributes are the container's, its
  // counts the row's. Throws Error(kBadData) that names file, level and centre when its bytes are damaged or
  // are not what row and metadata say, Error(kIo) when the device fails. Keeps nothing. Thread-safe.
  codec::coded::CodedNode decode_node(RowIndex index, Decode decode) const;

 private:
  container::ContainerReader container_;
};

}  // namespace colossus::reader::access
