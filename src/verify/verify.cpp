#include "verify/verify.hpp"

#include "verify/blocks/verify.hpp"
#include "verify/diamonds/verify.hpp"

namespace colossus::verify {

measure::VerifyReport verify(const reader::AnyStatue& statue, const measure::VerifyOptions& options) {
  struct Visit {
    const measure::VerifyOptions& options;
    measure::VerifyReport operator()(const std::unique_ptr<reader::diamonds::Statue>& s) const {
      return diamonds::verify(*s, options);
    }
    measure::VerifyReport operator()(const std::unique_ptr<reader::blocks::CubeStatue>& s) const {
      return blocks::verify(*s, options);
    }
  };
  return std::visit(Visit{options}, statue);
}

}  // namespace colossus::verify
