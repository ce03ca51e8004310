// Small pieces of HTML. Internal to render.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace turgor::html {

std::string escape(std::string_view text);
/// data:image/png;base64,…
std::string data_url(const std::vector<std::byte>& png);
/// A table with a header row; cells are HTML already.
std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
std::string figure(const std::vector<std::byte>& png, std::string_view caption);

}  // namespace turgor::html
