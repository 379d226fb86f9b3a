@LINES@
#![allow(clippy::all, clippy::pedantic, unused_parens, dead_code)]

/// Floating-point type.
pub type Real = @REAL@;

/// Number of prescribed coordinates.
pub const COORDINATES: usize = @COORDINATES@;
/// Number of actuators.
pub const ACTUATORS: usize = @DRIVES@;
/// Number of joints.
pub const JOINTS: usize = @JOINTS@;
/// Number of bodies, without the ground.
pub const BODIES: usize = @BODIES@;
/// Number of coordinates of the spanning tree.
pub const TREE: usize = @TREE@;
/// Fingerprint of the model: a hash of its equations and numbers.
pub const FINGERPRINT: u64 = @FINGERPRINT@;

/// Number of reaction components among the results for each joint: 3 for the force, 6 for force and
/// moment.
const WRENCH: usize = @WRENCH@;
/// Number of results of a call: the efforts and, if the code computes them, the wrenches of all
/// joints.
const ANSWERS: usize = @ANSWERS@;
const TUNABLES: usize = @TUNABLES@;
const UNKNOWNS: usize = @UNKNOWNS@;
const POSITION_WORK: usize = @POSITION_WORK@;
const POSITION_RESULTS: usize = @POSITION_RESULTS@;
const FORCE_WORK: usize = @FORCE_WORK@;
const FORCE_RESULTS: usize = @FORCE_RESULTS@;
const FIRST_TARGET: usize = TREE + TUNABLES;
const FIRST_UNKNOWN: usize = FIRST_TARGET + 3 * COORDINATES;
/// Largest number of position corrections in a loop closure.
const MOST_CORRECTIONS: u32 = @CORRECTIONS@;
/// Largest number of Newton steps for the coupled friction forces and reactions.
const MOST_STEPS: u32 = @STEPS@;
/// Largest number of steps on the path from the home position.
const MOST_STRIDES: Real = 1000.0;
/// Closure error of the loops below which no further correction follows.
const DONE: Real = @DONE@;
/// Largest closure error that is accepted if corrections no longer reduce the error.
const CLOSED: Real = @CLOSED@;
/// Largest squared relative change in a Newton step at which the iteration counts as converged.
const SETTLED: Real = @SETTLED@;
/// Squared relative change in a Newton step below which convergence is assumed to be quadratic.
const COARSE: Real = @COARSE@;
/// Square of the relative rounding error.
const ROUNDING: Real = @ROUNDING@;
/// Magnitude, m/s or rad/s, of the rates that represent the direction of incipient motion at rest.
const CREEP: Real = @REST@;

const HOME_TREE: [Real; TREE] = [
@HOME@];

/// Home position, m or rad: [`State::new`] starts from this configuration, in which the loops are
/// closed.
pub const HOME: [Real; COORDINATES] = [
@HOME_VALUES@];

/// Largest change of each coordinate, m or rad, in one step of the path from the home position.
const STRIDE: [Real; COORDINATES] = [
@STRIDES@];

/// Mathematical functions, for example those of `std` or of a library for the target.
pub trait Math {
    /// Square root.
    fn sqrt(x: Real) -> Real;
    /// Sine and cosine.
    fn sin_cos(x: Real) -> (Real, Real);
    /// Exponential function.
    fn exp(x: Real) -> Real;
    /// Natural logarithm.
    fn ln(x: Real) -> Real;
    /// Angle of the vector (x, y), rad.
    fn atan2(y: Real, x: Real) -> Real;
}

/// Outcome of a call. With `Done`, `Undetermined` and `Frictionless`, `tau` is the result of this
/// call; with all other codes, `tau` is the last result stored in the [`State`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// Success.
    Done,
    /// Success, but joints are at rest: a rule chose the direction of their friction, see [`Rest`].
    Undetermined,
    /// The efforts do not include friction: friction has no solution, a joint is at rest while
    /// others move, or the position is far from those for which the code was generated.
    Frictionless,
    /// An input is NaN or infinite.
    BadInput,
    /// The loops cannot be closed, starting from the last position.
    Open,
    /// The position is singular, or a singular position lies between it and the home position.
    Singular,
}

/// Rule for friction at rest, while all rates and accelerations are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Friction opposes the direction of the last motion.
    Held,
    /// Friction opposes the direction of the last motion. Every call at rest multiplies the
    /// friction by [`Params::fade`].
    Faded,
    /// No friction.
    Zero,
}

/// Parameters that can be changed between calls; by default those of the model.
#[derive(Clone, Debug)]
pub struct Params {
@FIELDS@    /// Rates and accelerations up to this magnitude count as zero, SI units.
    pub rest_rate: Real,
    /// Factor, from 0 to 1, by which every call at rest multiplies the friction with
    /// [`Rest::Faded`].
    pub fade: Real,
    /// Rule for friction at rest.
    pub rest: Rest,
    /// `true` to compute the singularity index in every call, `false` to compute it only where the
    /// determinant is below @SMALL_DETERMINANT@.
    pub wants_index: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self {
@DEFAULTS@            rest_rate: @REST@,
            fade: 0.99,
            rest: Rest::Held,
            wants_index: true,
        }
    }
}

/// Details about the result of a call.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Closure error of the loops: lengths are divided by the characteristic length, angles are in
    /// rad.
    pub residual: Real,
    /// Singularity index (type 2, actuation): smallest singular value of the dimensionless balance
    /// of all bodies, with a characteristic length of @LENGTH@ m. It is 0 where actuators and
    /// constraints do not resist some motion, if the call has no result, or if it is not computed,
    /// see [`Params::wants_index`].
    pub singularity_index: Real,
    /// Determinant of the equations for the rates and, if prescribed coordinates are not actuated,
    /// for the efforts, relative to its value at the home position. It is positive on the same side
    /// of all singular positions as the home position, and 0 if the coordinates or the actuators do
    /// not determine the motion.
    pub determinant: Real,
    /// Determinant of the force balance with friction, relative to that without friction: 0 if
    /// friction locks the mechanism.
    pub coupling: Real,
    /// Largest reaction force of all joints, N, and the index of the joint with this force; `None`
    /// if the efforts do not include friction.
    pub reaction: Option<(Real, usize)>,
    /// Number of position corrections in the loop closure.
    pub corrections: u32,
    /// Number of Newton steps for the coupled friction forces and reactions.
    pub steps: u32,
    /// Number of iterations (passes) of the singularity index, at most @INDEX_PASSES@.
    pub index_passes: u32,
    /// `true` if joints are at rest and a rule chose the direction of friction.
    pub undetermined: bool,
}

/// State that is kept from one call to the next: tree coordinates with closed loops, efforts,
/// direction of the last motion, and vectors of the singularity index.
#[derive(Clone, Debug)]
pub struct State {
    tree: [Real; TREE],
    tau: [Real; ACTUATORS],
    direction: [Real; COORDINATES],
    weight: Real,
    weakest: Weakest,
}

fn are_finite(x: &[Real]) -> bool {
    x.iter().all(|x| x.is_finite())
}

fn size_of(x: Real) -> Real {
    if x < 0.0 { -x } else { x }
}

fn largest(x: &[Real]) -> Real {
    let mut most = 0.0;
    for x in x {
        let size = size_of(*x);
        if size > most {
            most = size;
        }
    }
    most
}

/// Computes the square of the closure error of the loops, and a number that is positive if the
/// equations are valid.
fn find_errors<M: Math>(w: &mut [Real; POSITION_WORK], r: &mut [Real; POSITION_RESULTS]) {
@ERRORS@}

/// Computes the corrected coordinates of the tree; `find_errors` must have been called before.
fn correct<M: Math>(w: &mut [Real; POSITION_WORK], r: &mut [Real; POSITION_RESULTS]) {
@CORRECTION@}

/// Computes everything that does not depend on friction.
fn prepare<M: Math>(w: &mut [Real; FORCE_WORK], r: &mut [Real; FORCE_RESULTS]) {
@PREPARATION@}

/// Computes a Newton step of the coupled friction forces and reactions.
fn couple<M: Math>(w: &mut [Real; FORCE_WORK], r: &mut [Real; FORCE_RESULTS]) {
@STEP@}

/// Computes the actuator efforts and the reactions.
fn find_forces<M: Math>(w: &mut [Real; FORCE_WORK], r: &mut [Real; FORCE_RESULTS]) {
@FORCES@}

@SINGULARITY@
/// Closes the loops at `q`, starting from the coordinates `tree`, and updates `tree`. Returns the
/// closure error and the number of corrections; `None` if the loops cannot be closed.
fn close_loops<M: Math>(tree: &mut [Real; TREE], q: &[Real; COORDINATES]) -> Option<(Real, u32)> {
    let mut w = [0.0; POSITION_WORK];
    let mut r = [0.0; POSITION_RESULTS];
    let mut before = Real::MAX;
    w[..TREE].copy_from_slice(tree);
    w[TREE..TREE + COORDINATES].copy_from_slice(q);
    for pass in 0..=MOST_CORRECTIONS {
        find_errors::<M>(&mut w, &mut r);
        let error = M::sqrt(r[0]);
        if !error.is_finite() || !(r[1] > 0.0) {
            return None;
        }
        if error <= DONE || (error <= CLOSED && error >= before / 2.0) {
            tree.copy_from_slice(&w[..TREE]);
            return Some((error, pass));
        }
        before = error;
        if pass < MOST_CORRECTIONS {
            correct::<M>(&mut w, &mut r);
            w[..TREE].copy_from_slice(&r[..TREE]);
        }
    }
    None
}

/// Computes the results without friction for the motion in `w`. Returns `None` if the position is
/// singular.
fn solve_ideal<M: Math>(
    w: &mut [Real; FORCE_WORK],
    r: &mut [Real; FORCE_RESULTS],
    info: &mut Info,
) -> Option<[Real; ANSWERS]> {
    prepare::<M>(w, r);
    let mut ideal = [0.0; ANSWERS];
    ideal[..ACTUATORS].copy_from_slice(&r[UNKNOWNS..UNKNOWNS + ACTUATORS]);
    for k in ACTUATORS..ANSWERS {
        ideal[k] = r[UNKNOWNS + 2 + k];
    }
    let determinant = r[UNKNOWNS + ACTUATORS + 1];
    info.determinant = if determinant.is_finite() { determinant } else { 0.0 };
    if info.determinant > 0.0 && are_finite(&ideal) { Some(ideal) } else { None }
}

/// Computes the results with friction; `solve_ideal` must have been called before. Returns `None`
/// if the iteration of the friction forces does not converge, or if its result is not valid.
fn solve_friction<M: Math>(
    w: &mut [Real; FORCE_WORK],
    r: &mut [Real; FORCE_RESULTS],
    info: &mut Info,
) -> Option<[Real; ANSWERS]> {
    let holds = r[UNKNOWNS + ACTUATORS] > 0.0;
    let mut before = 0.0;
    let mut settled = UNKNOWNS == 0;
    for _ in 0..MOST_STEPS {
        w[FIRST_UNKNOWN..FIRST_UNKNOWN + UNKNOWNS].copy_from_slice(&r[..UNKNOWNS]);
        couple::<M>(w, r);
        info.steps += 1;
        if settled {
            break;
        }
        let change = r[UNKNOWNS] / r[UNKNOWNS + 1];
        let cube = change * change * change;
        // Newton steps square the error, so the last two changes determine the remaining error.
        let few = change < COARSE && cube <= ROUNDING * before * before && cube <= ROUNDING;
        settled = (change <= SETTLED || few) && r[UNKNOWNS + 2] > 0.0;
        before = change;
        if settled {
            break;
        }
    }
    info.coupling = if r[UNKNOWNS + 2].is_finite() { r[UNKNOWNS + 2] } else { 0.0 };
    find_forces::<M>(w, r);
    let last = ACTUATORS + WRENCH * JOINTS;
    if !settled || !holds || !(r[last] > 0.0) || !are_finite(&r[..last]) {
        return None;
    }
    let mut most = -1.0;
    let mut joint = 0;
    for k in 0..JOINTS {
        let first = ACTUATORS + WRENCH * k;
        let square = r[first] * r[first] + r[first + 1] * r[first + 1] + r[first + 2] * r[first + 2];
        if square > most {
            most = square;
            joint = k;
        }
    }
    info.reaction = Some((if most < Real::MAX { M::sqrt(most) } else { Real::MAX }, joint));
    let mut found = [0.0; ANSWERS];
    found.copy_from_slice(&r[..ANSWERS]);
    Some(found)
}

fn set_motion(
    w: &mut [Real],
    tree: &[Real; TREE],
    q: &[Real; COORDINATES],
    rates: &[Real; COORDINATES],
    qdd: &[Real; COORDINATES],
) {
    w[..TREE].copy_from_slice(tree);
    for k in 0..COORDINATES {
        w[FIRST_TARGET + 3 * k] = q[k];
        w[FIRST_TARGET + 3 * k + 1] = rates[k];
        w[FIRST_TARGET + 3 * k + 2] = qdd[k];
    }
}

#[allow(unused_variables)]
fn set_parameters(w: &mut [Real], params: &Params) {
@TUNE@}

/// Returns rates of negligible magnitude in the given direction.
fn creep(direction: &[Real; COORDINATES]) -> [Real; COORDINATES] {
    let size = largest(direction);
    direction.map(|rate| rate / size * CREEP)
}

impl State {
    /// Creates a state with the loops closed at the positions `q`, which are reached on a straight
    /// line from the home position.
    ///
    /// # Errors
    /// [`Code::Open`] or [`Code::BadInput`].
    pub fn new<M: Math>(q: &[Real; COORDINATES]) -> Result<Self, Code> {
        if !are_finite(q) {
            return Err(Code::BadInput);
        }
        let mut far_away = 0.0;
        for k in 0..COORDINATES {
            let distance = size_of(q[k] - HOME[k]) / STRIDE[k];
            if distance > far_away {
                far_away = distance;
            }
        }
        if !(far_away < MOST_STRIDES) {
            return Err(Code::Open);
        }
        let strides = 1 + far_away as u32;
        let mut tree = HOME_TREE;
        for stride in 1..=strides {
            let mut towards = *q;
            if stride < strides {
                for k in 0..COORDINATES {
                    towards[k] = HOME[k] + (q[k] - HOME[k]) / strides as Real * stride as Real;
                }
            }
            if close_loops::<M>(&mut tree, &towards).is_none() {
                return Err(Code::Open);
            }
        }
        let (tau, direction) = ([0.0; ACTUATORS], [0.0; COORDINATES]);
        Ok(Self { tree, tau, direction, weight: 0.0, weakest: first_vectors::<M>() })
    }

    /// Computes the efforts `tau` of the actuators for positions `q`, rates `qd` and accelerations
    /// `qdd`. At rest, friction opposes the rates `direction`, of which only the ratios count.
    /// Without `direction`, friction at rest opposes the motion that begins with the accelerations;
    /// if these vanish too, [`Params::rest`] applies.
    pub fn ff<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
        qdd: &[Real; COORDINATES],
        direction: Option<&[Real; COORDINATES]>,
        tau: &mut [Real; ACTUATORS],
    ) -> (Code, Info) {
        let (code, info, _) = self.answer::<M>(params, q, (qd, qdd, direction), tau);
        (code, info)
    }

    /// Computes the efforts that hold the position `q` at rest, against weight and springs. With a
    /// `direction` of rates, of which only the ratios count, the efforts also overcome the friction
    /// of a motion that begins in this direction. Without `direction`, they contain no friction.
    pub fn hold<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        direction: Option<&[Real; COORDINATES]>,
        tau: &mut [Real; ACTUATORS],
    ) -> (Code, Info) {
        let at_rest = Params { rest: Rest::Zero, ..params.clone() };
        let still = [0.0; COORDINATES];
        // The call works on a copy, so that the direction of the last motion does not change.
        let mut copy = self.clone();
        let (code, info) = copy.ff::<M>(&at_rest, q, &still, &still, direction, tau);
        match code {
            Code::Done | Code::Undetermined => {
                (self.tree, self.tau, self.weakest) = (copy.tree, copy.tau, copy.weakest);
                // No rule chose a direction: the direction is given, or there is no friction.
                (Code::Done, Info { undetermined: false, ..info })
            }
            Code::Frictionless => {
                (self.tree, self.tau, self.weakest) = (copy.tree, copy.tau, copy.weakest);
                (code, info)
            }
            _ => (code, info),
        }
    }

    /// Computes the efforts as `ff` does, and also returns all results: the efforts and, if the
    /// code computes them, the wrenches of all joints.
    fn answer<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        (qd, qdd, direction): (
            &[Real; COORDINATES],
            &[Real; COORDINATES],
            Option<&[Real; COORDINATES]>,
        ),
        tau: &mut [Real; ACTUATORS],
    ) -> (Code, Info, [Real; ANSWERS]) {
        let nothing = [0.0; ANSWERS];
        let mut info = Info {
            residual: 0.0,
            singularity_index: 0.0,
            determinant: 0.0,
            coupling: 0.0,
            reaction: None,
            corrections: 0,
            steps: 0,
            index_passes: 0,
            undetermined: false,
        };
        *tau = self.tau;
        let is_given = direction.map_or(true, |direction| are_finite(direction));
        if !are_finite(q) || !are_finite(qd) || !are_finite(qdd) || !is_given {
            return (Code::BadInput, info, nothing);
        }
        let mut tree = self.tree;
        match close_loops::<M>(&mut tree, q) {
            Some((residual, corrections)) => {
                info.residual = residual;
                info.corrections = corrections;
            }
            None => return (Code::Open, info, nothing),
        }
        let before = (self.direction, self.weight);
        let direction = direction.filter(|direction| largest(*direction) > 0.0);
        let solved = self.solve::<M>(params, &tree, q, (qd, qdd, direction), &mut info);
        match solved {
            Some((code, found)) if are_finite(&found) => {
                self.tree = tree;
                self.tau.copy_from_slice(&found[..ACTUATORS]);
                *tau = self.tau;
                (code, info, found)
            }
            _ => {
                (self.direction, self.weight) = before;
                (Code::Singular, info, nothing)
            }
        }
    }

    /// Computes all results at a position with closed loops. If the mechanism is at rest, chooses
    /// the direction that friction opposes. Returns `None` if the position is singular.
    fn solve<M: Math>(
        &mut self,
        params: &Params,
        tree: &[Real; TREE],
        q: &[Real; COORDINATES],
        (qd, qdd, direction): (
            &[Real; COORDINATES],
            &[Real; COORDINATES],
            Option<&[Real; COORDINATES]>,
        ),
        info: &mut Info,
    ) -> Option<(Code, [Real; ANSWERS])> {
        let mut w = [0.0; FORCE_WORK];
        let mut r = [0.0; FORCE_RESULTS];
        // Direction in which motion begins if the mechanism is at rest now.
        let mut next = *direction.unwrap_or(qdd);
        let slow = if params.rest_rate >= 0.0 { params.rest_rate } else { 0.0 };
        let rests = largest(qd) <= slow;
        let has_next = direction.is_some() || largest(qdd) > slow;
        let mut rates = *qd;
        let mut weight = 1.0;
        if rests {
            info.undetermined = true;
            if !has_next {
                next = self.direction;
                weight = match params.rest {
                    Rest::Held => self.weight,
                    Rest::Faded => self.weight * params.fade,
                    Rest::Zero => 0.0,
                };
            }
            // A factor that is NaN or out of bounds yields no friction.
            if !(weight >= 0.0 && weight <= 1.0) {
                weight = 0.0;
            }
            if largest(&next) > 0.0 {
                rates = creep(&next);
            } else {
                weight = 0.0;
            }
        }
        set_parameters(&mut w, params);
        set_motion(&mut w, tree, q, &rates, qdd);
        let ideal = solve_ideal::<M>(&mut w, &mut r, info);
        if params.wants_index || info.determinant < SMALL_DETERMINANT {
            find_index::<M>(&r[FIRST_PLACE..], &mut self.weakest, info);
            if !(info.singularity_index > LEAST_INDEX) {
                return None;
            }
        }
        let mut tau = ideal?;
        let mut has_friction = true;
        if weight > 0.0 {
            let mut with = solve_friction::<M>(&mut w, &mut r, info);
            if with.is_none() && !rests && largest(&next) > 0.0 {
                // A joint is at rest while others move: the accelerations determine the direction
                // in which it begins to move.
                let mut moved = creep(&next);
                for k in 0..COORDINATES {
                    moved[k] += qd[k];
                }
                set_motion(&mut w, tree, q, &moved, qdd);
                if solve_ideal::<M>(&mut w, &mut r, info).is_some() {
                    with = solve_friction::<M>(&mut w, &mut r, info);
                }
                info.undetermined = with.is_some();
            }
            has_friction = with.is_some();
            if let Some(with) = with {
                for k in 0..ANSWERS {
                    tau[k] += weight * (with[k] - tau[k]);
                }
            }
        }
        if !rests || has_next {
            let last = if rests { next } else { *qd };
            let size = largest(&last);
            self.direction = last.map(|rate| rate / size);
            self.weight = 1.0;
        } else {
            self.weight = weight;
        }
        let code = match (has_friction, info.undetermined) {
            (false, _) => Code::Frictionless,
            (true, true) => Code::Undetermined,
            (true, false) => Code::Done,
        };
        Some((code, tau))
    }
}
@REACTIONS@@KINEMATICS@@LINEARIZE@@DERIVATIVES@@ACCELERATIONS@