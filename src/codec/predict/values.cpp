#include "codec/predict/values.hpp"

#include <algorithm>
#include <numeric>

#include "codec/predict/sizes.hpp"

namespace colossus::codec::predict {
namespace {

// Frequencies are written with so many bits below the highest.
constexpr int kMantissaBits = 2;
constexpr int kLengthBits = 4;

// n * log2(n) in units of 2^-16 bits, to some 2^-14 of n, by integers alone: bytes depend on it.
std::uint64_t entropy_term(std::uint32_t n) {
  // log2(1 + i / 64), and between them a line.
  static constexpr std::array<std::uint32_t, 65> kFractions = [] {
    std::array<std::uint32_t, 65> fractions{};
    for (std::uint32_t i = 0; i < 64; ++i) {
      std::uint64_t x = std::uint64_t{64 + i} << 25;  // of [2^31, 2^32), squared for bit after bit
      for (int bit = 0; bit < 16; ++bit) {
        x = x * x >> 31;
        fractions[i] = fractions[i] << 1 | static_cast<std::uint32_t>(x >> 32);
        x >>= x >> 32;
      }
    }
    fractions[64] = 1 << 16;
    return fractions;
  }();
  if (n < 2) return 0;
  const auto octave = static_cast<std::uint32_t>(std::bit_width(n)) - 1;
  const std::uint32_t digits = n << (31 - octave) & 0x7fffffff;
  const std::uint32_t i = digits >> 25;
  const std::uint32_t rest = digits >> 15 & 1023;
  const std::uint32_t fraction = kFractions[i] + ((kFractions[i + 1] - kFractions[i]) * rest >> 10);
  return std::uint64_t{n} * (octave << 16 | fraction);
}

// What a table and the values that it codes take, in units of 2^-16 bits: about, for the table, with
// something for the time that it takes to read.
std::uint64_t cost_of(std::span<const std::uint32_t> counts) {
  constexpr std::uint64_t kTableBits = 64;
  constexpr std::uint64_t kTokenBits = 8;
  std::uint32_t total = 0;
  std::uint64_t terms = 0;
  std::uint64_t bits = kTableBits;
  for (const std::uint32_t count : counts) {
    total += count;
    terms += entropy_term(count);
    bits += count > 0 ? kTokenBits : 0;
  }
  return entropy_term(total) - std::min(terms, entropy_term(total)) + (bits << 16);
}

// Weights that a few bits each can say: of 2^12 in total, about.
using Weights = std::array<std::uint32_t, kTokens>;

Weights rounded_weights(std::span<const std::uint32_t> counts) {
  std::uint64_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  Weights weights{};
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (counts[t] == 0) continue;
    auto weight =
        static_cast<std::uint32_t>(std::max<std::uint64_t>(1, (std::uint64_t{counts[t]} << 12) / total));
    const int drop = std::max(0, static_cast<int>(std::bit_width(weight)) - 1 - kMantissaBits);
    // Half a unit more may carry into the next octave, which is as easy to say.
    weight = drop > 0 ? (weight + (1U << (drop - 1))) >> drop << drop : weight;
    weights[t] = weight;
  }
  return weights;
}

// To a sum of kSlots, at least 1 for each weight; none when there is no weight.
Frequencies normalized(const Weights& weights) {
  std::uint32_t total = 0;
  for (const std::uint32_t weight : weights) total += weight;
  Frequencies frequencies{};
  if (total == 0) return frequencies;
  std::int32_t left = kSlots;
  for (std::size_t t = 0; t < kTokens; ++t) {
    if (weights[t] == 0) continue;
    // Weights have 15 bits at most.
    frequencies[t] = static_cast<std::uint16_t>(std::max(1U, weights[t] * kSlots / total));
    left -= frequencies[t];
  }
  while (left != 0) {
    auto& most = *std::max_element(frequencies.begin(), frequencies.end());
    const std::int32_t change = left > 0 ? left : std::max(left, -(most / 2));
    most = static_cast<std::uint16_t>(most + change);
    left -= change;
  }
  return frequencies;
}

class WeightModel {
 public:
  void put(entropy::RangeEncoder& encoder, const Weights& weights) {
    std::size_t end = kTokens;
    while (end > 0 && weights[end - 1] == 0) --end;
    ends_.encode(encoder, static_cast<std::uint32_t>(end));
    int before = 0;
    for (std::size_t t = 0; t < end; ++t) {
      const int length = std::bit_width(weights[t]);
      lengths_[static_cast<std::size_t>(before)].encode(encoder, static_cast<std::uint32_t>(length));
      if (const int shown = shown_bits(length); shown > 0)
        encoder.encode_bits(weights[t] >> (length - 1 - shown) & ((1U << shown) - 1), shown);
      before = length;
    }
  }
  Weights get(entropy::RangeDecoder& decoder) {
    Weights weights{};
    const std::size_t end = std::min<std::size_t>(ends_.decode(decoder), kTokens);
    std::size_t before = 0;
    for (std::size_t t = 0; t < end; ++t) {
      const auto length = static_cast<int>(lengths_[before].decode(decoder));
      if (length > 0) {
        const int shown = shown_bits(length);
        weights[t] = (1U << shown | decoder.decode_bits(shown)) << (length - 1 - shown);
      }
      before = static_cast<std::size_t>(length);
    }
    return weights;
  }

 private:
  static int shown_bits(int length) { return std::clamp(length - 1, 0, kMantissaBits); }
  entropy::TreeModel<8> ends_;
  std::array<entropy::TreeModel<kLengthBits>, 1 << kLengthBits> lengths_;
};

core::Bytes raw_bits_of(const auto& symbols) {
  core::Bytes bytes;
  std::uint64_t buffer = 0;
  std::uint32_t buffered = 0;
  for (const auto& symbol : symbols) {
    const TokenRange range = kTokenRanges[symbol.token];
    buffer |= std::uint64_t{symbol.value - range.base} << buffered;
    for (buffered += range.bits; buffered >= 8; buffered -= 8, buffer >>= 8)
      bytes.push_back(static_cast<std::byte>(buffer));
  }
  if (buffered > 0) bytes.push_back(static_cast<std::byte>(buffer));
  return bytes;
}

// Numbers below 2^15, small ones in few bits.
class NumberModel {
 public:
  void put(entropy::RangeEncoder& encoder, std::uint32_t number) {
    const int width = std::bit_width(number);
    widths_.encode(encoder, static_cast<std::uint32_t>(width));
    if (width > 1) encoder.encode_bits(number & ((1U << (width - 1)) - 1), width - 1);
  }
  std::uint32_t get(entropy::RangeDecoder& decoder) {
    const auto width = static_cast<int>(widths_.decode(decoder));
    return width < 2 ? static_cast<std::uint32_t>(width) : 1U << (width - 1) | decoder.decode_bits(width - 1);
  }

 private:
  entropy::TreeModel<4> widths_;
};

}  // namespace

TableRuns TableRuns::of(std::span<const std::uint32_t> counts, std::size_t token_count) {
  TableRuns runs;
  runs.tables_.resize(counts.size() / token_count);
  std::vector<std::uint32_t> run(token_count);
  std::uint64_t run_cost = 0;
  for (std::size_t c = 0; c < runs.tables_.size(); ++c) {
    const auto here = counts.subspan(c * token_count, token_count);
    if (std::any_of(here.begin(), here.end(), [](std::uint32_t count) { return count > 0; })) {
      std::vector<std::uint32_t> both = run;
      for (std::size_t t = 0; t < token_count; ++t) both[t] += here[t];
      const std::uint64_t alone = cost_of(here);
      const std::uint64_t together = cost_of(both);
      if (runs.table_count_ == 0 || (together > run_cost + alone && runs.table_count_ < kMostTables)) {
        ++runs.table_count_;
        run.assign(here.begin(), here.end());
        run_cost = alone;
      } else {
        run = std::move(both);
        run_cost = together;
      }
    }
    runs.tables_[c] = static_cast<std::uint8_t>(std::max<std::size_t>(runs.table_count_, 1) - 1);
  }
  return runs;
}

void TableRuns::write(entropy::RangeEncoder& encoder) const {
  NumberModel numbers;
  numbers.put(encoder, static_cast<std::uint32_t>(table_count_));
  std::size_t begin = 0;
  for (std::size_t c = 1; c < tables_.size(); ++c) {
    if (tables_[c] == tables_[c - 1]) continue;
    numbers.put(encoder, static_cast<std::uint32_t>(c - begin));
    begin = c;
  }
}

bool TableRuns::read(entropy::RangeDecoder& decoder, std::size_t context_count) {
  NumberModel numbers;
  table_count_ = numbers.get(decoder);
  tables_.assign(context_count, 0);
  if (table_count_ > std::min(kMostTables, context_count)) return false;
  std::size_t begin = 0;
  for (std::size_t table = 0; table + 1 < table_count_; ++table) {
    const std::size_t size = numbers.get(decoder);
    if (size == 0 || size >= context_count - begin) return false;
    std::fill_n(tables_.begin() + static_cast<std::ptrdiff_t>(begin), size, static_cast<std::uint8_t>(table));
    begin += size;
  }
  std::fill(tables_.begin() + static_cast<std::ptrdiff_t>(begin), tables_.end(),
            static_cast<std::uint8_t>(std::max<std::size_t>(table_count_, 1) - 1));
  return true;
}

core::Bytes ValueEncoder::finish() {
  if (symbols_.empty()) return {};
  entropy::RangeEncoder table_bits;
  const TableRuns runs = TableRuns::of(counts_, token_count_);
  runs.write(table_bits);
  std::vector<std::uint32_t> counts(runs.table_count() * token_count_);
  for (std::size_t c = 0; c < runs.tables().size(); ++c)
    for (std::size_t t = 0; t < token_count_; ++t)
      counts[runs.tables()[c] * token_count_ + t] += counts_[c * token_count_ + t];
  WeightModel model;
  std::vector<Frequencies> frequencies(runs.table_count());
  std::vector<std::array<std::uint16_t, kTokens>> starts(runs.table_count());
  for (std::size_t c = 0; c < frequencies.size(); ++c) {
    const Weights weights = rounded_weights(std::span(counts).subspan(c * token_count_, token_count_));
    model.put(table_bits, weights);
    frequencies[c] = normalized(weights);
    std::uint32_t start = 0;
    for (std::size_t t = 0; t < kTokens; ++t) {
      starts[c][t] = static_cast<std::uint16_t>(start);
      start += frequencies[c][t];
    }
  }
  // Backwards: what is put last is read first.
  std::array<std::uint32_t, kLanes> states;
  states.fill(ValueDecoder::kLeastState);
  std::vector<std::uint16_t> words;
  words.reserve(symbols_.size());
  for (std::size_t b = batches_.size(); b-- > 0;) {
    const std::size_t begin = b == 0 ? 0 : batches_[b - 1];
    for (std::size_t i = batches_[b]; i-- > begin;) {
      const Symbol& symbol = symbols_[i];
      std::uint32_t& x = states[(i - begin) % kLanes];
      const std::size_t table = runs.tables()[symbol.context];
      const std::uint32_t frequency = frequencies[table][symbol.token];
      if (x >= std::uint64_t{frequency} << (32 - kSlotBits)) {
        words.push_back(static_cast<std::uint16_t>(x));
        x >>= 16;
      }
      x = (x / frequency << kSlotBits) + x % frequency + starts[table][symbol.token];
    }
  }
  std::reverse(words.begin(), words.end());
  const core::Bytes tables = table_bits.finish_without_zeros();
  core::ByteWriter writer;
  put_size(writer, tables.size());
  put_size(writer, words.size());
  writer.put_bytes(tables);
  writer.put(states);
  writer.put_bytes(core::as_bytes(words));
  writer.put_bytes(raw_bits_of(symbols_));
  return writer.take();
}

ValueDecoder::ValueDecoder(std::span<const std::byte> bytes, std::size_t context_count, TableLayout layout)
    : numbers_(context_count) {
  core::ByteReader reader(bytes);
  const std::size_t table_bytes = bytes.empty() ? 0 : get_size(reader);
  const std::size_t word_count = bytes.empty() ? 0 : get_size(reader);
  entropy::RangeDecoder tables(reader.get_bytes(table_bytes));
  read_tables(tables, bytes.empty() ? 0 : context_count, layout);
  states_.fill(kLeastState);
  if (bytes.empty()) return;
  states_ = reader.get<std::array<std::uint32_t, kLanes>>();
  words_ = reader.get_bytes(2 * word_count);
  raw_ = reader.get_bytes(reader.remaining());
  is_valid_ = is_valid_ && !reader.failed();
}

void ValueDecoder::read_tables(entropy::RangeDecoder& decoder, std::size_t context_count,
                               TableLayout layout) {
  // Without bytes there are no tables, and all contexts have the one of zeros.
  if (context_count > 0 && layout == TableLayout::kEach) {
    table_count_ = context_count;
    std::iota(numbers_.begin(), numbers_.end(), std::uint8_t{0});
  } else if (context_count > 0) {
    TableRuns runs;
    is_valid_ = runs.read(decoder, context_count);
    table_count_ = is_valid_ ? runs.table_count() : 0;
    if (is_valid_) numbers_ = std::move(runs).tables();
  }
  // One of zeros, when there is none.
  frequencies_.resize(std::max<std::size_t>(table_count_, 1));
  WeightModel model;
  for (std::size_t i = 0; i < table_count_; ++i) frequencies_[i] = normalized(model.get(decoder));
}

void ValueDecoder::fill_tables() {
  tables_ = std::make_unique_for_overwrite<Table[]>(frequencies_.size());
  for (std::size_t i = 0; i < frequencies_.size(); ++i) fill_table(tables_[i], frequencies_[i]);
  tables_of_contexts_.clear();
  for (const std::uint8_t number : numbers_) tables_of_contexts_.push_back(&tables_[number]);
}

std::optional<std::uint32_t> ValueDecoder::only_value(std::size_t context) const {
  const Frequencies& frequencies = frequencies_[numbers_[context]];
  for (std::uint32_t token = 0; token < 16; ++token)
    if (frequencies[token] == kSlots) return token;
  return std::nullopt;
}

void ValueDecoder::get_of_table(std::span<std::uint32_t> values, std::size_t table) {
  Table slots;
  fill_table(slots, frequencies_[table]);
  get_tokens(values, [&](std::size_t) { return &slots; });
  add_raw_bits(values);
}

void ValueDecoder::fill_table(Table& table, const Frequencies& frequencies) {
  std::uint32_t begin = 0;
  for (std::uint32_t t = 0; t < kTokens; ++t) {
    const std::uint32_t frequency = frequencies[t];
    if (frequency == 0) continue;
    std::fill_n(table.tokens.begin() + begin, frequency, static_cast<std::uint8_t>(t));
    Table::Slot* const slots = table.slots.data() + begin;
    for (std::uint32_t i = 0; i < frequency; ++i)
      slots[i] = {static_cast<std::uint16_t>(frequency), static_cast<std::uint16_t>(i)};
    begin += frequency;
  }
  // All of them, when nothing occurs.
  for (; begin < kSlots; ++begin) {
    table.tokens[begin] = 0;
    table.slots[begin] = {0, static_cast<std::uint16_t>(begin)};
  }
}

std::uint32_t ValueDecoder::next_word() {
  if (word_ + 2 > words_.size()) {
    is_valid_ = false;
    return 0;
  }
  std::uint16_t word = 0;
  std::memcpy(&word, words_.data() + word_, sizeof word);
  word_ += 2;
  return word;
}

std::uint32_t ValueDecoder::raw_bits(std::uint32_t count) {
  if (buffered_ < count) {
    if (raw_offset_ + 8 <= raw_.size()) {
      std::uint64_t more = 0;
      std::memcpy(&more, raw_.data() + raw_offset_, sizeof more);
      buffer_ |= more << buffered_;
      raw_offset_ += (63 - buffered_) / 8;
      buffered_ |= 56;
    } else {
      while (buffered_ <= 56 && raw_offset_ < raw_.size()) {
        buffer_ |= std::to_integer<std::uint64_t>(raw_[raw_offset_++]) << buffered_;
        buffered_ += 8;
      }
      if (buffered_ < count) {
        is_valid_ = false;
        buffered_ = 64;
      }
    }
  }
  const auto bits = static_cast<std::uint32_t>(buffer_ & ((std::uint64_t{1} << count) - 1));
  buffer_ >>= count;
  buffered_ -= count;
  return bits;
}

void ValueDecoder::add_raw_bits(std::span<std::uint32_t> values) {
  constexpr std::size_t kBlock = 16;
  for (std::size_t begin = 0; begin < values.size(); begin += kBlock) {
    const auto block = values.subspan(begin, std::min(kBlock, values.size() - begin));
    // Where there are some, a branch for each value would be a guess.
    std::uint32_t all = 0;
    for (const std::uint32_t value : block) all |= value;
    if (all < 16) continue;
    // Each value moves on by four bytes at most.
    if (raw_offset_ + 4 * kBlock + 8 > raw_.size()) {
      for (std::uint32_t& value : block) {
        const TokenRange range = kTokenRanges[value];
        value = range.base + raw_bits(range.bits);
      }
      continue;
    }
    const std::byte* from = raw_.data() + raw_offset_;
    std::uint64_t buffer = buffer_;
    std::uint32_t buffered = buffered_;
    for (std::uint32_t& value : block) {
      const TokenRange range = kTokenRanges[value];
      // Rare: most values have a few bits, none has more than 29.
      if (buffered < 29) {
        std::uint64_t more = 0;
        std::memcpy(&more, from, sizeof more);
        buffer |= more << buffered;
        from += (63 - buffered) / 8;
        buffered |= 56;
      }
      value = range.base + static_cast<std::uint32_t>(buffer & ((std::uint64_t{1} << range.bits) - 1));
      buffer >>= range.bits;
      buffered -= range.bits;
    }
    raw_offset_ = static_cast<std::size_t>(from - raw_.data());
    buffer_ = buffer;
    buffered_ = buffered;
  }
}

bool ValueDecoder::is_done() const {
  // Whole bytes in the buffer were not needed.
  return is_valid_ && word_ == words_.size() && raw_offset_ - buffered_ / 8 == raw_.size() && buffer_ == 0 &&
         std::all_of(states_.begin(), states_.end(), [](std::uint32_t x) { return x == kLeastState; });
}

}  // namespace colossus::codec::predict
