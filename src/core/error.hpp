// Errors and their exit statuses, results, and checks.
//
// The user's or the machine's fault is one exception type, Error, caught once in main(). Bytes that we did
// not write ourselves are read into a Result. Our own bugs end in COLOSSUS_CHECK.
#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace colossus::core {

// Exit statuses of the program, after sysexits.h.
enum class Status : int {
  kOk = 0,
  kUsage = 2,     // wrong command line
  kBadData = 65,  // missing, unreadable or bad input; damaged or foreign container; verify found something
  kNoResources = 69,   // not enough memory or space
  kInternal = 70,      // a bug in Colossus
  kCannotCreate = 73,  // the output cannot be created
  kIo = 74,            // any other input or output error
  kStopped = 75,       // stopped on request; run again
};

// The user's or the machine's fault. The message says what, where, expected against found, and what to do
// next.
class Error : public std::runtime_error {
 public:
  Error(Status status, const std::string& message) : std::runtime_error(message), status_(status) {}
  Status status() const { return status_; }

 private:
  Status status_;
};

template <typename... Args>
[[noreturn]] void fail(Status status, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(status, fmt::format(format, std::forward<Args>(args)...));
}

// Inside a catch block: the exception as an Error. An Error stays what it is. An allocation that failed, or
// was too large to try, and threads that cannot be started are kNoResources; what the file system or the
// system has refused is kNoResources or kIo. Anything else is a bug of ours, kInternal.
Error error_of_current_exception();

// What is wrong with bytes that we did not write ourselves, and at which offset.
struct Defect {
  std::string message;
  std::uint64_t offset = 0;
};

// A value, or a Defect of the bytes that it was to be read from.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}         // NOLINT: implicit on purpose
  Result(Defect defect) : state_(std::move(defect)) {}  // NOLINT
  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }
  const T& value() const& { return std::get<T>(state_); }
  T& value() & { return std::get<T>(state_); }
  T&& value() && { return std::get<T>(std::move(state_)); }
  const Defect& defect() const { return std::get<Defect>(state_); }

 private:
  std::variant<T, Defect> state_;
};

[[noreturn]] void check_failed(const char* condition, const char* file, int line, const std::string& context);

}  // namespace colossus::core

// Ends the program with the place and a context when our own reasoning was wrong. Never for data.
#define COLOSSUS_CHECK(condition, ...)                                                               \
  do {                                                                                               \
    if (!(condition)) [[unlikely]]                                                                   \
      ::colossus::core::check_failed(#condition, __FILE__, __LINE__, ::fmt::format("" __VA_ARGS__)); \
  } while (false)
