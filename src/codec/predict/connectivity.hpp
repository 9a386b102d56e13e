// Triangles as symbols of the traversal, each coded in the context of what its gate looks like.
//
// Symbols are kept apart by the table that their context has, so that a decoder reads them all before the
// traversal, many at a time, and then only takes the next of a sequence: reading one by one takes longer than
// all else that a triangle needs.
#pragma once

#include "codec/coded/coded_node.hpp"
#include "codec/entropy/bit_models.hpp"
#include "codec/predict/traversal.hpp"
#include "codec/predict/values.hpp"

namespace colossus::codec::predict {

// Seeds and numbers of known vertices.
class SeedModel {
 public:
  void put(entropy::RangeEncoder& encoder, const std::array<std::uint32_t, 3>& seed, std::uint32_t known);
  std::array<std::uint32_t, 3> get(entropy::RangeDecoder& decoder, std::uint32_t known);

 private:
  std::array<entropy::GrowingWindowModel, 3> is_known_;
};

// The order of triangles that ConnectivityEncoder wants. Linear.
void order_by_traversal(std::vector<mesh::Triangle>& triangles, std::size_t vertex_count);

class ConnectivityEncoder {
 public:
  // Triangles must be as order_by_traversal() leaves them. Fills the store.
  void encode(const coded::CodedPart& part, LinkStore& store);
  // For what else is to be told between two parts.
  entropy::RangeEncoder& bits() { return bits_; }
  core::Bytes finish();

 private:
  friend class EncodingSource;
  struct Occurrence {
    std::uint16_t context;
    Symbol symbol;
  };
  std::vector<Occurrence> symbols_;
  entropy::RangeEncoder bits_;
  SeedModel seeds_;
};

// Total on any bytes.
class ConnectivityDecoder {
 public:
  // No more symbols are read than this many triangles can have.
  ConnectivityDecoder(std::span<const std::byte> bytes, std::size_t triangle_count);
  // Fills the triangles and the store; false when the symbols make no sense.
  bool decode(coded::CodedPart& part, LinkStore& store);
  entropy::RangeDecoder& bits() { return bits_; }
  // Whether all symbols were read, no more and no less.
  bool is_done() const;

 private:
  friend class DecodingSource;
  // Of the symbols of one table.
  struct Sequence {
    const std::uint32_t* next;  // of those that come after
    std::uint32_t symbol;       // the present one
  };
  bool is_valid_ = true;
  std::vector<std::uint8_t> tables_;          // by context
  std::unique_ptr<std::uint32_t[]> symbols_;  // those of each table, and one that is none
  std::vector<Sequence> sequences_;           // by table
  entropy::RangeDecoder bits_;
  SeedModel seeds_;
};

}  // namespace colossus::codec::predict
