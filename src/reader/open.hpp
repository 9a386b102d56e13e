// Opens a container of any scheme: the one place that looks at which it is.
#pragma once

#include <filesystem>
#include <memory>
#include <variant>

#include "reader/cube_statue.hpp"
#include "reader/statue.hpp"

namespace colossus::reader {

// Never empty. cut_at_level(), assemble(), verify() and so on are overloaded for both: use std::visit.
using AnyStatue = std::variant<std::unique_ptr<Statue>, std::unique_ptr<CubeStatue>>;

// Throws Error(kBadData) like their constructors, and for an unknown scheme.
AnyStatue open(const std::filesystem::path& path, const StatueOptions& options = {});

}  // namespace colossus::reader
