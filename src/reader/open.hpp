// Opens a container of any scheme: the one place that looks at which it is.
#pragma once

#include <filesystem>
#include <memory>
#include <variant>

#include "reader/blocks/statue.hpp"
#include "reader/diamonds/statue.hpp"

namespace colossus::reader {

// Never empty. cut_at_level(), assemble(), verify() and so on are overloaded for both: use std::visit.
using AnyStatue = std::variant<std::unique_ptr<diamonds::Statue>, std::unique_ptr<blocks::CubeStatue>>;

// Throws Error(kBadData) like their constructors, and for an unknown scheme.
AnyStatue open(const std::filesystem::path& path, const access::StatueOptions& options = {});

}  // namespace colossus::reader
