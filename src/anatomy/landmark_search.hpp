// The two halves of the landmark search: bone first, then skin from what the bone tells.
#pragma once

#include "anatomy/face_probe.hpp"
#include "turgor/anatomy/head.hpp"

namespace turgor {

/// Landmarks in face coordinates while they are being searched.
using FacePoints = std::map<std::string, Vec3, std::less<>>;

/// Height of the middle of the orbits, seen as deep windows on either side; none where there are none.
std::optional<double> find_orbit_height(const FaceProbe& skull);

/// `lowest_seen` is the z below which the scan ends: what reaches down to it is not shown whole.
FacePoints find_bone_landmarks(const FaceProbe& skull, const FaceProbe& mandible, double orbit_height,
                               double lowest_seen);
FacePoints find_skin_landmarks(const FaceProbe& skin, const FacePoints& bone, double orbit_height,
                               double lowest_seen);

}  // namespace turgor
