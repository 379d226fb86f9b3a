//! Parameters of a mechanism that are inputs of a program instead of constants.

use stiction_core::dynamics::{AppliedLoad, LoadAxes};
use stiction_core::friction::Curve;
use stiction_core::mechanism::BodyId;
use stiction_core::parameters::Parameters;
use stiction_core::scalar::Scalar;
use stiction_core::spatial::{Mat3, Vec3};

/// Parameter of a [`Feedforward`](crate::Feedforward) program that can be changed at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tunable {
    /// Coefficient of sliding friction, by the index of the interface in
    /// [`Parameters::interfaces`], dimensionless.
    Mu(usize),
    /// Viscous coefficient of a friction interface at its surface, N s/m.
    Viscous(usize),
    /// Mass of a body, kg. The centre of mass of the body, and its inertia about the centre of
    /// mass, do not change.
    Mass(BodyId),
    /// Point mass that is fixed to a body: mass, kg, and position x, y, z in the body's frame, m.
    Payload(BodyId),
    /// Load on a body: force, N, and moment about the origin of the body, N m, world axes.
    Wrench(BodyId),
}

impl Tunable {
    /// Number of scalar values of the parameter.
    pub fn width(self) -> usize {
        match self {
            Self::Mu(_) | Self::Viscous(_) | Self::Mass(_) => 1,
            Self::Payload(_) => 4,
            Self::Wrench(_) => 6,
        }
    }

    /// Lists the coefficients of sliding friction and the viscous coefficients of all friction
    /// interfaces that have the same friction law in both directions. An interface with a table of
    /// coefficients contributes only its viscous coefficient.
    pub fn frictions(parameters: &Parameters<f64>) -> Vec<Self> {
        let interfaces = || parameters.interfaces.iter().enumerate();
        let plain = interfaces().filter(|(_, interface)| interface.backward.is_none());
        let with_mu =
            plain.clone().filter(|(_, interface)| !matches!(interface.law.curve, Curve::Table(_)));
        let mu = with_mu.map(|(k, _)| Self::Mu(k));
        mu.chain(plain.map(|(k, _)| Self::Viscous(k))).collect()
    }

    /// Lists the masses of all bodies that have mass.
    pub fn masses(parameters: &Parameters<f64>) -> Vec<Self> {
        let heavy = parameters.mass.iter().enumerate().skip(1).filter(|(_, mass)| **mass > 0.0);
        heavy.map(|(body, _)| Self::Mass(BodyId(body))).collect()
    }

    /// Returns a load with zero force and moment on the body of a [`Tunable::Wrench`]; `None` for
    /// any other parameter.
    pub(crate) fn load(self) -> Option<AppliedLoad<f64>> {
        let Self::Wrench(body) = self else { return None };
        let (point, force, moment) = (Vec3::zero(), Vec3::zero(), Vec3::zero());
        Some(AppliedLoad { body, point, axes: LoadAxes::World, force, moment })
    }

    /// Returns the values of the parameter in the model, which are zero for payloads and loads;
    /// `None` if the mechanism does not have this parameter.
    pub(crate) fn values(self, parameters: &Parameters<f64>) -> Option<Vec<f64>> {
        match self {
            Self::Mu(k) => Some(vec![parameters.interfaces.get(k)?.law.mu]),
            Self::Viscous(k) => Some(vec![parameters.interfaces.get(k)?.law.viscous]),
            Self::Mass(body) => Some(vec![*parameters.mass.get(body.0)?]),
            Self::Payload(body) if *parameters.mass.get(body.0)? > 0.0 => Some(vec![0.0; 4]),
            Self::Payload(_) => None,
            Self::Wrench(body) if (1..parameters.mass.len()).contains(&body.0) => {
                Some(vec![0.0; 6])
            }
            Self::Wrench(_) => None,
        }
    }

    /// Returns random values of the parameter, which avoid special values such as zero. `length` is
    /// the characteristic length, m.
    pub(crate) fn any(
        self,
        parameters: &Parameters<f64>,
        length: f64,
        mut random: impl FnMut() -> f64,
    ) -> Vec<f64> {
        let now = self.values(parameters).unwrap_or_default();
        let mut about = |usual: f64| usual * (1.0 + 0.5 * random());
        match self {
            Self::Mu(_) | Self::Viscous(_) => {
                let unit = if matches!(self, Self::Mu(_)) { 0.05 } else { 1.0 };
                now.iter().map(|x| about(if *x > 0.0 { *x } else { unit })).collect()
            }
            Self::Mass(_) => now.iter().map(|x| about(*x)).collect(),
            Self::Payload(body) => {
                let mass = about(parameters.mass[body.0]);
                let mut place = || 0.3 * length * random();
                vec![mass, place(), place(), place()]
            }
            Self::Wrench(_) => {
                (0..6).map(|k| 100.0 * if k < 3 { 1.0 } else { length } * random()).collect()
            }
        }
    }

    /// Applies the parameter's `values` to `parameters`. A payload is added to the mass, centre of
    /// mass and inertia of its body; other parameters are overwritten. Loads have no effect,
    /// because they are not part of the mechanism.
    pub(crate) fn apply<T: Scalar>(self, parameters: &mut Parameters<T>, values: &[T]) {
        match (self, values) {
            (Self::Mu(k), [mu]) => parameters.interfaces[k].law.mu = *mu,
            (Self::Viscous(k), [viscous]) => parameters.interfaces[k].law.viscous = *viscous,
            (Self::Mass(body), [mass]) => parameters.mass[body.0] = *mass,
            (Self::Payload(body), [mass, x, y, z]) => {
                let (own, com) = (parameters.mass[body.0], parameters.com[body.0]);
                let apart = Vec3::new(*x, *y, *z) - com;
                let share = *mass / (own + *mass);
                parameters.mass[body.0] = own + *mass;
                parameters.com[body.0] = com + apart * share;
                // Inertia of two point masses about their common centre.
                let reduced = own * share;
                let square = apart.norm_squared();
                let inertia = &mut parameters.inertia[body.0];
                let column = |axis: usize| {
                    let along = Vec3::<T>::unit(axis) * square - apart * apart.component(axis);
                    inertia.columns[axis] + along * reduced
                };
                *inertia = Mat3::from_columns(column(0), column(1), column(2));
            }
            _ => {}
        }
    }
}
