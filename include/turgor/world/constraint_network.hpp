// The constraint network between things of a scene, `manus` (Pieper 1989, section 4.4).
//
//   link_1 ──moves──► object 3 ──notifies──► who-cares list of object 3 ──► pending queue ──► …
//
// Constraints that wait are served in the order in which they were triggered, breadth first, each at most
// once a frame, so that renormalise() ends on every network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "turgor/core/error.hpp"

namespace turgor {

struct Scene;

/// Something that constraints can depend on. `id` counts within the kind; signals have 0.
struct Node {
  enum class Kind : std::uint8_t { object, sample, device, frame_start, frame_end, time } kind;
  int id = 0;
  bool operator==(const Node&) const = default;
  bool operator<(const Node& other) const { return kind != other.kind ? kind < other.kind : id < other.id; }
};

struct Constraint {
  std::string name;            ///< unique, "link.3"
  std::string kind;            ///< "link", "bobblot" …
  std::vector<Node> triggers;  ///< on whose who-cares lists it stands
  /// Changes the scene; what it changes notifies the network by itself (Scene's setters do).
  std::function<Result<void>(Scene&)> satisfy;
  std::string arguments;           ///< as typed, for listings
  std::vector<Node> changes = {};  ///< what it moves or reshapes: it goes when one of these does
};

/// What a frame's constraints did.
struct ConstraintReport {
  int served = 0;
  /// Each loop by the names along it, the constraint that closed it last: "a → b → a".
  std::vector<std::string> loops;
  /// Errors of single constraints, which leave the others at work.
  std::vector<Error> failures;
};

/// A constraint may add and remove constraints (itself too) and objects while it is served. One that is added
/// while others are served has its first turn in the next frame.
class ConstraintNetwork {
 public:
  /// Returns its name, made unique: as given where that is free, else "NAME.1", "NAME.2" … of its name or,
  /// where that is empty, of its kind.
  std::string add(Constraint constraint);
  /// False where there is none of the name.
  bool remove(const std::string& name);
  /// All that depend on a node that is gone, or change it; returns how many.
  int remove_dependents(Node node);
  /// In the order in which they were added.
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return constraints_; }

  /// Lets every constraint be served again and forgets the report. What waits keeps waiting.
  void begin_frame();
  /// Puts those that care for `node` at the end of the pending queue, unless they had their turn this frame.
  void notify(Node node);
  /// Serves the queue until it is empty. Does nothing where a constraint calls it: the queue is being served.
  void renormalise(Scene& scene);
  [[nodiscard]] const ConstraintReport& report() const { return report_; }

 private:
  /// A constraint's place in the queue of a frame, kept for the chains of loops.
  struct Turn {
    int constraint = 0;  // its number
    std::string name;
    int cause = -1;  // the turn whose change triggered it
  };
  [[nodiscard]] std::size_t index_of(int number) const;  // the size of constraints_ where it is gone
  void serve(const Turn& turn, Scene& scene);
  void close_loop(int turn);

  std::vector<Constraint> constraints_;
  std::vector<int> numbers_;  // of the constraints, ascending, never used twice
  int next_number_ = 0;
  std::map<std::string, int> last_suffix_;
  std::map<Node, std::vector<int>> who_cares_;  // numbers, in the order in which they were added
  std::map<int, int> turn_of_;                  // of the constraints that had or wait for their turn
  std::vector<Turn> turns_;  // of this frame, in order: the queue and what was served of it
  std::size_t served_ = 0;
  int serving_ = -1;  // a turn
  ConstraintReport report_;
};

}  // namespace turgor
