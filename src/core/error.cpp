#include "core/error.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <system_error>

#include "core/file.hpp"

namespace colossus::core {

Error error_of_current_exception() {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return {Status::kNoResources, "not enough memory: an allocation failed"};
  } catch (const std::length_error& error) {
    return {Status::kNoResources, fmt::format("not enough memory: {}", error.what())};
  } catch (const std::system_error& error) {
    // Among them those of std::filesystem, which name the files.
    const int code = error.code().value();
    const bool is_lack = code == EAGAIN || code == ENOMEM || code == EMFILE || code == ENFILE;
    return {is_lack ? Status::kNoResources : write_status(code), error.what()};
  } catch (const std::exception& error) {
    return {Status::kInternal, fmt::format("internal error (please report it): {}", error.what())};
  } catch (...) {
    return {Status::kInternal, "internal error (please report it): an exception of unknown type"};
  }
}

void check_failed(const char* condition, const char* file, int line, const std::string& context) {
  std::fprintf(stderr, "colossus: internal error (please report it): %s does not hold at %s:%d%s%s\n",
               condition, file, line, context.empty() ? "" : ": ", context.c_str());
  std::fflush(nullptr);
  // Not abort(): the status says "a bug in Colossus", and mpirun ends the other ranks of a rank that exits
  // so.
  std::_Exit(static_cast<int>(Status::kInternal));
}

}  // namespace colossus::core
