#include "codec/predict/values.hpp"

#include <algorithm>

namespace colossus::codec::predict {
namespace {

// Frequencies are written with so many bits below the highest.
constexpr int kMantissaBits = 2;
constexpr int kLengthBits = 4;

// Weights that a few bits each can say: of 2^12 in total, about.
using Weights = std::array<std::uint32_t, kTokens>;

Weights rounded_weights(const std::array<std::uint32_t, kTokens>& counts) {
  std::uint64_t total = 0;
  for (const std::uint32_t count : counts) total += count;
  Weights weights{};
  for (std::size_t t = 0; t < kTokens; ++t) {
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
  std::uint64_t total = 0;
  for (const std::uint32_t weight : weights) total += weight;
  Frequencies frequencies{};
  if (total == 0) return frequencies;
  std::int32_t left = kSlots;
  for (std::size_t t = 0; t < kTokens; ++t) {
    if (weights[t] == 0) continue;
    frequencies[t] =
        static_cast<std::uint16_t>(std::max<std::uint64_t>(1, weights[t] * std::uint64_t{kSlots} / total));
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
  void put(BitEncoder& encoder, const Weights& weights) {
    std::size_t end = kTokens;
    while (end > 0 && weights[end - 1] == 0) --end;
    ends_.put(encoder, static_cast<std::uint32_t>(end));
    int before = 0;
    for (std::size_t t = 0; t < end; ++t) {
      const int length = std::bit_width(weights[t]);
      lengths_[static_cast<std::size_t>(before)].put(encoder, static_cast<std::uint32_t>(length));
      if (const int shown = shown_bits(length); shown > 0)
        encoder.put_bits(weights[t] >> (length - 1 - shown) & ((1U << shown) - 1), shown);
      before = length;
    }
  }
  Weights get(BitDecoder& decoder) {
    Weights weights{};
    const std::size_t end = std::min<std::size_t>(ends_.get(decoder), kTokens);
    std::size_t before = 0;
    for (std::size_t t = 0; t < end; ++t) {
      const auto length = static_cast<int>(lengths_[before].get(decoder));
      if (length > 0) {
        const int shown = shown_bits(length);
        weights[t] = (1U << shown | decoder.get_bits(shown)) << (length - 1 - shown);
      }
      before = static_cast<std::size_t>(length);
    }
    return weights;
  }

 private:
  static int shown_bits(int length) { return std::clamp(length - 1, 0, kMantissaBits); }
  TreeModel<8> ends_;
  std::array<TreeModel<kLengthBits>, 1 << kLengthBits> lengths_;
};

void put_size(core::ByteWriter& writer, std::size_t size) {
  for (; size >= 128; size >>= 7) writer.put(static_cast<std::uint8_t>(size | 128));
  writer.put(static_cast<std::uint8_t>(size));
}

std::size_t get_size(core::ByteReader& reader) {
  std::size_t size = 0;
  for (int shift = 0; shift < 35; shift += 7) {
    const auto byte = reader.get<std::uint8_t>();
    size |= static_cast<std::size_t>(byte & 127U) << shift;
    if (byte < 128) break;
  }
  return size;
}

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

}  // namespace

core::Bytes ValueEncoder::finish() {
  if (symbols_.empty()) return {};
  BitEncoder table_bits;
  WeightModel model;
  std::vector<Frequencies> frequencies(counts_.size());
  std::vector<std::array<std::uint16_t, kTokens>> starts(counts_.size());
  for (std::size_t c = 0; c < counts_.size(); ++c) {
    const Weights weights = rounded_weights(counts_[c]);
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
      const std::uint32_t frequency = frequencies[symbol.context][symbol.token];
      if (x >= std::uint64_t{frequency} << (32 - kSlotBits)) {
        words.push_back(static_cast<std::uint16_t>(x));
        x >>= 16;
      }
      x = (x / frequency << kSlotBits) + x % frequency + starts[symbol.context][symbol.token];
    }
  }
  std::reverse(words.begin(), words.end());
  const core::Bytes tables = table_bits.finish();
  core::ByteWriter writer;
  put_size(writer, tables.size());
  put_size(writer, words.size());
  writer.put_bytes(tables);
  writer.put(states);
  writer.put_bytes(core::as_bytes(words));
  writer.put_bytes(raw_bits_of(symbols_));
  return writer.take();
}

ValueDecoder::ValueDecoder(std::span<const std::byte> bytes, std::size_t context_count) {
  numbers_.resize(context_count);
  tables_.reserve(context_count + 1);
  tables_.emplace_back();
  if (bytes.empty()) {
    states_.fill(kLeastState);
    return;
  }
  core::ByteReader reader(bytes);
  const std::size_t table_bytes = get_size(reader);
  const std::size_t word_count = get_size(reader);
  BitDecoder tables(reader.get_bytes(table_bytes));
  states_ = reader.get<std::array<std::uint32_t, kLanes>>();
  words_ = reader.get_bytes(2 * word_count);
  raw_ = reader.get_bytes(reader.remaining());
  is_valid_ = !reader.failed();
  WeightModel model;
  for (std::size_t c = 0; c < context_count; ++c) {
    const Frequencies frequencies = normalized(model.get(tables));
    if (std::all_of(frequencies.begin(), frequencies.end(), [](std::uint16_t f) { return f == 0; })) continue;
    numbers_[c] = static_cast<std::uint8_t>(tables_.size());
    Table& table = tables_.emplace_back();
    table.frequencies = frequencies;
    std::uint32_t start = 0;
    for (std::uint32_t t = 0; t < kTokens; ++t) {
      table.starts[t] = static_cast<std::uint16_t>(start);
      std::fill_n(table.tokens.begin() + start, frequencies[t], static_cast<std::uint8_t>(t));
      start += frequencies[t];
    }
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
