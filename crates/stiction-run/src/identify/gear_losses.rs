//! Losses of gears in efforts that are measured at motors. The regression does not contain them.

use stiction_core::mechanism::Mechanism;
use stiction_identify::{Kind, Parameter};

/// Indices of the drive trains whose gears have losses.
#[derive(Clone, Debug, Default)]
pub(super) struct GearLosses {
    /// Drive trains whose losses become a part of estimated friction.
    pub(super) in_friction: Vec<usize>,
    /// Drive trains without estimated friction.
    without_friction: Vec<usize>,
}

impl GearLosses {
    /// Finds the drive trains with losses. `held` parameters are not estimated.
    pub(super) fn new(mechanism: &Mechanism, parameters: &[Parameter], held: &[bool]) -> Self {
        let joints = mechanism.joints().iter().enumerate();
        let interfaces: Vec<usize> =
            joints.flat_map(|(index, joint)| joint.friction.iter().map(move |_| index)).collect();
        let actuators: Vec<_> = mechanism.actuators().collect();
        let estimated = || parameters.iter().zip(held).filter(|(_, held)| !**held).map(|(p, _)| p);
        let mut found = Self::default();
        for (index, train) in mechanism.drive_trains().iter().enumerate() {
            if train.losses().is_none() {
                continue;
            }
            let is_own = |kind: Kind| match kind {
                Kind::DriveCoulomb(row) | Kind::DriveViscous(row) => {
                    train.only_dof() == Some(actuators[row])
                }
                kind => kind.interface().is_some_and(|own| {
                    train.dofs.iter().any(|driven| driven.joint.0 == interfaces[own])
                }),
            };
            match estimated().any(|parameter| is_own(parameter.kind)) {
                true => found.in_friction.push(index),
                false => found.without_friction.push(index),
            }
        }
        found
    }

    /// Returns cautions that name these drive trains.
    pub(super) fn cautions(&self, mechanism: &Mechanism) -> Vec<String> {
        let names = |trains: &[usize]| {
            let names = trains.iter().map(|train| mechanism.drive_trains()[*train].name.as_str());
            names.collect::<Vec<_>>().join(", ")
        };
        let mut cautions = Vec::new();
        if !self.in_friction.is_empty() {
            cautions.push(format!(
                "the efficiencies of the gears of {} are not applied: efforts measured at motors \
                 contain gear losses, which are identified as part of the friction; the gears of the \
                 identified model have no losses",
                names(&self.in_friction)
            ));
        }
        if !self.without_friction.is_empty() {
            cautions.push(format!(
                "the efficiencies of the gears of {} are not applied, and no friction is estimated \
                 that could contain the gear losses in the efforts measured at motors",
                names(&self.without_friction)
            ));
        }
        cautions
    }
}
