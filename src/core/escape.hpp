// Texts for places where only UTF-8 may stand: JSON, and the tables of a container.
#pragma once

#include <string>
#include <string_view>

namespace colossus::core {

// A text of valid UTF-8 as it is. In any other, as the name of a file may be, each byte that is part of no
// valid sequence becomes \xNN (lower case hexadecimal) and each backslash becomes two. (A valid name that
// looks like such a text is the same text; nobody has to read it back.)
std::string escaped_text(std::string_view text);

// All texts in a JSON value, and the names of its members.
template <typename Json>
Json with_escaped_texts(const Json& json) {
  if (json.is_string()) return escaped_text(json.template get_ref<const std::string&>());
  if (!json.is_structured()) return json;
  Json result = json.is_array() ? Json::array() : Json::object();
  for (const auto& item : json.items()) {
    if (json.is_array())
      result.push_back(with_escaped_texts(item.value()));
    else
      result[escaped_text(item.key())] = with_escaped_texts(item.value());
  }
  return result;
}

}  // namespace colossus::core
