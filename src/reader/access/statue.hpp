// What a statue of any scheme is: an open container whose rows make sense by themselves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "container/reader.hpp"
#include "reader/access/extraction.hpp"

namespace colossus::reader::access {

// Index into rows(); kNoRow where there is none.
using RowIndex = std::uint32_t;
inline constexpr RowIndex kNoRow = ~RowIndex{0};

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
  // Throws Error(kBadData) when the container is of another scheme, or when a row's error or bounds are not
  // finite or rows are out of order.
  Statue(container::ContainerReader container, std::string_view scheme);
  [[noreturn]] void fail_node(RowIndex row, const std::string& message) const;

 private:
  void check_row(RowIndex row) const;
  container::ContainerReader container_;
};

}  // namespace colossus::reader::access
