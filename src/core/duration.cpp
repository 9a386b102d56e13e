#include "core/duration.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <vector>

namespace colossus::core {
namespace {

constexpr std::uint64_t kMinute = 60;
constexpr std::uint64_t kHour = 60 * kMinute;
constexpr std::uint64_t kDay = 24 * kHour;
constexpr std::uint64_t kMostSeconds = 1000 * kDay;

// Takes a number of at most nine digits from the front.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t number = 0;
  constexpr std::size_t kMostDigits = 9;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const auto digits = static_cast<std::size_t>(end - text.data());
  if (error != std::errc() || digits > kMostDigits) return std::nullopt;
  text.remove_prefix(digits);
  return number;
}

// Numbers with a colon between each two.
std::optional<std::vector<std::uint64_t>> numbers_between_colons(std::string_view text) {
  std::vector<std::uint64_t> numbers;
  for (;;) {
    const auto number = take_number(text);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (text.empty()) return numbers;
    if (text.front() != ':') return std::nullopt;
    text.remove_prefix(1);
  }
}

std::optional<std::uint64_t> parse_slurm(std::string_view text) {
  const std::size_t dash = text.find('-');
  const bool has_days = dash != std::string_view::npos;
  std::uint64_t days = 0;
  if (has_days) {
    std::string_view front = text.substr(0, dash);
    const auto number = take_number(front);
    if (!number || !front.empty()) return std::nullopt;
    days = *number;
    text.remove_prefix(dash + 1);
  }
  const auto numbers = numbers_between_colons(text);
  if (!numbers || numbers->size() > 3 || (!has_days && numbers->size() < 2)) return std::nullopt;
  // From hours on after days, and when all three are there; else minutes and seconds.
  const std::array<std::uint64_t, 3> units{kHour, kMinute, 1};
  const std::size_t first = has_days ? 0 : 3 - numbers->size();
  std::uint64_t seconds = days * kDay;
  for (std::size_t i = 0; i < numbers->size(); ++i) seconds += (*numbers)[i] * units[first + i];
  return seconds;
}

std::optional<std::uint64_t> parse_units(std::string_view text) {
  std::uint64_t seconds = 0;
  std::uint64_t smallest = kMostSeconds;
  while (!text.empty()) {
    const auto number = take_number(text);
    if (!number || (text.empty() && smallest != kMostSeconds)) return std::nullopt;  // 1h30: of what?
    const char name = text.empty() ? 's' : text.front();
    const std::uint64_t unit = name == 'd' ? kDay : name == 'h' ? kHour : name == 'm' ? kMinute : 1;
    if ((unit == 1 && name != 's') || unit >= smallest) return std::nullopt;
    if (!text.empty()) text.remove_prefix(1);
    smallest = unit;
    seconds += *number * unit;
  }
  return seconds;
}

}  // namespace

std::optional<double> parse_duration(std::string_view text) {
  const bool is_slurm = text.find_first_of(":-") != std::string_view::npos;
  const auto seconds = is_slurm ? parse_slurm(text) : parse_units(text);
  if (!seconds || *seconds == 0 || *seconds > kMostSeconds) return std::nullopt;
  return static_cast<double>(*seconds);
}

}  // namespace colossus::core
