// MuJoCo: a simulation with fixed steps and a PD controller that sets the actuator forces before each step.
//
// Usage: mujoco_simulation MODEL.xml SETTING.txt. The setting has the time step, the numbers of steps and of references,
// the initial positions and velocities of the tree, and for each actuator the addresses of its coordinate and velocity
// and its two gains; then the references, which repeat. Prints the processor time of all steps, s, and the greatest
// tracking error in the second half.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <ctime>

#include "harness.hpp"

using peers::Numbers;

struct Actuator {
  int position, velocity;
  double stiffness, damping;
};

struct Setting {
  double step;
  size_t steps;
  Numbers q, v;
  std::vector<Actuator> actuators;
  /// References of a period: for each step position and rate of each actuator.
  Numbers references;

  Setting(const std::string& path, const mjModel* m) : q(m->nq), v(m->nv), actuators(m->nu) {
    std::ifstream in(path);
    size_t period = 0;
    in >> step >> steps >> period;
    for (double& x : q) in >> x;
    for (double& x : v) in >> x;
    for (Actuator& a : actuators) in >> a.position >> a.velocity >> a.stiffness >> a.damping;
    references.resize(2 * actuators.size() * period);
    for (double& x : references) in >> x;
    if (!in || references.empty()) peers::fail(path + " is not complete");
  }
};

double cpu_time() { return double(std::clock()) / CLOCKS_PER_SEC; }

int main(int count, char** arguments) {
  if (count != 3) peers::fail("usage: mujoco_simulation MODEL.xml SETTING.txt");
  char error[1000] = "";
  mjModel* m = mj_loadXML(arguments[1], nullptr, error, sizeof error);
  if (m == nullptr) peers::fail(std::string(arguments[1]) + ": " + error);
  const Setting setting(arguments[2], m);
  m->opt.timestep = setting.step;
  m->opt.disableflags |= mjDSBL_CONTACT;
  mjData* d = mj_makeData(m);
  std::copy(setting.q.begin(), setting.q.end(), d->qpos);
  std::copy(setting.v.begin(), setting.v.end(), d->qvel);
  double worst = 0.0;
  const double begun = cpu_time();
  const double* reference = setting.references.data();
  const double* end = reference + setting.references.size();
  for (size_t step = 0; step < setting.steps; ++step) {
    for (int k = 0; k < m->nu; ++k, reference += 2) {
      const Actuator& a = setting.actuators[k];
      const double off = reference[0] - d->qpos[a.position];
      d->ctrl[k] = a.stiffness * off + a.damping * (reference[1] - d->qvel[a.velocity]);
      if (2 * step >= setting.steps) worst = std::max(worst, std::abs(off));
    }
    if (reference == end) reference = setting.references.data();
    mj_step(m, d);
  }
  std::printf("%.9f %.6e\n", cpu_time() - begun, worst);
}
