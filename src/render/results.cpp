#include "turgor/render/results.hpp"

#include <iterator>

#include "render/picture_files.hpp"
#include "turgor/core/file.hpp"

namespace turgor {

Result<void> write_results(const CaseResults& results, const std::filesystem::path& folder,
                           Context& context) {
  const PictureOptions options;
  std::vector<Picture> pictures;
  if (!results.predictions.empty()) {
    TURGOR_TRY(pictures, prediction_pictures(results.patient, results.predictions.front(), options, context));
  }
  TURGOR_TRY(std::vector<Picture> model, model_pictures(results.patient, options, context));
  std::move(model.begin(), model.end(), std::back_inserter(pictures));

  const Stage stage(context, "files");
  TURGOR_CHECK(write_meshes(results, folder));
  TURGOR_CHECK(render_detail::write_pictures(pictures, folder / "pictures", context));
  const std::string json = result_json(results, context);
  TURGOR_CHECK(write_file(folder / "report.html", report_html(results, pictures, json, context)));
  return write_file(folder / "result.json", json);
}

}  // namespace turgor
