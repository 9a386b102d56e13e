#include "codec/predict/colors.hpp"

#include <algorithm>
#include <bit>

#include "codec/predict/buffer.hpp"

namespace colossus::codec::predict {
namespace {

using Channels = std::array<std::int32_t, 4>;

constexpr std::uint32_t kLuma = 0;    // by the number of neighbours
constexpr std::uint32_t kOrange = 2;  // by the size of the luma
constexpr std::uint32_t kGreen = 5;   // likewise
constexpr std::uint32_t kOpacity = 8;

std::uint32_t luma_context(std::uint8_t kind) { return kLuma + (neighbors_of(kind) > 2 ? 1U : 0U); }
std::uint32_t size_class(std::uint32_t luma) { return class_of(luma, 6, 18); }

// Colours in lanes of 16 bits, so that four channels are added at once: the first and the third, then the
// others, which is but a shift away from four bytes.
using Lanes = std::uint64_t;
constexpr Lanes kEachLane = 0x0001000100010001;

Lanes to_lanes(std::uint32_t color) { return (color & 0x00ff00ff) | Lanes{color & 0xff00ff00} << 24; }
std::uint32_t to_color(Lanes lanes) { return static_cast<std::uint32_t>(lanes | lanes >> 24); }

// The mean of four.
Lanes predict(const Links& links, const Lanes* colors, std::size_t v, const mesh::Color& first) {
  if (neighbors_of(links.kinds[v]) == 0)
    return v > 0 ? colors[v - 1] : to_lanes(std::bit_cast<std::uint32_t>(first));
  const auto& [p, q, r, s] = links.of[v].neighbors;
  // The last two come latest, and what they yield is waited for.
  const Lanes sum = (colors[p] + colors[q] + 2 * kEachLane) + (colors[r] + colors[s]);
  return sum >> 2 & 255 * kEachLane;
}

}  // namespace

void encode_colors(ValueEncoder& values, const Links& links, const coded::CodedPart& part) {
  const std::size_t count = part.colors.size();
  std::vector<Channels> residuals(count);
  Buffer<Lanes> colors(count);
  for (std::size_t v = 0; v < count; ++v) {
    colors[v] = to_lanes(std::bit_cast<std::uint32_t>(part.colors[v]));
    const auto prediction = std::bit_cast<mesh::Color>(to_color(predict(links, &colors[0], v, kOpaqueBlack)));
    Channels d{};
    for (std::size_t c = 0; c < 4; ++c) d[c] = int{part.colors[v][c]} - int{prediction[c]};
    const std::int32_t orange = d[0] - d[2];
    const std::int32_t middle = d[2] + (orange >> 1);
    const std::int32_t green = d[1] - middle;
    residuals[v] = {middle + (green >> 1), orange, green, d[3]};
  }
  const auto put = [&](std::size_t channel, auto context_of) {
    for (std::size_t v = 0; v < count; ++v) values.put(context_of(v), to_unsigned(residuals[v][channel]));
    values.end_batch();
  };
  put(0, [&](std::size_t v) { return luma_context(links.kinds[v]); });
  put(1, [&](std::size_t v) { return kOrange + size_class(to_unsigned(residuals[v][0])); });
  put(2, [&](std::size_t v) { return kGreen + size_class(to_unsigned(residuals[v][0])); });
  put(3, [&](std::size_t) { return kOpacity; });
}

void decode_colors(ValueDecoder& values, const Links& links, coded::CodedPart& part,
                   const mesh::Color& first) {
  const std::size_t count = part.colors.size();
  Buffer<std::uint32_t> lumas(count);
  Buffer<std::uint32_t> oranges(count);
  Buffer<std::uint32_t> greens(count);
  Buffer<std::uint32_t> opacities(count);
  Buffer<std::uint8_t> classes(count);
  values.get_batch(lumas.all(), [&](std::size_t v) { return luma_context(links.kinds[v]); });
  for (std::size_t v = 0; v < count; ++v) classes[v] = static_cast<std::uint8_t>(size_class(lumas[v]));
  values.get_batch(oranges.all(), [&](std::size_t v) { return kOrange + classes[v]; });
  values.get_batch(greens.all(), [&](std::size_t v) { return kGreen + classes[v]; });
  if (const auto opacity = values.only_value(kOpacity))
    std::fill_n(opacities.all().begin(), count, *opacity);
  else
    values.get_batch(opacities.all(), [](std::size_t) { return kOpacity; });
  Buffer<std::uint32_t> residuals(count);
  for (std::size_t v = 0; v < count; ++v) {
    const std::int32_t green = to_signed(greens[v]);
    const std::int32_t middle = wrapped_difference(to_signed(lumas[v]), green >> 1);
    const std::int32_t orange = to_signed(oranges[v]);
    const std::int32_t blue = wrapped_difference(middle, orange >> 1);
    const auto channel = [](std::int32_t value) { return static_cast<std::uint32_t>(value) & 255; };
    residuals[v] = channel(wrapped_sum(blue, orange)) | channel(wrapped_sum(middle, green)) << 8 |
                   channel(blue) << 16 | channel(to_signed(opacities[v])) << 24;
  }
  Buffer<Lanes> buffer(count);
  Lanes* const colors = &buffer[0];
  const std::span<mesh::Color> result = part.colors;
  for (std::size_t v = 0; v < count; ++v) {
    colors[v] = (to_lanes(residuals[v]) + predict(links, colors, v, first)) & 255 * kEachLane;
    result[v] = std::bit_cast<mesh::Color>(to_color(colors[v]));
  }
}

}  // namespace colossus::codec::predict
