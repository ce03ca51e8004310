#include "fem/rigid_pieces.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

// Squared stiffness against a rigid motion, relative to the stiffest, below which it counts as free.
constexpr double kFree = 1e-11;
// Pieces hinged to one another that are looked at as one mechanism.
constexpr std::size_t kMostHinged = 400;

using Motion = Eigen::Matrix<double, 6, 1>;
using Freedom = Eigen::Matrix<double, 6, 6>;

struct Piece {
  int elements = 0;
  Box3 box;
  Freedom holds = Freedom::Zero();  // GᵀG of what holds it: G m is what a rigid motion m moves
  bool held = false;

  [[nodiscard]] double reach() const { return std::max(0.5 * length(box.size()), 1e-300); }
};

int find(std::vector<int>& parent, int a) {
  while (parent[at(a)] != a) a = parent[at(a)] = parent[at(parent[at(a)])];
  return a;
}

// Number of the piece of each element; returns how many there are.
int number_pieces(const FacePairs& face_pairs, std::vector<int>& piece_of) {
  std::vector<int> parent(piece_of.size());
  std::iota(parent.begin(), parent.end(), 0);
  face_pairs([&](int a, int b) {
    const int x = find(parent, a), y = find(parent, b);
    parent[at(std::max(x, y))] = std::min(x, y);
  });
  int count = 0;
  for (std::size_t e = 0; e < piece_of.size(); ++e) {
    const int root = find(parent, static_cast<int>(e));
    piece_of[e] = root == static_cast<int>(e) ? count++ : piece_of[at(root)];
  }
  return count;
}

// How a rigid motion (shift and turn, scaled to the piece) moves a point along a unit vector.
Motion row(const Piece& piece, const Vec3& point, const Vec3& along) {
  const Vec3 arm = (point - piece.box.centre()) / piece.reach();
  const Vec3 turn = cross(arm, along);
  Motion m;
  m << along.x, along.y, along.z, turn.x, turn.y, turn.z;
  return m;
}

constexpr std::array<Vec3, 3> kAxes = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

bool is_held(const Freedom& holds) {
  const Eigen::SelfAdjointEigenSolver<Freedom> solver(holds, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0] > kFree * solver.eigenvalues()[5];
}

Error free_piece(const Piece& piece, int number, int pieces, const Motion& motion) {
  const Vec3 shift{motion[0], motion[1], motion[2]}, turn{motion[3], motion[4], motion[5]};
  const bool turns = length(turn) > 0.1 * length(shift);
  const Vec3 axis = normalized(turns ? turn : shift), centre = piece.box.centre();
  const std::string which =
      pieces == 1 ? "the body"
                  : fmt::format("piece {} of {}, of {} elements,", number + 1, pieces, piece.elements);
  return {ErrorKind::bad_input,
          fmt::format("{} is not held: it can {} ({:.2g}, {:.2g}, {:.2g})", which,
                      turns ? "turn about" : "move along", axis.x, axis.y, axis.z),
          fmt::format("supports of the piece about ({:g}, {:g}, {:g})", centre.x, centre.y, centre.z),
          "Hold more of its nodes, or leave the piece out"};
}

// A node where pieces meet that share no face there.
struct Hinge {
  int node, a, b;
};

class Pieces {
 public:
  Pieces(std::span<const Vec3> points, std::size_t elements, const ElementCorners& corners,
         const FacePairs& face_pairs)
      : points_(points), piece_of_node_(points.size(), -1) {
    std::vector<int> piece_of(elements);
    pieces_.resize(at(number_pieces(face_pairs, piece_of)));
    for (std::size_t e = 0; e < elements; ++e) {
      Piece& piece = pieces_[at(piece_of[e])];
      ++piece.elements;
      for (const int node : corners(e)) {
        piece.box.extend(points[at(node)]);
        int& of_node = piece_of_node_[at(node)];
        if (of_node < 0) of_node = piece_of[e];
        if (of_node != piece_of[e]) hinges_.push_back({node, of_node, piece_of[e]});
      }
    }
    const auto key = [](const Hinge& h) { return std::array{h.node, h.a, h.b}; };
    std::sort(hinges_.begin(), hinges_.end(),
              [&](const Hinge& x, const Hinge& y) { return key(x) < key(y); });
    hinges_.erase(std::unique(hinges_.begin(), hinges_.end(),
                              [&](const Hinge& x, const Hinge& y) { return key(x) == key(y); }),
                  hinges_.end());
  }

  void hold(std::span<const NodeSupport> supports, std::span<const Contact> contacts) {
    for (const NodeSupport& s : supports)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (s.held[axis]) hold_node(s.node, kAxes[axis]);
    for (const Contact& c : contacts)
      if (c.stiffness_n_mm > 0 || c.adhesion_n_mm > 0) hold_node(c.point, c.normal);
  }

  // Pieces held by themselves, then those hinged to them well enough, and so on.
  void spread() {
    for (Piece& piece : pieces_) piece.held = is_held(piece.holds);
    std::vector<bool> used(hinges_.size(), false);
    for (bool changed = true; changed;) {
      changed = false;
      std::vector<int> touched;
      for (std::size_t h = 0; h < hinges_.size(); ++h) {
        const Hinge& hinge = hinges_[h];
        const bool a = pieces_[at(hinge.a)].held, b = pieces_[at(hinge.b)].held;
        if (used[h] || a == b) continue;
        used[h] = true;
        for (const Vec3& axis : kAxes) hold(a ? hinge.b : hinge.a, hinge.node, axis);
        touched.push_back(a ? hinge.b : hinge.a);
      }
      for (const int p : touched) {
        if (!pieces_[at(p)].held && is_held(pieces_[at(p)].holds)) pieces_[at(p)].held = changed = true;
      }
    }
  }

  // What is left may still hold one another: the stiffness of all their hinges together.
  [[nodiscard]] Result<void> check_rest() const {
    std::vector<int> rest, place(pieces_.size(), -1);
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      if (pieces_[p].held) continue;
      place[p] = static_cast<int>(rest.size());
      rest.push_back(static_cast<int>(p));
    }
    if (rest.empty()) return {};
    const auto n = static_cast<Eigen::Index>(6 * std::min(rest.size(), kMostHinged));
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index r = 0; r < n / 6; ++r)
      all.block<6, 6>(6 * r, 6 * r) = pieces_[at(rest[static_cast<std::size_t>(r)])].holds;
    for (const Hinge& hinge : hinges_) {
      const Eigen::Index a = 6 * place[at(hinge.a)], b = 6 * place[at(hinge.b)];
      if (a < 0 || b < 0 || a >= n || b >= n) continue;
      for (const Vec3& axis : kAxes) {
        const Motion of_a = row(pieces_[at(hinge.a)], points_[at(hinge.node)], axis);
        const Motion of_b = row(pieces_[at(hinge.b)], points_[at(hinge.node)], axis);
        all.block<6, 6>(a, a) += of_a * of_a.transpose();
        all.block<6, 6>(b, b) += of_b * of_b.transpose();
        all.block<6, 6>(a, b) -= of_a * of_b.transpose();
        all.block<6, 6>(b, a) -= of_b * of_a.transpose();
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(all);
    const double stiffest = std::max(solver.eigenvalues()[n - 1], 1e-300);
    if (solver.eigenvalues()[0] > kFree * stiffest && rest.size() <= kMostHinged) return {};
    const Eigen::VectorXd motion = solver.eigenvectors().col(0);
    Eigen::Index most = 0;  // the piece that moves most
    for (Eigen::Index r = 0; r < n / 6; ++r)
      if (motion.segment<6>(6 * r).norm() > 1.001 * motion.segment<6>(6 * most).norm()) most = r;
    const int number = rest[static_cast<std::size_t>(most)];
    return free_piece(pieces_[at(number)], number, static_cast<int>(pieces_.size()),
                      motion.segment<6>(6 * most));
  }

 private:
  void hold_node(int node, const Vec3& along) {
    if (piece_of_node_[at(node)] < 0) return;
    hold(piece_of_node_[at(node)], node, along);
    const auto [first, last] = hinges_at(node);
    for (auto h = first; h != last; ++h) hold(h->b, node, along);
  }
  void hold(int piece, int node, const Vec3& along) {
    const Motion m = row(pieces_[at(piece)], points_[at(node)], along);
    pieces_[at(piece)].holds += m * m.transpose();
  }
  [[nodiscard]] std::pair<std::vector<Hinge>::const_iterator, std::vector<Hinge>::const_iterator> hinges_at(
      int node) const {
    const auto before = [](const Hinge& h, int n) { return h.node < n; };
    const auto first = std::lower_bound(hinges_.begin(), hinges_.end(), node, before);
    return {first, std::lower_bound(first, hinges_.end(), node + 1, before)};
  }

  std::span<const Vec3> points_;
  std::vector<Piece> pieces_;
  std::vector<int> piece_of_node_;  // the first of them
  std::vector<Hinge> hinges_;       // `a` the first piece of the node
};

}  // namespace

Result<void> check_held(std::span<const Vec3> points, std::size_t elements, const ElementCorners& corners,
                        const FacePairs& face_pairs, std::span<const NodeSupport> supports,
                        std::span<const Contact> contacts) {
  Pieces pieces(points, elements, corners, face_pairs);
  pieces.hold(supports, contacts);
  pieces.spread();
  return pieces.check_rest();
}

}  // namespace turgor::detail
