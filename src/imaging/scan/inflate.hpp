// zlib at the boundary: gzip and zlib streams in, gzip out.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/context.hpp"

namespace turgor::scan_io {

enum class Deflate { gzip_or_zlib, raw };

struct Inflated {
  std::vector<std::byte> bytes;
  bool damaged = false;  ///< the stream is broken or ends early; `bytes` holds what came before
};
/// Inflates until `max_bytes` are there or the stream ends (further gzip members follow on), or until
/// `context` is cancelled. Memory grows with what is really inflated.
Inflated inflate_bytes(std::span<const std::byte> compressed, std::size_t max_bytes,
                       Deflate kind = Deflate::gzip_or_zlib, const Context* context = nullptr);

/// A single gzip member, compressed in parallel; the same bytes for any number of threads.
std::vector<std::byte> gzip_bytes(std::span<const std::byte> bytes, int level);

}  // namespace turgor::scan_io
