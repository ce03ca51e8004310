// Small pieces of HTML. Internal to render.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/context.hpp"

namespace turgor::html {

std::string escape(std::string_view text);
/// data:image/png;base64,…
std::string data_url(const std::vector<std::byte>& png);
std::string section(std::string_view title, const std::string& body);
/// A table with a header row; cells are HTML already.
std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
/// `kind`: a class of the report's style, or none.
std::string figure(const std::vector<std::byte>& png, std::string_view caption, std::string_view kind = {});
/// Folded away: notices, seconds of each stage, and all that the run's JSON says.
std::string run_details(const Context& context, std::string_view json);

}  // namespace turgor::html
