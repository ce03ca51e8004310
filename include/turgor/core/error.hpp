// Failure as a value: what went wrong, where, and what the user can do about it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace turgor {

enum class ErrorKind {
  bad_input,      ///< a file, scan, mesh or number that cannot be used; exit code 2
  bad_command,    ///< a command line or script that cannot be understood; exit code 2
  not_converged,  ///< a body that does not come to rest; exit code 2
  cancelled,      ///< the user stopped the work; exit code 130
  system,         ///< disk full, permission, out of memory; exit code 2
  internal,       ///< a broken invariant of ours; exit code 70
};

/// One clear sentence each. `what` says what is wrong, `where` names the file (and line, column, slice …),
/// `remedy` what to change. Any of the last two may be empty.
struct Error {
  ErrorKind kind = ErrorKind::bad_input;
  std::string what;
  std::string where = {};
  std::string remedy = {};

  /// "where: what. Remedy."
  [[nodiscard]] std::string message() const;
  [[nodiscard]] int exit_code() const;
};

/// A value or an Error. Test it with `if (!result)`, then read `*result` or `result.error()`.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  [[nodiscard]] const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// Success, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}
  explicit operator bool() const { return !error_.has_value(); }
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace turgor

#define TURGOR_CONCAT_INNER(a, b) a##b
#define TURGOR_CONCAT(a, b) TURGOR_CONCAT_INNER(a, b)
/// `TURGOR_TRY(auto mesh, read_mesh(path));` declares `mesh`, or returns the error from the calling function.
#define TURGOR_TRY(declaration, expression) \
  TURGOR_TRY_IMPL(TURGOR_CONCAT(turgor_result_, __LINE__), declaration, expression)
#define TURGOR_TRY_IMPL(name, declaration, expression) \
  auto name = (expression);                            \
  if (!name) return name.error();                      \
  declaration = *std::move(name)
/// The same for Result<void>.
#define TURGOR_CHECK(expression)                                                         \
  do {                                                                                   \
    if (auto turgor_result = (expression); !turgor_result) return turgor_result.error(); \
  } while (false)
