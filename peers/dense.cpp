// One factorisation and solution of a dense 42 x 42 system: the number of Newton-Euler equations of a 3-RPS robot with
// seven bodies. What a program spends that writes them all down and hands them to a library, before and after it has.
#include <Eigen/Dense>
#include <random>

#include "harness.hpp"

using namespace peers;

int main() {
  const int size = 42, systems = 101;
  // Dense elimination does the same work whatever the numbers are.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  std::vector<Eigen::MatrixXd> matrices;
  std::vector<Eigen::VectorXd> rights;
  for (int i = 0; i < systems; ++i) {
    matrices.push_back(Eigen::MatrixXd::NullaryExpr(size, size, [&] { return number(random); }));
    rights.push_back(Eigen::VectorXd::NullaryExpr(size, [&] { return number(random); }));
  }
  Eigen::PartialPivLU<Eigen::MatrixXd> solver(size);
  Eigen::VectorXd solution(size);
  Difference difference;
  for (int i = 0; i < systems; ++i) {
    solution = solver.compute(matrices[i]).solve(rights[i]);
    const Eigen::VectorXd back = matrices[i] * solution;
    for (int k = 0; k < size; ++k) difference.add(back[k], rights[i][k]);
  }
  serve({{"lu42", difference.relative(),
          [&](size_t i) {
            solution.noalias() = solver.compute(matrices[i]).solve(rights[i]);
            return solution[0];
          }}},
        systems);
}
