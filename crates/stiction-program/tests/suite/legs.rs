//! Legs of many kinds in closed form: programs need only the motion of the platform as input.

use crate::common::{Robot, model};
use stiction_format::gallery;
use stiction_program::InverseProgram;

/// A Gough platform with other chains and joints in its six legs.
fn platform(chain: &str, joints: &str) -> String {
    let text = gallery::get("gough").unwrap();
    let start = text.find("[legs.joints.U]").unwrap();
    let end = text.find("[legs.bodies.tube]").unwrap();
    let text = format!("{}{joints}\n{}", &text[..start], &text[end..]);
    text.replace("U tube P* screw S", chain)
}

const BALL: &str = "friction = { mu = 0.1, radius = \"15 mm\" }";

/// Actuator forces from the platform's motion agree with the solver, which starts from the legs'
/// coordinates.
#[test]
fn legs_follow_in_closed_form() {
    let pus = format!(
        "[legs.joints.P]\naxis = \"z\"\nstart = \"300 mm\"\n\
         [legs.joints.U]\naxis = \"x\"\nsecond_axis = \"y\"\nfriction = {{ mu = 0.05, radius = \"12 mm\" }}\n\
         [legs.joints.S]\nat = [0, 0, \"750 mm\"]\n{BALL}\n"
    );
    let rus = format!(
        "[legs.joints.R]\naxis = \"y\"\nfriction = {{ mu = 0.05, radius = \"12 mm\" }}\n\
         [legs.joints.U]\nat = [\"250 mm\", 0, 0]\naxis = \"x\"\nsecond_axis = \"y\"\n\
         [legs.joints.S]\nat = [0, 0, \"1050 mm\"]\n{BALL}\n"
    );
    let upside_down = format!(
        "[legs.joints.S]\n{BALL}\n\
         [legs.joints.P]\naxis = \"z\"\nstart = \"1 m\"\nfriction = {{ mu = 0.08 }}\n\
         [legs.joints.U]\naxis = \"x\"\nsecond_axis = \"y\"\nfriction = {{ mu = 0.05, radius = \"12 mm\" }}\n"
    );
    let rrps = format!(
        "[legs.joints.R1]\naxis = \"x\"\nfriction = {{ mu = 0.05, radius = \"12 mm\" }}\n\
         [legs.joints.R2]\naxis = \"y\"\n\
         [legs.joints.P]\naxis = \"z\"\nstart = \"1 m\"\n\
         [legs.joints.S]\n{BALL}\n"
    );
    let legs = [
        ("P* tube U screw S", pus),
        ("R* tube U screw S", rus),
        ("S tube P* screw U", upside_down),
        (
            "R tube R hinge P* screw S",
            rrps + "[legs.bodies.hinge]\nmass = \"1 kg\"\ncom = [0, 0, 0]\ninertia = [\"1e-3 kg m^2\", \"1e-3 kg m^2\", \"1e-3 kg m^2\"]\n",
        ),
    ];
    for (chain, joints) in legs {
        let text = platform(chain, &joints);
        let model = model(chain, &text);
        let Robot { mut solver, signal, loads } = Robot::of(&model, Some("payload"));
        let motion = model.motion("sway").unwrap();
        let program = InverseProgram::record(&solver, &signal, &loads).unwrap();
        assert!(program.coordinates().is_empty(), "{chain}: {:?}", program.coordinates());
        assert_eq!(program.bodies().count(), 1);
        let mut memory = program.memory(1);
        let mut settled = [false];
        for k in 0..20 {
            // Between the positions of the recording.
            let targets: Vec<_> = motion.at(0.2 * f64::from(k) + 0.07).collect();
            solver.move_to(&targets).unwrap();
            let motions = program.motions(solver.state());
            // No joint coordinate is an input.
            program.set_bodies(&mut memory, 0, &motions, &[], &targets, &loads);
            program.run(&mut memory, &mut settled);
            let forces = solver.solve(&loads).unwrap();
            assert!(settled[0], "{chain}, {k}");
            let largest = forces.efforts.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
            for (drive, expected) in forces.efforts.iter().enumerate() {
                let found = program.drive(&memory, 0, drive);
                // Rounding magnified by condition numbers of some hundred.
                assert!((found - expected).abs() < 1e-11 * largest, "{chain}: {found} {expected}");
            }
        }
    }
}
