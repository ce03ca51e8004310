#include "render/picture_files.hpp"

#include <system_error>

#include "turgor/core/file.hpp"

namespace turgor::render_detail {

Result<void> write_pictures(const std::vector<Picture>& pictures, const std::filesystem::path& folder,
                            const Context& context) {
  std::error_code code;
  if (std::filesystem::create_directory(folder, code); code)
    return Error{ErrorKind::system, "the folder cannot be made", folder.string(), "Check its permissions"};
  for (const Picture& picture : pictures) {
    TURGOR_CHECK(context.check());
    TURGOR_CHECK(write_file(folder / (picture.name + ".png"), picture.png));
  }
  return {};
}

}  // namespace turgor::render_detail
