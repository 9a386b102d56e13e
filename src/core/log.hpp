// Log lines for log files: one line at a time, ISO time, elapsed seconds, no control characters.
#pragma once

#include <fmt/core.h>

#include <string>

namespace colossus::core {

// Only rank 0 writes progress lines; the cluster layer calls this at the start. Warnings are written by every
// rank.
void set_log_enabled(bool enabled);

// From now on progress goes to stderr: an output of the program is what stdout leads to.
void keep_log_off_stdout();

// Progress, to stdout. Each line starts with the time and the seconds since the start of the program.
void log_line(const std::string& text);

// To stderr, with "warning: " in front.
void warn_line(const std::string& text);

template <typename... Args>
void log(fmt::format_string<Args...> format, Args&&... args) {
  log_line(fmt::format(format, std::forward<Args>(args)...));
}

template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  warn_line(fmt::format(format, std::forward<Args>(args)...));
}

// Seconds since the program started.
double elapsed_seconds();

// Largest resident set of this rank so far, in bytes.
unsigned long long peak_memory_bytes();

}  // namespace colossus::core
