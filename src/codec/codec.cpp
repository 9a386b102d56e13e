#include "codec/codec.hpp"

#include <algorithm>
#include <string>

#include "codec/paper/paper_codec.hpp"
#include "codec/paper/strips.hpp"
#include "codec/predict/connectivity.hpp"
#include "codec/predict/predict.hpp"
#include "codec/zstd/packed_arrays.hpp"

namespace colossus::codec {
namespace {

constexpr int kFastLevel = 1;
constexpr int kUsualLevel = 3;

constexpr std::array kCodecs{
    Codec{.name = "predict",
          .id = 5,
          .version = 2,
          .zstd_level = kFastLevel,
          .measured = {.triangle = 1.45, .finer_bit = 0.17, .coarser_bit = 0.09, .color = 0.65},
          .order = &predict::order_by_traversal,
          .encode = &predict::encode_predicted,
          .decode = &predict::decode_predicted},
    Codec{.name = "zstd",
          .id = 3,
          .version = 1,
          .zstd_level = kUsualLevel,
          .measured = {.triangle = 6.3, .finer_bit = 0.33, .coarser_bit = 0.27, .color = 1.3},
          .order = &zstd::order_for_cache,
          .encode = &zstd::encode_packed,
          .decode = &zstd::decode_packed},
    Codec{.name = "paper",
          .id = 4,
          .version = 1,
          .zstd_level = kFastLevel,
          .measured = {.triangle = 3.8, .finer_bit = 0.2, .coarser_bit = 0.2, .color = 1.0},
          .order = &paper::order_in_strips,
          .encode = &paper::encode_paper,
          .decode = &paper::decode_paper},
};

// A version that was written once stays readable.
constexpr std::array kOldVersions{
    Codec{.name = "predict",
          .id = 5,
          .version = 1,
          .zstd_level = kFastLevel,
          .measured = {},
          .order = nullptr,
          .encode = nullptr,
          .decode = &predict::decode_predicted_1},
};

// Before there was a table, ids stood for schemes, and payloads had no checksum.
constexpr std::uint8_t kGreatestOldId = 2;

}  // namespace

std::span<const Codec> codecs() { return kCodecs; }
std::span<const Codec> old_versions() { return kOldVersions; }

const Codec& codec_named(std::string_view name) {
  const auto found =
      std::find_if(kCodecs.begin(), kCodecs.end(), [&](const Codec& c) { return c.name == name; });
  if (found != kCodecs.end()) return *found;
  std::string names;
  for (const Codec& codec : kCodecs) names += fmt::format("{}{}", names.empty() ? "" : ", ", codec.name);
  core::fail(core::Status::kUsage, "--codec {} is unknown; choose one of {}", name, names);
}

core::Result<const Codec*> codec_of(std::span<const std::byte> payload) {
  core::ByteReader reader(payload);
  const auto id = reader.get<std::uint8_t>();
  const auto version = reader.get<std::uint8_t>();
  if (reader.failed()) return core::Defect{"the payload is cut short", 0};
  for (const std::span<const Codec> versions :
       {std::span<const Codec>(kCodecs), std::span<const Codec>(kOldVersions)})
    for (const Codec& codec : versions)
      if (codec.id == id && codec.version == version) return &codec;
  if (id > 0 && id <= kGreatestOldId && version == 1)
    return core::Defect{
        fmt::format("codec {} version {} is that of early containers, which this program no longer reads; "
                    "build the container again",
                    id, version),
        0};
  std::string known;
  for (const Codec& codec : kCodecs)
    known +=
        fmt::format("{}{} version {} ({})", known.empty() ? "" : ", ", codec.id, codec.version, codec.name);
  return core::Defect{
      fmt::format("codec {} version {} is unknown; this program reads codec {}", id, version, known), 0};
}

}  // namespace colossus::codec
