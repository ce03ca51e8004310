// Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/render/case_pictures.hpp"

namespace turgor::render_detail {

/// Makes `folder` and writes the pictures into it.
Result<void> write_pictures(const std::vector<Picture>& pictures, const std::filesystem::path& folder,
                            const Context& context);

}  // namespace turgor::render_detail
