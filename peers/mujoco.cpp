// MuJoCo: closed-loop inverse dynamics with all joint reactions, and its own forward dynamics.
//
// MuJoCo has no call for the first: its loops are soft equalities. They are switched off, `mj_rne` gives the forces of
// the open tree, the rows without a drive determine the forces that close the loops, and `mj_rnePostConstraint` the
// reactions with these forces as loads. The second is `mj_forward` with the equalities, which are soft.
#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <algorithm>

#include "harness.hpp"

using namespace peers;

/// N is the number of unknown closing forces, which lets the linear solver unroll.
template <int N>
class Inverse {
 public:
  Inverse(const mjModel* model, const Motion& motion)
      : m(model), motion(motion), d(mj_makeData(model)), jacobian(6 * motion.nv), closing(3 * motion.closures.size() * motion.nv),
        needed(motion.nv), tau(motion.driven.size()) {}

  /// All forces at a state; nothing of an earlier one is used.
  void evaluate(const State& s) {
    const int nv = motion.nv;
    std::copy(s.q.begin(), s.q.end(), d->qpos);
    std::copy(s.v.begin(), s.v.end(), d->qvel);
    std::copy(s.a.begin(), s.a.end(), d->qacc);
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 1, needed.data());

    std::fill(d->xfrc_applied, d->xfrc_applied + 6 * m->nbody, 0.0);
    for (size_t i = 0; i < motion.loaded.size(); ++i) {
      const int body = motion.loaded[i];
      const double* load = &s.loads[6 * i];
      mj_jacBody(m, d, jacobian.data(), jacobian.data() + 3 * nv, body);
      for (int k = 0; k < 6; ++k) {
        for (int j = 0; j < nv; ++j) needed[j] -= jacobian[k * nv + j] * load[k];
      }
      apply(body, d->xpos + 3 * body, load, load + 3);
    }

    for (size_t c = 0; c < motion.closures.size(); ++c) {
      double* rows = &closing[3 * nv * c];
      mj_jacSite(m, d, rows, nullptr, motion.closures[c].b);
      mj_jacSite(m, d, jacobian.data(), nullptr, motion.closures[c].a);
      for (int i = 0; i < 3 * nv; ++i) rows[i] -= jacobian[i];
    }
    for (int i = 0; i < N; ++i) {
      const int dof = motion.undriven[i];
      right[i] = needed[dof];
      for (int j = 0; j < N; ++j) matrix(i, j) = closing[nv * j + dof];
    }
    forces = solver.compute(matrix).solve(right);
    for (size_t i = 0; i < tau.size(); ++i) {
      tau[i] = needed[motion.driven[i]];
      for (int j = 0; j < N; ++j) tau[i] -= closing[nv * j + motion.driven[i]] * forces[j];
    }

    const double none[3] = {0, 0, 0};
    for (size_t c = 0; c < motion.closures.size(); ++c) {
      const double on_b[3] = {forces[3 * c], forces[3 * c + 1], forces[3 * c + 2]};
      const double on_a[3] = {-on_b[0], -on_b[1], -on_b[2]};
      const int a = motion.closures[c].a, b = motion.closures[c].b;
      apply(m->site_bodyid[a], d->site_xpos + 3 * a, on_a, none);
      apply(m->site_bodyid[b], d->site_xpos + 3 * b, on_b, none);
    }
    mj_rnePostConstraint(m, d);
  }

  double result() const { return tau[0] + d->cfrc_int[6]; }

  double difference() {
    Difference drives, force, moment;
    for (const State& s : motion.states) {
      evaluate(s);
      for (size_t i = 0; i < tau.size(); ++i) drives.add(tau[i], s.drives[i]);
      for (int j = 0; j < N; ++j) force.add(forces[j], s.closing_forces[j]);
      for (size_t i = 0; i < motion.tree.size(); ++i) {
        const int body = motion.tree[i];
        const double* got = d->cfrc_int + 6 * body;  // [moment, force] about the centre of mass of the tree
        double lever[3], moved[3];
        mju_sub3(lever, d->subtree_com + 3 * m->body_rootid[body], d->xpos + 3 * body);
        mju_cross(moved, lever, got + 3);
        for (int k = 0; k < 3; ++k) {
          force.add(got[3 + k], s.tree_wrenches[6 * i + k]);
          moment.add(got[k] + moved[k], s.tree_wrenches[6 * i + 3 + k]);
        }
      }
    }
    return std::max({drives.relative(), force.relative(), moment.relative()});
  }

 private:
  /// A wrench about a point as a load on a body, which MuJoCo takes at the centre of mass.
  void apply(int body, const double* point, const double* force, const double* moment) {
    double lever[3], moved[3];
    mju_sub3(lever, point, d->xipos + 3 * body);
    mju_cross(moved, lever, force);
    double* load = d->xfrc_applied + 6 * body;
    for (int k = 0; k < 3; ++k) {
      load[k] += force[k];
      load[3 + k] += moment[k] + moved[k];
    }
  }

  const mjModel* m;
  const Motion& motion;
  mjData* d;
  Numbers jacobian, closing, needed, tau;
  Eigen::Matrix<double, N, N> matrix;
  Eigen::Matrix<double, N, 1> right, forces;
  Eigen::PartialPivLU<Eigen::Matrix<double, N, N>> solver;
};

/// `mj_forward` with the drives as controls. Its accelerations are not those of the mechanism: the loops are springs.
class Forward {
 public:
  Forward(const mjModel* model, const Motion& motion) : m(model), motion(motion), d(mj_makeData(model)) {
    for (const State& s : motion.states) {
      std::copy(s.q.begin(), s.q.end(), d->qpos);
      mj_kinematics(m, d);
      mj_comPos(m, d);
      Numbers load(6 * motion.loaded.size());
      for (size_t i = 0; i < motion.loaded.size(); ++i) {
        const int body = motion.loaded[i];
        double lever[3], moved[3];
        mju_sub3(lever, d->xpos + 3 * body, d->xipos + 3 * body);
        mju_cross(moved, lever, &s.loads[6 * i]);
        for (int k = 0; k < 6; ++k) load[6 * i + k] = s.loads[6 * i + k] + (k < 3 ? 0.0 : moved[k - 3]);
      }
      loads.push_back(load);
    }
  }

  void evaluate(size_t sample) {
    const State& s = motion.states[sample];
    std::copy(s.q.begin(), s.q.end(), d->qpos);
    std::copy(s.v.begin(), s.v.end(), d->qvel);
    std::copy(s.drives.begin(), s.drives.end(), d->ctrl);
    for (size_t i = 0; i < motion.loaded.size(); ++i) {
      std::copy_n(&loads[sample][6 * i], 6, d->xfrc_applied + 6 * motion.loaded[i]);
    }
    mj_forward(m, d);
  }

  double result() const { return d->qacc[0]; }

  double difference() {
    Difference accelerations;
    for (size_t i = 0; i < motion.states.size(); ++i) {
      evaluate(i);
      for (int k = 0; k < motion.nv; ++k) accelerations.add(d->qacc[k], motion.states[i].a[k]);
    }
    return accelerations.relative();
  }

 private:
  const mjModel* m;
  const Motion& motion;
  mjData* d;
  std::vector<Numbers> loads;
};

mjModel* load(const std::string& path, bool with_loops) {
  char error[1000] = "";
  mjModel* model = mj_loadXML(path.c_str(), nullptr, error, sizeof error);
  if (model == nullptr) fail(path + ": " + error);
  model->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_FRICTIONLOSS | mjDSBL_SPRING | mjDSBL_DAMPER;
  if (!with_loops) model->opt.disableflags |= mjDSBL_EQUALITY;
  return model;
}

template <int N>
void run(const std::string& xml, const Motion& motion) {
  Inverse<N> inverse(load(xml, false), motion);
  Forward forward(load(xml, true), motion);
  const double inverse_difference = inverse.difference(), forward_difference = forward.difference();
  serve({{"inverse", inverse_difference,
          [&](size_t i) {
            inverse.evaluate(motion.states[i]);
            return inverse.result();
          }},
         {"forward_soft", forward_difference,
          [&](size_t i) {
            forward.evaluate(i);
            return forward.result();
          }}},
        motion.states.size());
}

int main(int count, char** arguments) {
  if (count != 3) fail("usage: mujoco MODEL.mujoco.xml MODEL.mujoco.txt");
  std::ifstream file(arguments[2]);
  const Motion motion(file);
  switch (motion.undriven.size()) {
    case 6: run<6>(arguments[1], motion); break;
    case 9: run<9>(arguments[1], motion); break;
    case 15: run<15>(arguments[1], motion); break;
    case 18: run<18>(arguments[1], motion); break;
    default: fail("no case for this number of closing forces");
  }
}
