// The name that somebody may have meant.
#pragma once

#include <span>
#include <string_view>

namespace turgor {

/// The candidate nearest to `word` by edit distance (a swap of neighbours counts once; case and - against _
/// count nothing), or empty where none is near.
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace turgor
