#include "values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "text.hpp"
#include "units.hpp"

namespace turgor::commands {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

constexpr const char* kUnholdable = "Write a number that a computer can hold";
constexpr double kFarthest = 1e6;  // mm; keeps products of coordinates far from overflow

class Converter {
 public:
  Converter(const CommandDeclaration& command, const Parameter& parameter)
      : command_(command), parameter_(parameter) {}

  Result<Argument> run(std::span<const Word> words) {
    argument_.place = words.front().place;
    for (const Word& word : words) {
      if (is_numeric(parameter_.type)) {
        TURGOR_CHECK(add_number(word));
      } else {
        TURGOR_CHECK(add_word(word));
      }
    }
    TURGOR_CHECK(check_shape());
    return std::move(argument_);
  }

 private:
  [[nodiscard]] std::string who() const {
    return fmt::format("{} of '{}'", title(parameter_), command_.name);
  }
  static Error fault(const Word& word, std::string what, std::string remedy) {
    return {ErrorKind::bad_command, std::move(what), word.place.text(), std::move(remedy)};
  }
  [[nodiscard]] Error expected(const Word& word, std::string remedy) const {
    return fault(word,
                 fmt::format("{} must be {}, found {}", who(), describe_value(parameter_), shown(word.text)),
                 std::move(remedy));
  }

  Result<void> add_word(const Word& word) {
    const bool blank = word.text.find_first_not_of(" \t") == std::string::npos;
    if (parameter_.type != ValueType::text && blank)
      return expected(word, "Write something between the quotes");
    if (parameter_.type == ValueType::word && word.text.find_first_of(" \t") != std::string::npos) {
      return expected(word, "Write a name without blanks, for instance with _ in their place");
    }
    if (parameter_.type == ValueType::choice &&
        std::ranges::find(parameter_.choices, word.text) == parameter_.choices.end()) {
      return expected(word, suggestion("word", word.text, parameter_.choices,
                                       fmt::format("'turgor help {}' lists them", command_.name)));
    }
    argument_.words.push_back(word.text);
    return {};
  }

  /// Why a word that should be a number is not one, where it can be told.
  [[nodiscard]] std::string number_remedy(std::string_view text) const {
    for (const std::string_view dash : {"−", "–", "—"}) {
      if (text.starts_with(dash)) return "Write the minus sign as -";
    }
    const auto comma = text.find(',');
    if (comma != std::string_view::npos && comma > 0 && is_digit(text[comma - 1])) {
      return "Write a decimal point, not a comma, and part numbers with blanks";
    }
    return fmt::format("Write {}", describe_value(parameter_));
  }

  Result<void> add_number(const Word& word) {
    std::string_view text = word.text;
    if (text.starts_with('+')) text.remove_prefix(1);
    const std::string_view digits =
        text.starts_with('-') && text.size() == word.text.size() ? text.substr(1) : text;
    const bool numeric = !digits.empty() && (is_digit(digits[0]) ||
                                             (digits.size() > 1 && digits[0] == '.' && is_digit(digits[1])));
    if (!numeric) return expected(word, number_remedy(word.text));
    return parameter_.type == ValueType::integer ? add_integer(word, text) : add_real(word, text);
  }

  Result<void> add_integer(const Word& word, std::string_view text) {
    std::int64_t value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code == std::errc::result_out_of_range) return expected(word, "Write a smaller number");
    std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
    const auto known = suffixes(parameter_.unit);
    if (!known.empty() && suffix == known.front().text) suffix = {};
    if (!suffix.empty()) return expected(word, number_remedy(word.text));
    TURGOR_CHECK(check_range(word, static_cast<double>(value)));
    argument_.integers.push_back(value);
    return {};
  }

  Result<void> add_real(const Word& word, std::string_view text) {
    double value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code == std::errc::result_out_of_range) return expected(word, kUnholdable);
    const std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
    if (!suffix.empty()) {
      TURGOR_TRY(value, with_suffix(word, value, suffix));
    }
    if (!std::isfinite(value)) return expected(word, kUnholdable);
    TURGOR_CHECK(check_range(word, value));
    argument_.numbers.push_back(value);
    return {};
  }

  /// The unit of the next number: of shapes, positions are in mm and directions have none.
  [[nodiscard]] Unit unit() const {
    switch (parameter_.type) {
      case ValueType::direction:
        return Unit::none;
      case ValueType::plane:
      case ValueType::axis:
        return argument_.numbers.size() < 3 ? Unit::mm : Unit::none;
      case ValueType::number:
        return parameter_.unit;
      default:
        return Unit::mm;
    }
  }

  Result<double> with_suffix(const Word& word, double value, std::string_view suffix) const {
    const auto known = suffixes(unit());
    for (const Suffix& s : known) {
      if (s.text == suffix) return value * s.times / s.over;
    }
    std::vector<std::string> names;
    for (const Suffix& s : known) names.emplace_back(s.text);
    if (value != 0 && suffix.starts_with(',')) return expected(word, number_remedy(word.text));
    return expected(word, names.empty() ? "Write the number without " + shown(suffix)
                                        : "Write it without a unit, or with " + join_alternatives(names));
  }

  Result<void> check_range(const Word& word, double value) const {
    const bool coordinate = parameter_.type > ValueType::number && unit() == Unit::mm;
    if (coordinate && std::abs(value) > kFarthest) {
      return fault(word,
                   fmt::format("{}: {} mm is farther than {} mm from the origin", who(), value, kFarthest),
                   "Write millimetres in the scan's patient coordinates");
    }
    if (parameter_.range.contains(value)) return {};
    const std::string_view unit_symbol = parameter_.unit == Unit::fraction ? "" : symbol(parameter_.unit);
    return fault(word,
                 fmt::format("{} must be {}{}{}, found {}", who(), describe_range(parameter_),
                             unit_symbol.empty() ? "" : " ", unit_symbol, shown(word.text)),
                 "Choose a value in that range");
  }

  /// What several numbers must be together. `where` is the first word's place.
  Result<void> check_shape() const {
    const auto& n = argument_.numbers;
    const auto fail = [&](std::string_view what, std::string remedy) -> Result<void> {
      return Error{ErrorKind::bad_command, fmt::format("{}: {}", who(), what), argument_.place.text(),
                   std::move(remedy)};
    };
    const auto zero = [&](std::size_t at) { return n[at] == 0 && n[at + 1] == 0 && n[at + 2] == 0; };
    switch (parameter_.type) {
      case ValueType::direction:
        if (zero(0)) return fail("the direction is zero", "Write a direction such as 0 0 1");
        break;
      case ValueType::plane:
        if (zero(3)) return fail("the plane's normal is zero", "Write a normal such as 0 0 1");
        break;
      case ValueType::axis:
        if (zero(3)) return fail("the axis's direction is zero", "Write a direction such as 0 0 1");
        break;
      case ValueType::box:
        for (std::size_t i = 0; i < 3; ++i) {
          if (n[i] >= n[i + 3]) {
            return fail(fmt::format("the box's lower {0} ({1}) is not below its upper {0} ({2})", "xyz"[i],
                                    n[i], n[i + 3]),
                        "Write the lower corner first");
          }
        }
        break;
      case ValueType::sphere:
        if (n[3] <= 0) return fail("the sphere's radius is not above 0", "Write the centre, then the radius");
        break;
      default:
        break;
    }
    return {};
  }

  const CommandDeclaration& command_;
  const Parameter& parameter_;
  Argument argument_;
};

}  // namespace

Result<Argument> convert(const CommandDeclaration& command, const Parameter& parameter,
                         std::span<const Word> words) {
  return Converter(command, parameter).run(words);
}

std::string suggestion(std::string_view kind, std::string_view word,
                       std::span<const std::string_view> candidates, std::string_view otherwise) {
  if (const auto nearest = nearest_word(word, candidates); !nearest.empty()) {
    return fmt::format("The nearest {} is '{}'", kind, nearest);
  }
  constexpr std::size_t few = 12;
  if (candidates.empty() || candidates.size() > few) return std::string(otherwise);
  const std::vector<std::string> all(candidates.begin(), candidates.end());
  return "Write " + join_alternatives(all);
}

SpringLaw law_named(std::string_view word) {
  if (word == "exponential" || word == "1") return SpringLaw::exponential;
  if (word == "logarithmic" || word == "2") return SpringLaw::logarithmic;
  if (word == "square" || word == "3") return SpringLaw::square;
  if (word == "collagen") return SpringLaw::collagen;
  if (word == "hookean") return SpringLaw::hookean;
  return SpringLaw::linear;
}

}  // namespace turgor::commands
