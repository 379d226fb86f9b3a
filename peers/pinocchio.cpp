// Pinocchio: closed-loop inverse dynamics with all joint reactions, and constrained forward dynamics.
//
// Pinocchio has no call for the first. `rnea` gives the forces of the open tree, `computeJointJacobians` what the loops
// are closed with; the rows without a drive determine the closing forces, and these are passed on along the tree to give
// the reactions. (A second `rnea` with the closing forces as loads gives the same, in 1.5 times the time of all.) The
// second is `constraintDynamics`, which is exact.
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <Eigen/Dense>
#include <algorithm>

#include "harness.hpp"

using namespace peers;
namespace pin = pinocchio;
using Vector = Eigen::VectorXd;

Vector vector(const Numbers& numbers) { return Eigen::Map<const Vector>(numbers.data(), numbers.size()); }

/// The tree, whose joints are listed by type, parent, placement and inertia.
pin::Model read_model(std::istream& in) {
  pin::Model model;
  std::string word;
  int joints = 0;
  in >> word >> joints;
  if (word != "joints" || !in) fail("the file has no joints");
  for (int k = 0; k < 3; ++k) in >> model.gravity.linear()[k];
  for (int i = 0; i < joints; ++i) {
    std::string type;
    pin::JointIndex parent;
    in >> type >> parent;
    pin::SE3 place;
    double mass;
    Eigen::Vector3d com;
    Eigen::Matrix3d inertia;
    for (int k = 0; k < 9; ++k) in >> place.rotation()(k / 3, k % 3);
    for (int k = 0; k < 3; ++k) in >> place.translation()[k];
    in >> mass;
    for (int k = 0; k < 3; ++k) in >> com[k];
    for (int k = 0; k < 9; ++k) in >> inertia(k / 3, k % 3);
    const std::map<std::string, pin::JointModel> types = {
        {"JointModelRX", pin::JointModelRX()},       {"JointModelRY", pin::JointModelRY()},
        {"JointModelRZ", pin::JointModelRZ()},       {"JointModelPX", pin::JointModelPX()},
        {"JointModelPY", pin::JointModelPY()},       {"JointModelPZ", pin::JointModelPZ()},
        {"JointModelSpherical", pin::JointModelSpherical()}};
    const auto found = types.find(type);
    if (found == types.end() || !in) fail("no such joint: " + type);
    const auto joint = model.addJoint(parent, found->second, place, "joint" + std::to_string(i + 1));
    model.appendBodyToJoint(joint, pin::Inertia(mass, com, inertia), pin::SE3::Identity());
  }
  return model;
}

struct PinState {
  Vector q, v, a;
};

template <int N>
class Inverse {
 public:
  Inverse(const pin::Model& model, const Motion& motion)
      : model(model), motion(motion), data(model), extra(model.njoints), closing(N, model.nv), needed(model.nv),
        tau(motion.driven.size()), has_dof(motion.closures.size(), std::vector<std::pair<int, double>>()) {
    // The degrees of freedom that move a closing point on b, and against them those that move the one on a.
    for (size_t c = 0; c < motion.closures.size(); ++c) {
      std::vector<double> sign(model.nv, 0.0);
      for (auto [end, of_end] : {std::pair{motion.closures[c].b, 1.0}, std::pair{motion.closures[c].a, -1.0}}) {
        for (pin::JointIndex joint = end; joint > 0; joint = model.parents[joint]) {
          for (int k = 0; k < model.joints[joint].nv(); ++k) sign[model.joints[joint].idx_v() + k] += of_end;
        }
      }
      for (int k = 0; k < model.nv; ++k) {
        if (sign[k] != 0.0) has_dof[c].push_back({k, sign[k]});
      }
    }
    closing.setZero();
  }

  /// All forces at a state; nothing of an earlier one is used.
  void evaluate(const State& s, const PinState& p) {
    pin::rnea(model, data, p.q, p.v, p.a);
    pin::computeJointJacobians(model, data, p.q);
    for (auto& force : extra) force.setZero();

    // `extra` is what a joint's body gets from outside, in the joint's axes.
    needed = data.tau;
    for (size_t i = 0; i < motion.loaded.size(); ++i) {
      const int joint = motion.loaded[i];
      const Eigen::Map<const Eigen::Vector3d> force(&s.loads[6 * i]), moment(&s.loads[6 * i + 3]);
      const pin::SE3& place = data.oMi[joint];
      extra[joint] += pin::Force(place.rotation().transpose() * force, place.rotation().transpose() * moment);
      const pin::Force at_origin(force, moment + place.translation().cross(force));
      for (pin::JointIndex on = joint; on > 0; on = model.parents[on]) {
        const int first = model.joints[on].idx_v(), count = model.joints[on].nv();
        for (int k = first; k < first + count; ++k) needed[k] -= data.J.col(k).dot(at_origin.toVector());
      }
    }

    for (size_t c = 0; c < motion.closures.size(); ++c) {
      const Closure& closure = motion.closures[c];
      const Eigen::Vector3d point = data.oMi[closure.b].act(Eigen::Vector3d(closure.at_b));
      for (auto [dof, sign] : has_dof[c]) {
        const auto column = data.J.col(dof);
        const Eigen::Vector3d linear = column.template head<3>(), angular = column.template tail<3>();
        closing.template block<3, 1>(3 * c, dof) = sign * (linear + angular.cross(point));
      }
    }
    for (int i = 0; i < N; ++i) {
      right[i] = needed[motion.undriven[i]];
      matrix.row(i) = closing.col(motion.undriven[i]).transpose();
    }
    forces = solver.compute(matrix).solve(right);
    for (size_t i = 0; i < tau.size(); ++i) {
      tau[i] = needed[motion.driven[i]] - closing.col(motion.driven[i]).dot(forces);
    }

    for (size_t c = 0; c < motion.closures.size(); ++c) {
      const Closure& closure = motion.closures[c];
      const Eigen::Vector3d on_b = forces.template segment<3>(3 * c);
      for (auto [joint, at, sign] : {std::tuple{closure.a, closure.at_a, -1.0}, std::tuple{closure.b, closure.at_b, 1.0}}) {
        if (joint == 0) continue;
        const Eigen::Vector3d force = sign * (data.oMi[joint].rotation().transpose() * on_b);
        extra[joint] += pin::Force(force, Eigen::Map<const Eigen::Vector3d>(at).cross(force));
      }
    }
    for (int joint = model.njoints - 1; joint > 0; --joint) {
      data.f[joint] -= extra[joint];
      if (model.parents[joint] > 0) extra[model.parents[joint]] += data.liMi[joint].act(extra[joint]);
    }
  }

  double result() const { return tau[0] + data.f[1].linear()[0]; }

  double difference(const std::vector<PinState>& states) {
    Difference drives, force, moment;
    for (size_t n = 0; n < states.size(); ++n) {
      const State& s = motion.states[n];
      evaluate(s, states[n]);
      for (size_t i = 0; i < tau.size(); ++i) drives.add(tau[i], s.drives[i]);
      for (int j = 0; j < N; ++j) force.add(forces[j], s.closing_forces[j]);
      for (size_t i = 0; i < motion.tree.size(); ++i) {
        const int joint = motion.tree[i];
        const Eigen::Vector3d f = data.oMi[joint].rotation() * data.f[joint].linear();
        const Eigen::Vector3d m = data.oMi[joint].rotation() * data.f[joint].angular();
        for (int k = 0; k < 3; ++k) {
          force.add(f[k], s.tree_wrenches[6 * i + k]);
          moment.add(m[k], s.tree_wrenches[6 * i + 3 + k]);
        }
      }
    }
    return std::max({drives.relative(), force.relative(), moment.relative()});
  }

 private:
  const pin::Model& model;
  const Motion& motion;
  pin::Data data;
  std::vector<pin::Force> extra;
  Eigen::Matrix<double, N, Eigen::Dynamic> closing;
  Vector needed, tau;
  std::vector<std::vector<std::pair<int, double>>> has_dof;
  Eigen::Matrix<double, N, N> matrix;
  Eigen::Matrix<double, N, 1> right, forces;
  Eigen::PartialPivLU<Eigen::Matrix<double, N, N>> solver;
};

/// Accelerations from drives and loads. The loads are in the generalised forces that it is given.
class Forward {
 public:
  Forward(const pin::Model& model, const Motion& motion, const std::vector<PinState>& states)
      : model(model), states(states), data(model), settings(1e-12, 1e-12, 0.0, 1) {
    for (const Closure& c : motion.closures) {
      const pin::SE3 a(Eigen::Matrix3d::Identity(), Eigen::Map<const Eigen::Vector3d>(c.at_a));
      const pin::SE3 b(Eigen::Matrix3d::Identity(), Eigen::Map<const Eigen::Vector3d>(c.at_b));
      constraints.emplace_back(pin::CONTACT_3D, model, c.a, a, c.b, b, pin::LOCAL);
      constraint_data.emplace_back(constraints.back());
    }
    for (size_t n = 0; n < states.size(); ++n) {
      const State& s = motion.states[n];
      Vector tau = Vector::Zero(model.nv);
      for (size_t i = 0; i < motion.driven.size(); ++i) tau[motion.driven[i]] = s.drives[i];
      pin::computeJointJacobians(model, data, states[n].q);
      for (size_t i = 0; i < motion.loaded.size(); ++i) {
        pin::Data::Matrix6x jacobian = pin::Data::Matrix6x::Zero(6, model.nv);
        pin::getJointJacobian(model, data, motion.loaded[i], pin::LOCAL_WORLD_ALIGNED, jacobian);
        tau += jacobian.transpose() * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(&s.loads[6 * i]);
      }
      taus.push_back(tau);
    }
    pin::initConstraintDynamics(model, data, constraints, constraint_data);
  }

  void evaluate(size_t n) {
    pin::constraintDynamics(model, data, states[n].q, states[n].v, taus[n], constraints, constraint_data, settings);
  }

  double result() const { return data.ddq[0]; }

  double difference() {
    Difference accelerations;
    for (size_t n = 0; n < states.size(); ++n) {
      evaluate(n);
      for (int k = 0; k < model.nv; ++k) accelerations.add(data.ddq[k], states[n].a[k]);
    }
    return accelerations.relative();
  }

 private:
  const pin::Model& model;
  const std::vector<PinState>& states;
  pin::Data data;
  pin::ProximalSettings settings;
  std::vector<pin::RigidConstraintModel> constraints;
  std::vector<pin::RigidConstraintData> constraint_data;
  std::vector<Vector> taus;
};

template <int N>
void run(const pin::Model& model, const Motion& motion) {
  std::vector<PinState> states;
  for (const State& s : motion.states) states.push_back({vector(s.q), vector(s.v), vector(s.a)});
  Inverse<N> inverse(model, motion);
  Forward forward(model, motion, states);
  const double inverse_difference = inverse.difference(states), forward_difference = forward.difference();
  serve({{"inverse", inverse_difference,
          [&](size_t i) {
            inverse.evaluate(motion.states[i], states[i]);
            return inverse.result();
          }},
         {"forward", forward_difference,
          [&](size_t i) {
            forward.evaluate(i);
            return forward.result();
          }}},
        states.size());
}

int main(int count, char** arguments) {
  if (count != 2) fail("usage: pinocchio MODEL.pinocchio.txt");
  std::ifstream file(arguments[1]);
  const pin::Model model = read_model(file);
  const Motion motion(file);
  if (model.nq != motion.nq || model.nv != motion.nv) fail("the states are not those of the tree");
  // Joints that are not in depth-first order give wrong answers and no error.
  pin::Data data(model);
  if (!model.check(data)) fail("the joints are not in the order that the recursions ask for");
  switch (motion.undriven.size()) {
    case 6: run<6>(model, motion); break;
    case 15: run<15>(model, motion); break;
    default: fail("no case for this number of closing forces");
  }
}
