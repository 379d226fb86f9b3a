//! `stiction export`: source code and functional mock-up units for controllers.

mod fmu;
mod plant;

use crate::arguments::{Adapter, Export, Function, Language, Precision, Tunable};
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::sources::{self, warn};

pub(crate) fn run(options: &Export) -> Result<(), Failure> {
    let robot = sources::robot_or_default(&options.model)?;
    warn(robot.warnings());
    let tunes = |kind| options.tunable.contains(&kind);
    let mut export = robot
        .export()
        .language(match options.to {
            Language::C | Language::Fmu => stiction::Language::C,
            Language::Rust => stiction::Language::Rust,
        })
        .precision(match options.precision {
            Precision::Double => stiction::Precision::Double,
            Precision::Float => stiction::Precision::Float,
        })
        .own_math(options.own_math)
        .tunable(tunes(Tunable::Friction), tunes(Tunable::Masses))
        .functions(stiction::Functions {
            kinematics: options.functions.contains(&Function::Kinematics),
            reactions: options.functions.contains(&Function::Reactions),
            derivatives: options.functions.contains(&Function::Derivatives),
            accelerations: options.functions.contains(&Function::Accelerations),
        })
        .adapters(stiction::Adapters {
            ctypes: options.adapters.contains(&Adapter::Ctypes),
            linuxcnc: options.adapters.contains(&Adapter::Linuxcnc),
            cortex_m7: options.adapters.contains(&Adapter::CortexM7),
        })
        .vectors(options.vectors as usize);
    if let Some(name) = &options.prefix {
        export = export.name(name);
    }
    if let Some(motion) = &options.motion {
        export = export.motion(motion);
    }
    if let Some(body) = &options.payload {
        export = export.payload(body);
    }
    if !options.coordinates.is_empty() {
        export = export.coordinates(&options.coordinates);
    }
    if options.plant.plant {
        return plant::write(&export, options, robot.files_read());
    }
    for body in &options.force_on {
        export = export.force_on(body);
    }
    if options.to == Language::Fmu {
        return fmu::write(&export, options, robot.files_read());
    }
    let files = export.files()?;
    note_remarks(&export);
    let mut outputs = Outputs::new(&options.output, robot.files_read())?;
    outputs.refuse_interrupted()?;
    for file in &files {
        outputs.write(&file.name, file.text.as_bytes())?;
    }
    outputs.complete(&[])?;
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    note!("wrote {} in {}", names.join(", "), options.output.display());
    Ok(())
}

/// Prints notes on effects that `stiction inverse` includes by default but the exported code does
/// not.
fn note_remarks(export: &stiction::Export) {
    for remark in export.remarks() {
        note!("note: {remark}");
    }
}
