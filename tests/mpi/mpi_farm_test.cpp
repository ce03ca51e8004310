// Starts a calibration as one, two and three processes.
#include <gtest/gtest.h>

#include <string>

#include "support/shell.hpp"

namespace {

using turgor::support::Outcome;
using turgor::support::shell;

// What hangs is ended with code 124.
Outcome together(int processes, const std::string& mode) {
  const std::string launcher = processes == 1 ? ""
                                              : "mpirun -n " + std::to_string(processes) +
                                                    " --oversubscribe --allow-run-as-root --bind-to none ";
  return shell("timeout 20 " + launcher + TURGOR_FARM_PROGRAM + " " + mode + " 2>&1");
}

class MpiFarm : public ::testing::Test {
 protected:
  void SetUp() override {
#ifndef TURGOR_MPI
    GTEST_SKIP() << "built without MPI";
#endif
    if (shell("mpirun --version 2>&1").code != 0) GTEST_SKIP() << "there is no mpirun (Debian's openmpi-bin)";
  }
};

TEST_F(MpiFarm, GivesTheSameBitsForOneTwoAndThreeProcesses) {
  const Outcome alone = together(1, "fit");
  ASSERT_EQ(alone.code, 0) << alone.text;
  EXPECT_NE(alone.text.find("annealing 201 samples"), std::string::npos) << alone.text;
  for (const int processes : {2, 3}) {
    const Outcome several = together(processes, "fit");
    EXPECT_EQ(several.code, 0) << processes;
    EXPECT_EQ(several.text, alone.text) << processes;
  }
}

TEST_F(MpiFarm, AFaultOfOneProcessEndsTheCalibrationWithItsWords) {
  const Outcome outcome = together(3, "fault");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_NE(outcome.text.find("process 1: the disk is full"), std::string::npos) << outcome.text;
  EXPECT_NE(outcome.text.find("annealing 201 samples"), std::string::npos)
      << "and the farm is in order afterwards: " << outcome.text;
}

TEST_F(MpiFarm, AStopReachesAllProcesses) {
  const Outcome outcome = together(3, "stop");
  EXPECT_EQ(outcome.code, 0) << outcome.text;
  EXPECT_NE(outcome.text.find(", stopped"), std::string::npos) << outcome.text;
}

TEST_F(MpiFarm, NobodyWaitsForAProcessThatHasEnded) {
  const Outcome unused = together(3, "unused");
  EXPECT_EQ(unused.code, 0) << unused.text;
  const Outcome early = together(3, "early");
  EXPECT_EQ(early.code, 0) << early.text;
  EXPECT_NE(early.text.find("a process has ended before"), std::string::npos) << early.text;
}

}  // namespace
