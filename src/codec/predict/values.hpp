// Sequences of small integers by interleaved rANS (J. Duda, Asymmetric numeral systems, 2013; F. Giesen,
// Interleaved entropy coders, 2014), with static tables per node: one for each run of contexts whose values
// are too alike, or too few, for tables of their own.
//
// A value is a token and raw bits: tokens 0 to 15 are the values themselves, above them each octave has four
// tokens. Tables hold 2^10 slots; four states take turns, so that their latencies overlap.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codec/entropy/bit_models.hpp"
#include "core/error.hpp"

namespace colossus::codec::predict {

inline constexpr int kSlotBits = 10;
inline constexpr std::uint32_t kSlots = 1 << kSlotBits;
inline constexpr std::uint32_t kTokens = 128;
inline constexpr std::size_t kLanes = 4;

// Small for small magnitudes, whatever the sign; any 32 bits.
constexpr std::uint32_t to_unsigned(std::int32_t value) {
  return static_cast<std::uint32_t>(value) << 1 ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t to_signed(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1 ^ (~(value & 1U) + 1U));
}

// How many of the bounds, which ascend, are not above the value: a class without a branch.
template <typename... Bounds>
constexpr std::uint32_t class_of(std::uint32_t value, Bounds... bounds) {
  return (0U + ... + static_cast<std::uint32_t>(value >= static_cast<std::uint32_t>(bounds)));
}

struct TokenRange {
  std::uint32_t base = 0;
  std::uint32_t bits = 0;
};
inline constexpr std::array<TokenRange, kTokens> kTokenRanges = [] {
  std::array<TokenRange, kTokens> ranges{};
  for (std::uint32_t token = 0; token < kTokens; ++token) {
    const std::uint32_t octave = 4 + (token - 16) / 4;
    ranges[token] =
        token < 16 ? TokenRange{token, 0} : TokenRange{(4 + token % 4) << (octave - 2), octave - 2};
  }
  return ranges;
}();
constexpr std::uint32_t token_of(std::uint32_t value) {
  if (value < 16) return value;
  const auto octave = static_cast<std::uint32_t>(std::bit_width(value)) - 1;
  return 16 + (octave - 4) * 4 + (value >> (octave - 2) & 3U);
}

// Adds up to kSlots; 0 for what does not occur.
using Frequencies = std::array<std::uint16_t, kTokens>;

inline constexpr std::size_t kMostTables = 128;

// Which table each context has: contexts of one table are neighbours.
class TableRuns {
 public:
  // Contexts of few or like values share a table, wherever that costs less than one more table would; of how
  // often each token occurs, context by context. Every context has a table unless there are no counts at all.
  static TableRuns of(std::span<const std::uint32_t> counts, std::size_t token_count);
  // False when they make no sense.
  bool read(entropy::RangeDecoder& decoder, std::size_t context_count);
  void write(entropy::RangeEncoder& encoder) const;
  std::size_t table_count() const { return table_count_; }
  // By context.
  const std::vector<std::uint8_t>& tables() const& { return tables_; }
  std::vector<std::uint8_t> tables() && { return std::move(tables_); }

 private:
  std::vector<std::uint8_t> tables_;
  std::size_t table_count_ = 0;
};

class ValueEncoder {
 public:
  // Fewer tokens than there are when only small values come.
  explicit ValueEncoder(std::size_t context_count, std::size_t token_count = kTokens)
      : token_count_(token_count), counts_(context_count * token_count) {}
  void put(std::uint32_t context, std::uint32_t value) {
    const std::uint32_t token = token_of(value);
    ++counts_[context * token_count_ + token];
    symbols_.push_back({value, static_cast<std::uint16_t>(context), static_cast<std::uint8_t>(token)});
  }
  // Between sequences that the decoder takes with one call each.
  void end_batch() { batches_.push_back(symbols_.size()); }
  core::Bytes finish();

 private:
  struct Symbol {
    std::uint32_t value;
    std::uint16_t context;
    std::uint8_t token;
  };
  std::size_t token_count_;
  std::vector<std::uint32_t> counts_;  // of tokens, context by context
  std::vector<Symbol> symbols_;
  std::vector<std::size_t> batches_;
};

// How tables are written: version 1 of the codec had one for every context.
enum class TableLayout { kEach, kRuns };

// Total on any bytes: what is missing reads as 0.
class ValueDecoder {
 public:
  ValueDecoder(std::span<const std::byte> bytes, std::size_t context_count, TableLayout layout);

  // The next values.size() values; context_of(i) must not depend on those of the same batch.
  template <typename ContextOf>
  void get_batch(std::span<std::uint32_t> values, ContextOf context_of) {
    if (tables_ == nullptr) fill_tables();
    get_tokens(values,
               [&, tables = tables_of_contexts_.data()](std::size_t i) { return tables[context_of(i)]; });
    add_raw_bits(values);
  }

  // The value that is the only one in the context, if so: reading it changes nothing, so it may be left out.
  std::optional<std::uint32_t> only_value(std::size_t context) const;

  // Which table each context has; the first, when there are none.
  const std::vector<std::uint8_t>& tables() const { return numbers_; }
  std::size_t table_count() const { return table_count_; }
  // The next values.size() values, all of contexts of one table.
  void get_of_table(std::span<std::uint32_t> values, std::size_t table);

  // Whether all was read, no more and no less.
  bool is_done() const;

 private:
  static constexpr std::uint32_t kLeastState = 1 << 16;
  friend class ValueEncoder;

  // Apart what is read for the next state, which is waited for, and the token.
  struct Table {
    struct Slot {
      std::uint16_t frequency;  // of its token
      std::uint16_t number;     // among the token's slots
    };
    std::array<Slot, kSlots> slots;
    std::array<std::uint8_t, kSlots> tokens;
  };

  // Sets each value to its token.
  template <typename TableOf>
  void get_tokens(std::span<std::uint32_t> values, TableOf table_of) {
    const std::size_t count = values.size();
    std::array<std::uint32_t, kLanes> x = states_;
    const std::byte* const words = words_.data();
    std::size_t word = word_;
    const std::size_t safe_end = words_.size() - std::min(words_.size(), 2 * kLanes - 1);
    // Returns the state behind it.
    const auto take = [&](std::size_t at, std::uint32_t state) {
      const Table& table = *table_of(at);
      const std::uint32_t slot = state & (kSlots - 1);
      values[at] = table.tokens[slot];
      return table.slots[slot].frequency * (state >> kSlotBits) + table.slots[slot].number;
    };
    std::size_t i = 0;
    for (; i + kLanes <= count && word < safe_end; i += kLanes)
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::uint32_t state = take(i + lane, x[lane]);
        std::uint16_t next = 0;
        std::memcpy(&next, words + word, sizeof next);
        // All bits set where a word is due: by masks, since a branch would be a guess.
        const std::uint32_t is_low = 0U - static_cast<std::uint32_t>(state < kLeastState);
        x[lane] = state << (is_low & 16U) | (next & is_low);
        word += is_low & 2U;
      }
    word_ = word;
    for (; i < count; ++i) {
      std::uint32_t& state = x[i % kLanes];
      state = take(i, state);
      if (state < kLeastState) state = state << 16 | next_word();
    }
    states_ = x;
  }

  void read_tables(entropy::RangeDecoder& decoder, std::size_t context_count, TableLayout layout);
  void fill_tables();
  static void fill_table(Table& table, const Frequencies& frequencies);
  std::uint32_t next_word();
  void add_raw_bits(std::span<std::uint32_t> values);
  std::uint32_t raw_bits(std::uint32_t count);

  bool is_valid_ = true;
  std::size_t table_count_ = 0;
  std::vector<Frequencies> frequencies_;  // of each table, and of one when there are none
  std::unique_ptr<Table[]> tables_;       // filled when the first batch is read
  std::vector<std::uint8_t> numbers_;     // which table each context has
  std::vector<const Table*> tables_of_contexts_;
  std::array<std::uint32_t, kLanes> states_{};
  std::span<const std::byte> words_;
  std::size_t word_ = 0;
  std::span<const std::byte> raw_;
  std::size_t raw_offset_ = 0;
  std::uint64_t buffer_ = 0;
  std::uint32_t buffered_ = 0;
};

}  // namespace colossus::codec::predict
