// What all harnesses share: the file of states, the comparison with the expected forces, and serving batches.
//
// A harness says `subject NAME DIFFERENCE` for each thing that it can time, the difference being the largest from the
// expected forces, relative, and then `ready`. For each line `NAME COUNT` that it reads it evaluates COUNT states, going
// on through the motion where it stopped the last time, and answers with the nanoseconds for each.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <vector>

namespace peers {

using Numbers = std::vector<double>;

[[noreturn]] inline void fail(const std::string& what) {
  std::cerr << what << std::endl;
  std::exit(1);
}

/// Two points that are one where a loop closes; the indices are the engine's own.
struct Closure {
  int a;
  double at_a[3];
  int b;
  double at_b[3];
};

/// A state of the tree and the forces that belong to it, SI units. Wrenches are [force, moment] about the origin of
/// the engine's body or joint, closing forces act on `b`, all in world axes.
struct State {
  Numbers q, v, a, loads;
  Numbers drives, tree_wrenches, closing_forces;
};

/// The file of states that `states.py` writes for an engine.
struct Motion {
  int nq = 0, nv = 0;
  std::vector<int> driven, undriven, loaded, tree;
  std::vector<Closure> closures;
  std::vector<State> states;

  explicit Motion(std::istream& in) {
    const int count = number(in, "samples");
    in >> nq >> nv;
    driven = list(in, "drives");
    loaded = list(in, "loaded");
    tree = list(in, "tree");
    closures.resize(number(in, "closures"));
    for (Closure& c : closures) {
      in >> c.a >> c.at_a[0] >> c.at_a[1] >> c.at_a[2] >> c.b >> c.at_b[0] >> c.at_b[1] >> c.at_b[2];
    }
    for (int dof = 0; dof < nv; ++dof) {
      bool is_driven = false;
      for (int d : driven) is_driven |= d == dof;
      if (!is_driven) undriven.push_back(dof);
    }
    if (undriven.size() != 3 * closures.size()) fail("the loops do not determine the closing forces");
    states.resize(count);
    for (State& s : states) {
      for (auto [numbers, size] : std::initializer_list<std::pair<Numbers*, size_t>>{
               {&s.q, nq}, {&s.v, nv}, {&s.a, nv}, {&s.loads, 6 * loaded.size()}, {&s.drives, driven.size()},
               {&s.tree_wrenches, 6 * tree.size()}, {&s.closing_forces, 3 * closures.size()}}) {
        numbers->resize(size);
        for (double& x : *numbers) in >> x;
      }
    }
    if (!in) fail("the file of states is not complete");
  }

 private:
  static int number(std::istream& in, const std::string& key) {
    std::string word;
    int value = 0;
    in >> word >> value;
    if (word != key || !in || value < 0) fail("the file of states has no " + key);
    return value;
  }

  static std::vector<int> list(std::istream& in, const std::string& key) {
    std::vector<int> values(number(in, key));
    for (int& value : values) in >> value;
    return values;
  }
};

/// Largest difference, relative to the largest expected value, over a motion.
struct Difference {
  double error = 0.0, size = 0.0;

  void add(double got, double expected) {
    const double difference = std::abs(got - expected);
    // A number that is none must not pass as small.
    error = std::isfinite(difference) ? std::max(error, difference) : INFINITY;
    size = std::max(size, std::abs(expected));
  }

  double relative() const { return error == 0.0 ? 0.0 : error / size; }
};

/// Something that is timed: what it does for a state, and one number of the result, so that no work is left out.
struct Subject {
  std::string name;
  double difference;
  std::function<double(size_t)> evaluate;
};

/// Answers requests until there are no more.
inline void serve(std::vector<Subject> subjects, size_t states) {
  for (const Subject& subject : subjects) std::printf("subject %s %.3e\n", subject.name.c_str(), subject.difference);
  std::printf("ready\n");
  std::fflush(stdout);
  std::map<std::string, size_t> position;
  volatile double sink = 0.0;
  std::string name;
  size_t count = 0;
  while (std::cin >> name >> count) {
    const Subject* subject = nullptr;
    for (const Subject& candidate : subjects) {
      if (candidate.name == name) subject = &candidate;
    }
    if (subject == nullptr || count == 0) fail("no such request: " + name);
    size_t& at = position[name];
    double sum = 0.0;
    const auto begun = std::chrono::steady_clock::now();
    for (size_t i = 0; i < count; ++i) {
      sum += subject->evaluate(at);
      at = at + 1 == states ? 0 : at + 1;
    }
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begun;
    sink = sink + sum;
    std::printf("%.3f\n", taken.count() / double(count));
    std::fflush(stdout);
  }
}

}  // namespace peers
