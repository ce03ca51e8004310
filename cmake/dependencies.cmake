# Every third-party library in one place; ./dev installs their Debian packages.
find_package(TBB REQUIRED)
find_package(fmt REQUIRED)
find_package(Eigen3 REQUIRED)
find_package(embree 3 REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
find_package(LibArchive REQUIRED)
find_package(pugixml REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(nanoflann REQUIRED)
find_package(pagmo REQUIRED)

# Calibrations on several machines; without it one process does all.
option(TURGOR_MPI "Share a calibration's samples among processes by MPI, where MPI is found" ON)
if(TURGOR_MPI)
  find_package(MPI COMPONENTS C)
endif()

# JPEG 2000 in DICOM.
add_library(turgor_openjpeg INTERFACE)
find_path(OPENJPEG_INCLUDE openjpeg.h PATH_SUFFIXES openjpeg-2.5 openjpeg-2.4 REQUIRED)
find_library(OPENJPEG_LIBRARY openjp2 REQUIRED)
target_include_directories(turgor_openjpeg SYSTEM INTERFACE ${OPENJPEG_INCLUDE})
target_link_libraries(turgor_openjpeg INTERFACE ${OPENJPEG_LIBRARY})

if(TURGOR_TESTS)
  # An independent DICOM writer and reader to test ours against; the program itself does without it, because it aborts
  # on damaged files. Debian's CMake package asks for the tools of every language binding; the libraries will do.
  add_library(turgor_gdcm INTERFACE)
  find_path(GDCM_INCLUDE gdcmImageReader.h PATH_SUFFIXES gdcm-3.0 REQUIRED)
  target_include_directories(turgor_gdcm SYSTEM INTERFACE ${GDCM_INCLUDE})
  foreach(part MSFF DICT IOD DSED Common)
    string(TOLOWER ${part} lower)
    find_library(GDCM_${part} NAMES gdcm${part} REQUIRED)
    target_link_libraries(turgor_gdcm INTERFACE ${GDCM_${part}})
  endforeach()
endif()
