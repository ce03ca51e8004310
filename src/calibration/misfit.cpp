#include "calibration/misfit.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

namespace turgor {
namespace {

using Places = Eigen::Matrix3Xd;

Places places(const std::vector<Vec3>& points) {
  Places out(3, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    out.col(column) << points[i].x, points[i].y, points[i].z;
  }
  return out;
}

Result<void> check_lengths(const ReferenceLoad& load, const Response& response, ErrorMeasure measure) {
  const Response& reference = load.reference;
  if (reference.position_mm.size() != response.position_mm.size() ||
      reference.force_n.size() != response.force_n.size())
    return Error{ErrorKind::bad_input, "the response and its reference are of other lengths", load.name};
  const bool empty =
      measure == ErrorMeasure::force ? reference.force_n.empty() : reference.position_mm.empty();
  if (empty) return Error{ErrorKind::bad_input, "the reference has nothing to measure", load.name};
  if (!load.weight.empty() && load.weight.size() != reference.position_mm.size())
    return Error{ErrorKind::bad_input, "there are not as many weights as points", load.name};
  return {};
}

// Of each point, summing to 1.
Result<Eigen::VectorXd> shares(const ReferenceLoad& load) {
  const auto points = static_cast<Eigen::Index>(load.reference.position_mm.size());
  if (load.weight.empty()) return Eigen::VectorXd::Constant(points, 1.0 / static_cast<double>(points)).eval();
  Eigen::VectorXd out = Eigen::VectorXd::Map(load.weight.data(), points);
  const double most = out.maxCoeff();
  if (!out.allFinite() || out.minCoeff() < 0 || most <= 0)
    return Error{ErrorKind::bad_input, "weights must be finite, at least 0, and not all 0", load.name};
  out /= most;
  return (out / out.sum()).eval();
}

// The rotation that brings the centred places `from` nearest to `to` (Kabsch 1976), no reflection.
Eigen::Matrix3d nearest_rotation(const Places& from, const Places& to, const Eigen::VectorXd& share) {
  const Eigen::Matrix3d moment = from * share.asDiagonal() * to.transpose();
  if (!moment.allFinite()) return Eigen::Matrix3d::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  const Eigen::Matrix3d& v = svd.matrixV();
  if ((v * u.transpose()).determinant() < 0) u.col(2) *= -1;
  return v * u.transpose();
}

// Three shifts and three rotations about the centre, on the scaled residual; fewer where points are in line.
Eigen::MatrixXd rigid_modes(const Places& centred, const Eigen::VectorXd& scale) {
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(scale.size(), 6);
  for (Eigen::Index i = 0; i < centred.cols(); ++i) {
    const Eigen::Vector3d p = centred.col(i);
    modes.block<3, 3>(3 * i, 0).setIdentity();
    for (Eigen::Index k = 0; k < 3; ++k) modes.block<3, 1>(3 * i, 3 + k) = Eigen::Vector3d::Unit(k).cross(p);
  }
  modes = scale.asDiagonal() * modes;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(modes);
  return qr.householderQ() * Eigen::MatrixXd::Identity(modes.rows(), qr.rank());
}

Misfit force_misfit(const Response& reference, const Response& response) {
  Misfit out;
  out.measure = ErrorMeasure::force;
  const auto rows = static_cast<Eigen::Index>(reference.force_n.size());
  out.scale = Eigen::VectorXd::Constant(rows, 1 / std::sqrt(static_cast<double>(rows)));
  out.residual = out.scale.cwiseProduct(Eigen::VectorXd::Map(response.force_n.data(), rows) -
                                        Eigen::VectorXd::Map(reference.force_n.data(), rows));
  return out;
}

}  // namespace

double Misfit::error() const {
  const double norm = residual.norm();
  return std::isfinite(norm) ? norm : std::numeric_limits<double>::infinity();
}

Eigen::MatrixXd Misfit::jacobian(const DenseMatrix& response) const {
  const auto rows = static_cast<Eigen::Index>(response.rows);
  const auto columns = static_cast<Eigen::Index>(response.columns);
  const Eigen::Map<const Eigen::MatrixXd> all(response.values.data(), rows, columns);
  if (measure == ErrorMeasure::force) return scale.asDiagonal() * all.bottomRows(scale.size());
  Eigen::MatrixXd out = scale.asDiagonal() * all.topRows(scale.size());
  if (measure == ErrorMeasure::distance) return out;
  for (Eigen::Index i = 0; i < out.rows(); i += 3)
    out.middleRows<3>(i) = (rotation * out.middleRows<3>(i)).eval();
  out -= rigid * (rigid.transpose() * out);
  return out;
}

std::vector<double> Misfit::error_gradient(std::size_t rows) const {
  std::vector<double> out(rows, 0.0);
  const double norm = error();
  if (!(norm > 0) || !std::isfinite(norm)) return out;
  Eigen::VectorXd seed = scale.cwiseProduct(residual) / norm;
  if (measure == ErrorMeasure::shape) {
    for (Eigen::Index i = 0; i < seed.size(); i += 3)
      seed.segment<3>(i) = (rotation.transpose() * seed.segment<3>(i)).eval();
  }
  const auto first = measure == ErrorMeasure::force ? rows - static_cast<std::size_t>(seed.size()) : 0;
  for (Eigen::Index i = 0; i < seed.size(); ++i) out[first + static_cast<std::size_t>(i)] = seed[i];
  return out;
}

Result<Misfit> misfit_of(const ReferenceLoad& load, const Response& response, ErrorMeasure measure) {
  TURGOR_CHECK(check_lengths(load, response, measure));
  if (measure == ErrorMeasure::force) return force_misfit(load.reference, response);
  TURGOR_TRY(const Eigen::VectorXd share, shares(load));
  Places from = places(response.position_mm), to = places(load.reference.position_mm);
  Misfit out;
  out.measure = measure;
  out.scale.resize(3 * share.size());
  for (Eigen::Index i = 0; i < share.size(); ++i)
    out.scale.segment<3>(3 * i).setConstant(std::sqrt(share[i]));
  if (measure == ErrorMeasure::shape) {
    from.colwise() -= (from * share).eval();
    to.colwise() -= (to * share).eval();
    out.rotation = nearest_rotation(from, to, share);
    from = out.rotation * from;
    if (from.allFinite()) out.rigid = rigid_modes(from, out.scale);
  }
  const Places difference = from - to;
  out.residual = out.scale.cwiseProduct(Eigen::VectorXd::Map(difference.data(), difference.size()));
  return out;
}

Result<double> response_error(const ReferenceLoad& load, const Response& response, ErrorMeasure measure) {
  TURGOR_TRY(const Misfit misfit, misfit_of(load, response, measure));
  return misfit.error();
}

}  // namespace turgor
