// A patient made of the phantom, for tests of predictions.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "turgor/anatomy/phantom.hpp"
#include "turgor/surgery/operations.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

// The scan of a phantom as a file, for as long as the tests run.
class PhantomFile {
 public:
  PhantomFile()
      : path_(std::filesystem::temp_directory_path() /
              ("turgor_world_" + std::to_string(::getpid()) + ".nrrd")) {
    PhantomParameters parameters;
    parameters.voxel_mm = parameters.slice_mm = 1.2;
    Context context;
    const auto phantom = Phantom::create(parameters);
    const auto scan = phantom->scan(context);
    if (const auto written = write_nrrd(path_, *scan); !written) ADD_FAILURE() << written.error().message();
  }
  ~PhantomFile() { std::filesystem::remove(path_); }
  PhantomFile(const PhantomFile&) = delete;
  PhantomFile& operator=(const PhantomFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline PatientCase phantom_case(const CaseOptions& options) {
  static const PhantomFile file;
  Context context;
  auto opened = PatientCase::open(file.path(), options, context);
  if (!opened) {
    ADD_FAILURE() << opened.error().message();
    std::abort();
  }
  return *std::move(opened);
}

inline const PatientCase& phantom_case() {
  static const PatientCase patient = phantom_case(CaseOptions{});
  return patient;
}

inline Patient patient_of(const PatientCase& c) {
  return {c.head(), c.landmarks()};
}

inline PatientCase with_setback(double mm) {
  PatientCase patient = phantom_case();
  const auto done = sagittal_split(patient.bones(), patient_of(phantom_case()), -mm);
  EXPECT_TRUE(static_cast<bool>(done)) << done.error().message();
  return patient;
}

inline const LandmarkShift& shift_of(const Prediction& p, std::string_view name) {
  for (const LandmarkShift& l : p.landmarks) {
    if (l.name == name) return l;
  }
  ADD_FAILURE() << "no landmark " << name;
  return p.landmarks.front();
}

}  // namespace turgor
