// Runs the program as a user does.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "support/shell.hpp"

namespace turgor_program {
namespace fs = std::filesystem;

using turgor::support::Outcome;

/// Both streams of the program are in the text.
inline Outcome run(const std::string& arguments) {
  // What hangs is ended with code 124.
  return turgor::support::shell("timeout 120 " TURGOR_PROGRAM " " + arguments + " 2>&1");
}

inline std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Starts the program, asks it to stop after `delay`, and returns how long it took to; its code in `code`.
inline double seconds_to_stop(const std::vector<std::string>& arguments, std::chrono::milliseconds delay,
                              int& code) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::freopen("/dev/null", "w", stdout);
    std::freopen("/dev/null", "w", stderr);
    std::vector<char*> words{const_cast<char*>(TURGOR_PROGRAM)};
    for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
    words.push_back(nullptr);
    ::execv(TURGOR_PROGRAM, words.data());
    ::_exit(99);
  }
  std::this_thread::sleep_for(delay);
  const auto asked = std::chrono::steady_clock::now();
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count();
}

}  // namespace turgor_program
