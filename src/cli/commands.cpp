#include "cli/commands.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/error.hpp"
#include "core/file.hpp"

namespace colossus::cli {

void print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  core::fail(core::write_status(errno), "cannot write to stdout: {}", std::strerror(errno));
}

}  // namespace colossus::cli
