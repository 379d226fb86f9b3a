//! Statically indeterminate reactions are determined by a rule that does not depend on units,
//! unlike the least-norm solution of the equations.

use crate::common::change::{Change, NONE};
use crate::common::*;
use nalgebra::DVector;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics, LoadAxes, Settings};
use stiction_core::kinematics::Target;
use stiction_core::linalg::Svd;
use stiction_core::spatial::{Pose, Vec3, Wrench};

/// Force, N, and moment about the origin of the joint, N m, for each joint.
type Reactions = Vec<[f64; 6]>;

struct Answers {
    /// Reactions reported by the library.
    ours: Reactions,
    /// Reactions of least norm, from the Moore-Penrose pseudoinverse of the equations in the given
    /// units.
    shortest: Reactions,
    determined: Vec<[bool; 6]>,
}

/// Computes the reactions at the first position of the default motion, at rest, under the weight of
/// the mechanism and a load on one body. The unit of length is 1/`scale` metre; with kg and s, the
/// unit of force is then 1/`scale` newton.
fn answers(name: &str, scale: f64, body: &str, force: Vec3<f64>, moment: Vec3<f64>) -> Answers {
    let model = model(name);
    let motion = model.motion(model.default_motion.as_ref().unwrap()).unwrap();
    let mechanism = Change { scale, ..NONE }.mechanism(&model.mechanism);
    let types: Vec<_> = mechanism.joints().iter().map(|joint| joint.joint_type).collect();
    let coordinates: Vec<_> =
        motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
    let targets: Vec<_> = motion
        .at(motion.start)
        .zip(&coordinates)
        .map(|(target, coordinate)| {
            let s = if coordinate.is_angle(&types) { 1.0 } else { scale };
            Target { value: target.value * s, rate: 0.0, acceleration: 0.0 }
        })
        .collect();
    let initial_poses: Vec<_> = model
        .initial_poses
        .iter()
        .map(|(body, home)| (*body, Pose { position: home.position * scale, ..*home }))
        .collect();
    let load = AppliedLoad {
        body: mechanism.body_id(body).unwrap(),
        point: Vec3::zero(),
        axes: LoadAxes::World,
        force: force * scale,
        moment: moment * (scale * scale),
    };
    let settings = Settings { friction: FrictionMode::Off, ..Settings::default() };
    let mut solver =
        InverseDynamics::new(mechanism, &initial_poses, &coordinates, &targets, settings).unwrap();

    let balance = solver.balance();
    let demand = balance.demand(solver.parameters(), solver.bodies(), &[load]);
    let svd = Svd::new(&balance.matrix.to_dense());
    let unknowns: DVector<f64> = svd.solve(&demand, solver.statics().rank());
    let residual = (balance.matrix.to_dense() * &unknowns - &demand).amax();
    assert!(residual < 1e-8 * demand.amax(), "{name}: a solution, {residual:e}");
    let none = vec![Wrench::zero(); solver.mechanism().joints().len()];
    let origins = solver.bodies().frame_j.iter().map(|frame| frame.position);
    let in_si = |force: Vec3<f64>, moment: Vec3<f64>| {
        let (f, m) = ((force * (1.0 / scale)).to_array(), (moment * scale.powi(-2)).to_array());
        [f[0], f[1], f[2], m[0], m[1], m[2]]
    };
    let shortest = balance
        .joint_wrenches(&unknowns, &none)
        .iter()
        .zip(origins)
        .map(|(wrench, origin)| in_si(wrench.force, wrench.moment_about(origin)))
        .collect();
    let determined = solver.statics().determined_reactions();
    let reactions = &solver.solve(&[load]).unwrap().reactions;
    let ours = reactions.iter().map(|&(force, moment)| in_si(force, moment)).collect();
    Answers { ours, shortest, determined }
}

/// Returns the largest difference of the statically indeterminate components (or of the others if
/// `open` is false), and the largest component of all, for forces and moments separately.
fn apart(a: &Reactions, b: &Reactions, determined: &[[bool; 6]], open: bool) -> f64 {
    let part = |range: std::ops::Range<usize>| {
        let (mut difference, mut largest) = (0.0_f64, 0.0_f64);
        for ((a, b), flags) in a.iter().zip(b).zip(determined) {
            for k in range.clone() {
                largest = largest.max(a[k].abs());
                if flags[k] != open {
                    difference = difference.max((a[k] - b[k]).abs());
                }
            }
        }
        difference / largest
    };
    part(0..3).max(part(3..6))
}

#[test]
fn indeterminate_reactions_do_not_depend_on_units() {
    // The loads act on the redundant constraints: perpendicular to the plane of the planar
    // linkages, and along the three parallel constraint forces of the printed robot.
    let cases = [
        ("3rrr", "platform", [0.0, 0.0, -40.0], [3.0, -2.0, 0.0]),
        ("four-bar", "coupler", [0.0, 0.0, 25.0], [1.0, 2.0, 0.0]),
        ("bricard", "link3", [5.0, -8.0, -20.0], [0.5, 1.0, -1.0]),
        ("zhang2018", "platform", [0.0, 30.0, 0.0], [0.0, 0.0, 5.0]),
    ];
    for (name, body, force, moment) in cases {
        let [force, moment] = [force, moment].map(|[x, y, z]| Vec3::new(x, y, z));
        let [metres, millimetres] =
            [1.0, 1000.0].map(|scale| answers(name, scale, body, force, moment));
        let flags = &metres.determined;
        assert_eq!(flags, &millimetres.determined, "{name}");
        assert!(flags.as_flattened().contains(&false), "{name}");

        let ours = apart(&metres.ours, &millimetres.ours, flags, true);
        let shortest = apart(&metres.shortest, &millimetres.shortest, flags, true);
        println!("{name}: ours differ by {ours:.1e}, the shortest by {:.1} %", 100.0 * shortest);
        assert!(ours < 1e-9, "{name}: {ours:e}");
        assert!(shortest > 0.01, "{name}: {shortest:e}");
        // Determined components do not depend on the method.
        for other in [&millimetres.ours, &metres.shortest, &millimetres.shortest] {
            let difference = apart(&metres.ours, other, flags, false);
            assert!(difference < 1e-8, "{name}: {difference:e}");
        }
    }
}
