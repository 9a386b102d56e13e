#include "codec/predict/colors.hpp"

#include <algorithm>

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

// Colours in lanes of 16 bits, so that four channels are added at once.
using Lanes = std::uint64_t;
constexpr Lanes kEachLane = 0x0001000100010001;

Lanes to_lanes(const mesh::Color& color) {
  return Lanes{color[0]} | Lanes{color[1]} << 16 | Lanes{color[2]} << 32 | Lanes{color[3]} << 48;
}

// The mean of four.
Lanes predict(const VertexLinks& links, const Buffer<Lanes>& colors, std::size_t v) {
  if (links.neighbor_count == 0) return v > 0 ? colors[v - 1] : 0;
  Lanes sum = 2 * kEachLane;
  for (const std::uint32_t neighbor : links.neighbors) sum += colors[neighbor];
  return sum >> 2 & 255 * kEachLane;
}

}  // namespace

void encode_colors(ValueEncoder& values, const Links& links, const CodedPart& part) {
  const std::size_t count = part.colors.size();
  std::vector<Channels> residuals(count);
  Buffer<Lanes> colors(count);
  for (std::size_t v = 0; v < count; ++v) {
    colors[v] = to_lanes(part.colors[v]);
    const Lanes prediction = predict(links.of[v], colors, v);
    Channels d{};
    for (std::size_t c = 0; c < 4; ++c)
      d[c] = part.colors[v][c] - static_cast<std::int32_t>(prediction >> 16 * c & 255);
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

void decode_colors(ValueDecoder& values, const Links& links, CodedPart& part) {
  const std::size_t count = part.colors.size();
  Buffer<std::uint32_t> lumas(count);
  Buffer<std::uint32_t> oranges(count);
  Buffer<std::uint32_t> greens(count);
  Buffer<std::uint32_t> opacities(count);
  values.get_batch(lumas.all(), [&](std::size_t v) { return luma_context(links.kinds[v]); });
  values.get_batch(oranges.all(), [&](std::size_t v) { return kOrange + size_class(lumas[v]); });
  values.get_batch(greens.all(), [&](std::size_t v) { return kGreen + size_class(lumas[v]); });
  if (const auto opacity = values.only_value(kOpacity))
    std::fill_n(opacities.all().begin(), count, *opacity);
  else
    values.get_batch(opacities.all(), [](std::size_t) { return kOpacity; });
  Buffer<Lanes> colors(count);
  for (std::size_t v = 0; v < count; ++v) {
    const std::int32_t green = to_signed(greens[v]);
    const std::int32_t middle = wrapped_difference(to_signed(lumas[v]), green >> 1);
    const std::int32_t orange = to_signed(oranges[v]);
    const std::int32_t blue = wrapped_difference(middle, orange >> 1);
    colors[v] =
        to_lanes({static_cast<std::uint8_t>(wrapped_sum(blue, orange)),
                  static_cast<std::uint8_t>(wrapped_sum(middle, green)), static_cast<std::uint8_t>(blue),
                  static_cast<std::uint8_t>(to_signed(opacities[v]))});
  }
  for (std::size_t v = 0; v < count; ++v) {
    const Lanes color = (colors[v] + predict(links.of[v], colors, v)) & 255 * kEachLane;
    colors[v] = color;
    for (std::size_t c = 0; c < 4; ++c) part.colors[v][c] = static_cast<std::uint8_t>(color >> 16 * c);
  }
}

}  // namespace colossus::codec::predict
