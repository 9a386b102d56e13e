// Opens a container of any scheme.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "reader/access/statue.hpp"

namespace colossus::reader {

// What the reader knows of a scheme.
struct Scheme {
  const char* name;
  std::unique_ptr<access::Statue> (*open)(container::ContainerReader container,
                                          const access::StatueOptions& options);
};

// All of them. A new one is a folder beside reader/diamonds, and a line in schemes.cpp.
std::span<const Scheme> schemes();

// Never empty. Throws Error(kBadData) like the statues' constructors, and for an unknown scheme.
std::unique_ptr<access::Statue> open(const std::filesystem::path& path,
                                     const access::StatueOptions& options = {});

}  // namespace colossus::reader
