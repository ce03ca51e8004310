// Reads every #include of the project against the order of its layers (docs/architecture.md).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace {
namespace fs = std::filesystem;

// What each module may use directly; use is transitive.
const std::map<std::string, std::vector<std::string>>& allowed_directly() {
  static const std::map<std::string, std::vector<std::string>> table{
      {"core", {}},
      {"math", {"core"}},
      {"geometry", {"math"}},
      {"imaging", {"geometry"}},
      {"tissue", {"math"}},
      {"fem", {"geometry", "tissue"}},
      {"dynamics", {"fem"}},
      {"anatomy", {"geometry", "imaging", "tissue"}},
      {"muscles", {"anatomy", "dynamics"}},
      {"surgery", {"anatomy", "dynamics"}},
      {"calibration", {"math", "tissue"}},
      {"world", {"muscles", "surgery", "calibration"}},
      {"commands", {"world"}},
      {"render", {"world"}},
      {"server", {"commands", "render"}},
      {"apps", {"server"}},
  };
  return table;
}

std::set<std::string> allowed(const std::string& module) {
  std::set<std::string> out{module};
  for (const std::string& used : allowed_directly().at(module)) out.merge(allowed(used));
  return out;
}

std::vector<std::string> includes(const fs::path& file) {
  std::vector<std::string> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const auto hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line.compare(hash, 8, "#include") != 0) continue;
    const auto open = line.find_first_of("<\"");
    const auto close = line.find_first_of(">\"", open + 1);
    if (open != std::string::npos && close != std::string::npos)
      out.push_back(line.substr(open + 1, close - open - 1));
  }
  return out;
}

std::string module_of(const std::string& include) {
  constexpr std::string_view prefix = "turgor/";
  if (include.compare(0, prefix.size(), prefix) != 0) return {};
  return include.substr(prefix.size(), include.find('/', prefix.size()) - prefix.size());
}

template <class Visit>
int each_source(const fs::path& folder, Visit&& visit) {
  int count = 0;
  if (!fs::exists(folder)) return 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (!entry.is_regular_file() || (extension != ".cpp" && extension != ".hpp")) continue;
    visit(entry.path());
    ++count;
  }
  return count;
}

const fs::path root = TURGOR_SOURCE_DIR;

TEST(Layering, EveryIncludeFollowsTheOrderOfTheModules) {
  int files = 0;
  for (const auto& [module, unused] : allowed_directly()) {
    const std::set<std::string> may_use = allowed(module);
    const auto check = [&, &name = module](const fs::path& file) {
      for (const std::string& include : includes(file)) {
        const std::string used = module_of(include);
        if (used.empty()) continue;
        EXPECT_TRUE(may_use.contains(used))
            << file << " includes " << include << ", but " << name << " may not use " << used;
      }
    };
    files += each_source(root / "include/turgor" / module, check) + each_source(root / "src" / module, check);
    if (module == "apps") files += each_source(root / "apps", check);
  }
  EXPECT_GT(files, 50);
}

TEST(Layering, EveryFolderIsAKnownModule) {
  for (const char* parent : {"include/turgor", "src"}) {
    for (const auto& entry : fs::directory_iterator(root / parent)) {
      EXPECT_TRUE(allowed_directly().contains(entry.path().filename().string())) << entry.path();
    }
  }
}

TEST(Layering, PublicHeadersShowNoThirdPartyLibrary) {
  const std::vector<std::string> hidden{
      "embree3/",  "gdcm",    "Eigen/", "tbb/",   "nlohmann/", "png.h",  "meshoptimizer.h",
      "archive.h", "pugixml", "nifti",  "zlib.h", "fmt/",      "pagmo/", "mpi.h"};
  each_source(root / "include", [&](const fs::path& file) {
    for (const std::string& include : includes(file)) {
      for (const std::string& library : hidden) {
        EXPECT_NE(include.compare(0, library.size(), library), 0) << file << " shows " << include;
      }
    }
  });
}

}  // namespace
