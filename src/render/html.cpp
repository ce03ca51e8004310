#include "html.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>

namespace turgor::html {
namespace {

std::string base64(const std::vector<std::byte>& bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8 | (i + k < bytes.size() ? static_cast<std::uint32_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : digits[word >> (18 - 6 * k) & 63U];
    }
  }
  return out;
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string data_url(const std::vector<std::byte>& png) {
  return "data:image/png;base64," + base64(png);
}

std::string section(std::string_view title, const std::string& body) {
  return fmt::format("<section><h2>{}</h2>\n{}</section>\n", title, body);
}

std::string table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<table><thead><tr>";
  for (const std::string& h : header) out += "<th>" + h + "</th>";
  out += "</tr></thead><tbody>";
  for (const auto& row : rows) {
    out += "<tr>";
    for (const std::string& cell : row) out += "<td>" + cell + "</td>";
    out += "</tr>";
  }
  return out + "</tbody></table>\n";
}

std::string figure(const std::vector<std::byte>& png, std::string_view caption, std::string_view kind) {
  const std::string open = kind.empty() ? "<figure>" : "<figure class=\"" + std::string(kind) + "\">";
  return open + "<img src=\"" + data_url(png) + "\" alt=\"" + escape(caption) + "\"><figcaption>" +
         escape(caption) + "</figcaption></figure>\n";
}

std::string run_details(const Context& context, std::string_view json) {
  std::string out = "<details><summary>Notices, timing, every number</summary><ul>";
  for (const Notice& n : context.notices()) out += "<li>" + escape(n.text) + "</li>";
  out += "</ul>";
  std::vector<std::vector<std::string>> rows;
  for (const StageTime& t : context.stage_times())
    rows.push_back({escape(t.stage), fmt::format("{:.2f}", t.seconds)});
  return out + table({"Step", "seconds"}, rows) + "<pre>" + escape(json) + "</pre></details>\n";
}

}  // namespace turgor::html
