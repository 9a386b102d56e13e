// When the container says something of its build.
#pragma once

namespace colossus::pipeline::facts {

enum class Stored {
  kAlways,
  kUnlessDefault,  // as members of the options, or the counts, are initialised
  kNever,
};

}  // namespace colossus::pipeline::facts
