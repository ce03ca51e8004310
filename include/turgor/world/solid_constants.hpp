// Calibrated constants of a solid, and the file that a calibration leaves and a scene loads: constants.vtu.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"
#include "turgor/tissue/solid.hpp"

namespace turgor {

/// Of edges, triangles and tetrahedra.
inline constexpr std::array<std::string_view, 3> kSolidConstants = {"k_d", "k_a", "k_v"};

/// Stiffness, MPa, of each edge, triangle and tetrahedron in the order of a Solid. Times the rest volume that
/// the element stands for, which set_stiffness() gives with 1 MPa, it is the constant k_d, k_a or k_v in
/// N·mm.
using SolidConstants = std::array<std::vector<double>, 3>;

/// The constants of the elements, each tetrahedron's part of them times its factor: one each, or one for all.
/// On error nothing changes. Errors: other numbers of them than the solid has; those of set_stiffness().
Result<void> set_constants(Solid& solid, std::span<const Vec3> rest, const SolidConstants& constants,
                           std::span<const double> factor);

/// Means over the edges and triangles of each tetrahedron, as set_stiffness() takes them: what another mesh
/// of the same body can take over.
std::vector<SolidStiffness> means_of_tetrahedra(const Solid& solid, const SolidConstants& constants);
/// And back: of each element the mean over the tetrahedra around it by volume. Errors: those of
/// set_stiffness().
Result<SolidConstants> constants_of(const Solid& solid, std::span<const Vec3> rest,
                                    std::span<const SolidStiffness> stiffness);

/// Edges, triangles and tetrahedra as lines, triangles and tetrahedra over the points at rest; of each cell
/// `stiffness_mpa`, `constant_nmm` and `corners` (2, 3 or 4). `solid` has the constants of 1 MPa everywhere.
Result<void> write_solid_constants(const std::filesystem::path& path, std::span<const Vec3> rest,
                                   const Solid& solid, const SolidConstants& constants);
/// Errors, each with the file: those of read_vtu(); no stiffness_mpa; elements that are not, in number and in
/// corners, those of `solid`, so that points may lie elsewhere; a stiffness that is not finite, or below 0.
Result<SolidConstants> read_solid_constants(const std::filesystem::path& path, const Solid& solid);

}  // namespace turgor
