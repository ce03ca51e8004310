#include "mpi_farm.hpp"

#include <cstdlib>
#include <string>

#ifdef TURGOR_MPI
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>
#endif

namespace turgor {
namespace {

// What launchers tell their processes: Open MPI; MPICH, Intel MPI and Slurm; PMIx.
bool started_together() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const char* count = std::getenv(name); count != nullptr) return std::string(count) != "1";
  }
  return std::getenv("PMIX_RANK") != nullptr;
}

}  // namespace
}  // namespace turgor

#ifdef TURGOR_MPI
namespace turgor {
namespace {

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

enum Tag : int {
  hello,   // to 0: samples worked on at once; 0: has ended
  bunch,   // from 0: number of the bunch, how many samples, then their parameters
  answer,  // to 0: their errors
  fault,   // to 0: kind of an error, then its message
  stop,    // from 0: number of the bunch that nobody waits for any more
  quit,    // from 0: this farm is gone
  over,    // from 0: no farm will come any more
};

struct Message {
  int from = 0, tag = 0;
  std::vector<double> values;
};

void send(int to, Tag tag, const std::vector<double>& values) {
  MPI_Send(values.data(), static_cast<int>(values.size()), MPI_DOUBLE, to, tag, MPI_COMM_WORLD);
}

std::optional<Message> receive() {
  int waiting = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &waiting, &status);
  if (waiting == 0) return std::nullopt;
  int count = 0;
  MPI_Get_count(&status, MPI_DOUBLE, &count);
  Message message{status.MPI_SOURCE, status.MPI_TAG, std::vector<double>(at(count))};
  MPI_Recv(message.values.data(), count, MPI_DOUBLE, message.from, message.tag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  return message;
}

std::vector<double> packed(const Error& error) {
  std::vector<double> out{static_cast<double>(error.kind)};
  for (const char c : error.message()) out.push_back(c);
  return out;
}

Error unpacked(const Message& message) {
  Error error{static_cast<ErrorKind>(static_cast<int>(message.values.at(0))), {}};
  for (std::size_t i = 1; i < message.values.size(); ++i)
    error.what.push_back(static_cast<char>(message.values[i]));
  error.where = "process " + std::to_string(message.from);
  return error;
}

using Samples = std::vector<std::vector<double>>;

// This process's threads at work on a bunch, while the thread that made it speaks with the others.
class OwnWork {
 public:
  explicit OwnWork(SampleError sample_error) : farm_(make_thread_farm(std::move(sample_error))) {}
  ~OwnWork() {
    stop();
    if (thread_.joinable()) thread_.join();
  }
  OwnWork(const OwnWork&) = delete;
  OwnWork& operator=(const OwnWork&) = delete;

  [[nodiscard]] int width() const { return farm_->width(); }
  [[nodiscard]] bool busy() const { return thread_.joinable(); }
  void begin(Samples samples) {
    stopped_ = false;
    done_ = false;
    thread_ = std::thread([this, samples = std::move(samples)] {
      result_ = farm_->errors(samples, context_);
      done_ = true;
    });
  }
  void stop() { stopped_ = true; }
  std::optional<Result<std::vector<double>>> take() {
    if (!busy() || !done_) return std::nullopt;
    thread_.join();
    return std::move(result_);
  }

 private:
  std::unique_ptr<SampleFarm> farm_;
  std::atomic<bool> stopped_{false}, done_{false};
  Context context_{{}, {}, [this] { return stopped_.load(); }};
  std::optional<Result<std::vector<double>>> result_;
  std::thread thread_;
};

void tell_all(int count, Tag tag) {
  for (int process = 1; process < count; ++process) send(process, tag, {});
}

// Samples take milliseconds and more.
void wait_a_little() {
  std::this_thread::sleep_for(std::chrono::microseconds(50));
}

class MpiFarm : public SampleFarm {
 public:
  MpiFarm(SampleError sample_error, std::vector<bool>& ended)
      : own_(std::move(sample_error)), widths_(ended.size(), 0) {
    widths_[0] = own_.width();
    for (auto missing = std::count(ended.begin() + 1, ended.end(), false); missing > 0;) {
      if (const auto message = receive()) {
        const double width = message->values.at(0);
        widths_[at(message->from)] = static_cast<int>(width);
        ended[at(message->from)] = width == 0;
        --missing;
      } else {
        wait_a_little();
      }
    }
  }
  ~MpiFarm() override { tell_all(static_cast<int>(widths_.size()), quit); }
  MpiFarm(const MpiFarm&) = delete;
  MpiFarm& operator=(const MpiFarm&) = delete;

  [[nodiscard]] int width() const override {
    int sum = 0;
    for (const int width : widths_) sum += width;
    return sum;
  }

  Result<std::vector<double>> errors(std::span<const std::vector<double>> parameters,
                                     Context& context) override {
    if (std::find(widths_.begin(), widths_.end(), 0) != widths_.end())
      return Error{ErrorKind::system, "a process has ended before the calibration", "MPI",
                   "See what it printed"};
    Batch batch{parameters, std::vector<double>(parameters.size(), std::numeric_limits<double>::quiet_NaN()),
                std::vector<Part>(widths_.size())};
    while (batch.next < parameters.size() || batch.busy > 0) {
      if (!batch.stopping && (context.cancelled() || batch.fault)) stop_all(batch);
      if (batch.stopping) batch.next = parameters.size();
      hand_out(batch);
      if (!take_in(batch)) wait_a_little();
    }
    if (batch.fault) return *std::move(batch.fault);
    return std::move(batch.errors);
  }

 private:
  // Samples `first` to `first + count` of a batch, at one process; none: idle.
  struct Part {
    std::size_t first = 0, count = 0;
    double number = 0;
  };
  struct Batch {
    std::span<const std::vector<double>> samples;
    std::vector<double> errors;
    std::vector<Part> parts;
    std::size_t next = 0;
    int busy = 0;
    bool stopping = false;
    std::optional<Error> fault = {};
  };

  void hand_out(Batch& batch) {
    // The others first: what they are sent travels while this process begins its own.
    for (std::size_t k = 0; k < widths_.size() && batch.next < batch.samples.size(); ++k) {
      const std::size_t process = (k + 1) % widths_.size();
      Part& part = batch.parts[process];
      if (part.count > 0) continue;
      const std::size_t left = batch.samples.size() - batch.next;
      const double share = std::ceil(static_cast<double>(left) * widths_[process] / width());
      part = {batch.next, std::min(static_cast<std::size_t>(share), at(widths_[process])), ++number_};
      batch.next += part.count;
      ++batch.busy;
      begin(process, part, batch.samples.subspan(part.first, part.count));
    }
  }
  void begin(std::size_t process, const Part& part, std::span<const std::vector<double>> samples) {
    if (process == 0) {
      own_.begin({samples.begin(), samples.end()});
      return;
    }
    std::vector<double> values{part.number, static_cast<double>(part.count)};
    for (const auto& sample : samples) values.insert(values.end(), sample.begin(), sample.end());
    send(static_cast<int>(process), bunch, values);
  }

  bool take_in(Batch& batch) {
    bool any = false;
    if (auto own = own_.take()) {
      any = true;
      if (*own) {
        settle(batch, 0, **own);
      } else {
        settle(batch, 0, own->error());
      }
    }
    if (const auto message = receive()) {
      any = true;
      if (message->tag == answer) {
        settle(batch, at(message->from), message->values);
      } else {
        settle(batch, at(message->from), unpacked(*message));
      }
    }
    return any;
  }
  static void settle(Batch& batch, std::size_t process, const std::vector<double>& errors) {
    std::copy(errors.begin(), errors.end(),
              batch.errors.begin() + static_cast<std::ptrdiff_t>(batch.parts[process].first));
    batch.parts[process].count = 0;
    --batch.busy;
  }
  static void settle(Batch& batch, std::size_t process, const Error& error) {
    if (!batch.fault) batch.fault = error;
    batch.parts[process].count = 0;
    --batch.busy;
  }

  void stop_all(Batch& batch) {
    batch.stopping = true;
    own_.stop();
    for (std::size_t process = 1; process < widths_.size(); ++process) {
      if (batch.parts[process].count > 0)
        send(static_cast<int>(process), stop, {batch.parts[process].number});
    }
  }

  OwnWork own_;
  std::vector<int> widths_;
  double number_ = 0;
};

Samples samples_of(const Message& message) {
  const auto count = static_cast<std::size_t>(message.values.at(1));
  const std::size_t size = (message.values.size() - 2) / count;
  Samples out;
  for (auto first = message.values.begin() + 2; first != message.values.end();
       first += static_cast<std::ptrdiff_t>(size))
    out.emplace_back(first, first + static_cast<std::ptrdiff_t>(size));
  return out;
}

}  // namespace

Result<std::unique_ptr<MpiProcesses>> MpiProcesses::join() {
  auto alone = std::unique_ptr<MpiProcesses>(new MpiProcesses);
  if (!started_together()) return alone;
  int provided = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS ||
      provided < MPI_THREAD_FUNNELED)
    return Error{ErrorKind::system, "MPI does not start with threads", "MPI"};
  auto processes = std::move(alone);
  MPI_Comm_rank(MPI_COMM_WORLD, &processes->rank_);
  int count = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  processes->ended_.assign(at(count), false);
  processes->started_ = true;
  return processes;
}

// Every message is received before MPI ends: process 0 waits for the others' last, they for its own.
MpiProcesses::~MpiProcesses() {
  if (!started_) return;
  if (rank_ == 0) {
    tell_all(count(), over);
    ended_[0] = true;
  } else {
    send(0, hello, {0});
  }
  while (rank_ == 0 ? std::find(ended_.begin(), ended_.end(), false) != ended_.end() : !over_) {
    const auto message = receive();
    if (!message) {
      wait_a_little();
    } else if (message->tag == over) {
      over_ = true;
    } else if (message->tag == hello) {
      ended_[at(message->from)] = message->values.at(0) == 0;
    }
  }
  MPI_Finalize();
}

std::unique_ptr<SampleFarm> MpiProcesses::make_farm(SampleError sample_error) {
  if (count() == 1) return make_thread_farm(std::move(sample_error));
  return std::make_unique<MpiFarm>(std::move(sample_error), ended_);
}

Result<void> MpiProcesses::work(SampleError sample_error) {
  if (rank_ == 0) return Error{ErrorKind::internal, "process 0 has nobody to work for"};
  const Error gone{ErrorKind::cancelled, "process 0 has ended"};
  if (over_) return gone;
  OwnWork own(std::move(sample_error));
  send(0, hello, {static_cast<double>(own.width())});
  for (double number = 0;;) {
    const auto message = receive();
    if (message && message->tag == quit) return {};
    if (message && message->tag == over) {
      over_ = true;
      return gone;
    }
    if (message && message->tag == bunch) {
      number = message->values.at(0);
      own.begin(samples_of(*message));
    } else if (message && message->values.at(0) == number) {
      own.stop();
    }
    if (auto done = own.take()) {
      if (*done) {
        send(0, answer, **done);
      } else {
        send(0, fault, packed(done->error()));
      }
    } else if (!message) {
      wait_a_little();
    }
  }
}

}  // namespace turgor
#else
namespace turgor {

Result<std::unique_ptr<MpiProcesses>> MpiProcesses::join() {
  if (started_together())
    return Error{ErrorKind::bad_input,
                 "several processes were started, but this program was built without MPI", "",
                 "Start one, or build with Debian's libopenmpi-dev"};
  return std::unique_ptr<MpiProcesses>(new MpiProcesses);
}

MpiProcesses::~MpiProcesses() = default;

std::unique_ptr<SampleFarm> MpiProcesses::make_farm(SampleError sample_error) {
  return make_thread_farm(std::move(sample_error));
}

Result<void> MpiProcesses::work(SampleError /*sample_error*/) {
  return Error{ErrorKind::internal, "process 0 has nobody to work for"};
}

}  // namespace turgor
#endif
