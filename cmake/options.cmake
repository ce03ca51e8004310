# Language, warnings, sanitizers and link options shared by every target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_program(TURGOR_CCACHE ccache)
if(TURGOR_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TURGOR_CCACHE})
endif()

add_library(turgor_options INTERFACE)
target_compile_options(turgor_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
  -Woverloaded-virtual -Wimplicit-fallthrough
  # No contraction and no reassociation: the same bits from debug, release and either compiler.
  -ffp-contract=off
  $<$<BOOL:${TURGOR_WERROR}>:-Werror>)
if(TURGOR_ARCH)
  target_compile_options(turgor_options INTERFACE -march=${TURGOR_ARCH})
endif()
if(TURGOR_SANITIZE)
  target_compile_options(turgor_options INTERFACE -fsanitize=${TURGOR_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(turgor_options INTERFACE -fsanitize=${TURGOR_SANITIZE})
endif()
if(TURGOR_FUZZ)
  target_compile_options(turgor_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

find_program(TURGOR_MOLD NAMES mold ld.lld)
if(TURGOR_MOLD MATCHES "mold$")
  target_link_options(turgor_options INTERFACE -fuse-ld=mold)
elseif(TURGOR_MOLD)
  target_link_options(turgor_options INTERFACE -fuse-ld=lld)
endif()
