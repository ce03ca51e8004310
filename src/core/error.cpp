#include "turgor/core/error.hpp"

namespace turgor {

std::string Error::message() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (text.empty() || text.back() != '.') text += '.';
  if (!remedy.empty()) {
    text += ' ' + remedy;
    if (text.back() != '.') text += '.';
  }
  return text;
}

int Error::exit_code() const {
  switch (kind) {
    case ErrorKind::cancelled:
      return 130;
    case ErrorKind::internal:
      return 70;
    default:
      return 2;
  }
}

}  // namespace turgor
