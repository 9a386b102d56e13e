#include "cli/commands.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "core/error.hpp"
#include "core/file.hpp"

namespace colossus::cli {

CLI::Validator count_from(std::uint64_t least, std::uint64_t most) {
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        std::uint64_t number = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, number);
        if (error == std::errc() && stop == end && number >= least && number <= most) return "";
        return fmt::format("'{}' is out of range; choose a whole number from {} to {}", text, least, most);
      },
      "");
}

CLI::Validator length() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        double number = 0.0;
        if (CLI::detail::lexical_cast(text, number) && std::isfinite(number) && number >= 0.0) return "";
        return fmt::format("'{}' is no length; choose 0 or a positive number", text);
      },
      "");
}

void print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  core::fail(core::write_status(errno), "cannot write to stdout: {}", std::strerror(errno));
}

}  // namespace colossus::cli
