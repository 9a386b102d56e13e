#include "core/log.hpp"

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <ctime>

namespace colossus::core {
namespace {

bool log_enabled = true;
std::FILE* log_stream = stdout;
const auto start_time = std::chrono::steady_clock::now();

}  // namespace

void set_log_enabled(bool enabled) { log_enabled = enabled; }

void keep_log_off_stdout() { log_stream = stderr; }

double elapsed_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
}

void log_line(const std::string& text) {
  if (!log_enabled) return;
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%SZ", &utc);
  const std::string line = fmt::format("{} {:8.2f}s  {}\n", stamp, elapsed_seconds(), text);
  std::fwrite(line.data(), 1, line.size(), log_stream);
  std::fflush(log_stream);
}

void warn_line(const std::string& text) {
  const std::string line = "colossus: warning: " + text + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

unsigned long long peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<unsigned long long>(usage.ru_maxrss) * 1024ULL;
}

}  // namespace colossus::core
