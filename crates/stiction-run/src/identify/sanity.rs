//! Plausibility of a fit: wrong signs and units of efforts, confounded pairs of parameters, and the verdict on the fit.

use super::identified::{Combined, Named, Prediction};
use super::prepare::Prepared;
use super::run::differences;
use nalgebra::DVector;
use stiction_draw::numbers::number;
use stiction_identify::{
    BaseParameters, Estimate, FitVerdict, Kind, LeftOut, Options, Parameter, Verdict,
};

/// Magnitude of the correlation between the errors of two parameters above which the parameters
/// count as confounded.
const CONFOUNDED: f64 = 0.95;
/// Largest number of confounded pairs that the results list.
const NAMED: usize = 20;

/// Magnitude of the cosine between measured and expected efforts above which a sign or a unit
/// counts as certain.
const AGREES: f64 = 0.5;

/// Range of an angle, in turns, above which positions are probably not in radians. This holds only
/// if the ratio of measured efforts to those of the model is below [`IMPLAUSIBLE`].
const TURNS: f64 = 2.0;
/// Ratio of measured efforts to those of the model below which the unit of the positions is in
/// doubt; see [`TURNS`].
const IMPLAUSIBLE: f64 = 0.3;
/// Relative error of the efforts of the identified model up to which the sign of the measured
/// efforts is not in doubt.
const REPRODUCED: f64 = 0.1;
/// Relative error of the efforts of the identified model up to which the sign of the measured
/// efforts is not in doubt, provided that friction opposes the motion.
const FOLLOWED: f64 = 0.5;

/// Doubt about the sign or the unit of an effort, in words.
#[derive(Debug)]
pub(super) struct Doubt {
    pub(super) text: String,
    pub(super) has_wrong_sign: bool,
}

/// Finds efforts that contradict the model because of a wrong sign or unit. Efforts that agree with
/// the identified values, but not with the original model, indicate wrong values in the model.
pub(super) fn wrong_efforts(
    logs: &[&Prepared],
    (parameters, values): (&[Parameter], &[f64]),
    actuators: &[String],
) -> Vec<Doubt> {
    let identified = differences(parameters, values);
    let frictionless = DVector::from_fn(identified.len(), |k, _| match parameters[k].kind {
        // The right-hand side contains the column of the excess at its latest value.
        Kind::StaticExcess(_) => identified[k],
        kind if kind.is_friction() => 0.0,
        _ => identified[k],
    });
    let mut found = Vec::new();
    for (channel, name) in actuators.iter().enumerate() {
        let (mut mm, mut pp, mut mp, mut left) = (0.0, 0.0, 0.0, 0.0);
        for log in logs {
            let (rows, predicted) = (&log.block.channels[channel], &log.by_model[channel]);
            mm += rows.measured.norm_squared();
            pp += predicted.norm_squared();
            mp += rows.measured.dot(predicted);
            left += rows.residuals(&identified).norm_squared();
        }
        if mm == 0.0 {
            continue;
        }
        let agreement = if pp > 0.0 { mp / (mm * pp).sqrt() } else { 0.0 };
        let friction = [1.0, -1.0].map(|sign| friction_agreement(logs, channel, (sign, None)));
        let help = "give the column `factor = -1` in the options";
        let error = (left / mm).sqrt();
        // Friction dissipates power, regardless of its magnitude in the model.
        let opposes = friction_agreement(logs, channel, (1.0, Some(&frictionless)));
        let mut doubt = |text: String, has_wrong_sign| found.push(Doubt { text, has_wrong_sign });
        let is_reproduced = error < REPRODUCED && opposes > -AGREES;
        if agreement < -AGREES && (is_reproduced || (opposes > AGREES && error < FOLLOWED)) {
            doubt(
                format!(
                    "efforts on {name} have the opposite sign of those of the unchanged model \
                     (correlation {agreement:.2}), but the identified values reproduce them with \
                     an error of {:.1} %: check masses and centres of mass of the model, or the \
                     sign of the efforts",
                    100.0 * error
                ),
                false,
            );
        } else if agreement < -AGREES {
            doubt(
                format!(
                    "efforts have the wrong sign on {name}: their correlation with those of the \
                     model is {agreement:.2}; {help}"
                ),
                true,
            );
        } else if agreement < AGREES && friction[0] < -AGREES && friction[1] > AGREES {
            doubt(
                format!(
                    "efforts have the wrong sign on {name}: after subtraction of inertia and weight, \
                     they act in the direction of motion (correlation {:.2}), not against it; {help}",
                    -friction[0]
                ),
                true,
            );
        } else if opposes < -AGREES && error > REPRODUCED {
            doubt(
                format!(
                    "the fit does not explain {:.0} % of the efforts on {name}; the rest acts in the direction of motion, \
                     as negative friction would: check the sign of the efforts and their delay",
                    100.0 * error
                ),
                false,
            );
        }
        let ratio = (mm / pp).sqrt();
        if agreement.abs() < 0.7
            && ratio < IMPLAUSIBLE
            && logs.iter().any(|log| log.turns() > TURNS)
        {
            doubt(
                format!(
                    "an angle spans {:.1} turns, and according to the model its motion needs {:.1} \
                     times the efforts measured on {name}: check the unit of the positions (rad \
                     or m if the header has none)",
                    logs.iter().map(|log| log.turns()).fold(0.0, f64::max),
                    ratio.recip()
                ),
                false,
            );
        }
        if agreement.abs() > 0.7 && !(0.05..=20.0).contains(&ratio) {
            doubt(
                format!(
                    "efforts on {name} are {ratio:.3} times those of the model: check their unit, ratio and torque \
                     constant"
                ),
                false,
            );
        }
    }
    found
}

/// Returns the cosine between the friction part of the measured efforts and the direction or the
/// rate of motion, whichever fits better. The friction part is the residual with the parameter
/// values `frictionless`. If these are `None`, it is `sign` times the measured effort, minus the
/// effort of the model without friction.
fn friction_agreement(
    logs: &[&Prepared],
    channel: usize,
    (sign, frictionless): (f64, Option<&DVector<f64>>),
) -> f64 {
    let (mut square, mut squares, mut products) = (0.0, [0.0; 2], [0.0; 2]);
    for log in logs {
        let rows = &log.block.channels[channel];
        let own = frictionless.map(|values| rows.residuals(values));
        for (row, direction) in log.directions[channel].iter().enumerate() {
            let left = match &own {
                Some(residuals) => residuals[row],
                None => sign * rows.measured[row] - log.known[channel][row],
            };
            square += left * left;
            for k in 0..2 {
                squares[k] += direction[k] * direction[k];
                products[k] += left * direction[k];
            }
        }
    }
    let cosines = [0, 1].map(|k| products[k] / (square * squares[k]).sqrt().max(1e-300));
    if cosines[0].abs() > cosines[1].abs() { cosines[0] } else { cosines[1] }
}

/// Returns the largest magnitude of the correlation between the errors of parameter `k` and of any
/// other free parameter. Parameters that the options tie to `k` are excluded.
pub(super) fn largest_correlation(estimate: &Estimate, options: &Options, k: usize) -> f64 {
    let is_tied =
        |i: usize| options.tied.iter().any(|group| group.contains(&i) && group.contains(&k));
    (0..options.held.len())
        .filter(|&i| i != k && !options.held[i] && !is_tied(i))
        .map(|i| estimate.correlation[(i, k)].abs())
        .fold(0.0, f64::max)
}

/// Residuals of the fit, and the scales to which the residuals are compared.
pub(super) struct Residuals<'a> {
    /// Standard deviation of the white noise of each effort; `None` for tables of steady motions.
    pub(super) noise: Option<&'a [f64]>,
    /// Standard deviation of each measured effort, and of the measured effort minus the effort of
    /// the model without friction, N or N m.
    pub(super) reference: &'a [[f64; 2]],
    pub(super) actuators: &'a [String],
}

/// Fractions of the two standard deviations in [`Residuals::reference`]. If the residual of an
/// effort exceeds either fraction and is well above the noise, the model is incomplete.
const LACKING: [f64; 2] = [0.05, 0.1];

/// Lists the pairs of parameters that the data cannot distinguish because their errors are
/// correlated. The third text of each pair is advice on data that would distinguish them.
pub(super) fn confounded(
    named: &[Named],
    estimate: &Estimate,
    parameters: &[Parameter],
    options: &Options,
) -> Vec<(String, String, String)> {
    let is_tied = |i: usize, k: usize| {
        options.tied.iter().any(|group| group.contains(&i) && group.contains(&k))
    };
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for i in 0..parameters.len() {
        for k in i + 1..parameters.len() {
            if options.held[i] || options.held[k] || is_tied(i, k) {
                continue;
            }
            let is_open = |k: usize| named[k].verdict != Verdict::Identified;
            let size = estimate.correlation[(i, k)].abs();
            if size > CONFOUNDED && (is_open(i) || is_open(k)) {
                pairs.push((size, i, k));
            }
        }
    }
    // Pairs of friction parameters come first, because a second log can separate them.
    let is_friction = |k: usize| parameters[k].body().is_none();
    pairs.sort_by(|a, b| {
        let rank = |p: &(f64, usize, usize)| is_friction(p.1) && is_friction(p.2);
        rank(b).cmp(&rank(a)).then(b.0.total_cmp(&a.0))
    });
    let each = pairs.into_iter().take(NAMED).map(|(_, i, k)| {
        (
            parameters[i].name.clone(),
            parameters[k].name.clone(),
            cure(&parameters[i], &parameters[k]),
        )
    });
    each.collect()
}

/// Returns cautions on friction coefficients that are confounded with another parameter.
pub(super) fn uncertain(named: &[Named], confounded: &[(String, String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for p in named.iter().filter(|p| p.name.ends_with(".mu")) {
        let pair = confounded.iter().find(|(a, b, _)| *a == p.name || *b == p.name);
        let Some((a, b, cure)) = pair else { continue };
        let other = if *a == p.name { b } else { a };
        let extent = match p.verdict {
            Verdict::NotExcited => "not identifiable",
            Verdict::FitsOnly => "only weakly identifiable",
            _ => continue,
        };
        found.push(format!(
            "{} is {extent} from these logs: {:.3} +- {:.3}, confounded with {other}; {cure}",
            p.name, p.value, p.sigma
        ));
    }
    found
}

fn cure(a: &Parameter, b: &Parameter) -> String {
    let mu = |p: &Parameter| matches!(p.kind, Kind::Mu(_));
    let constant = |p: &Parameter| matches!(p.kind, Kind::Coulomb(_) | Kind::DriveCoulomb(_));
    let excess = |p: &Parameter| matches!(p.kind, Kind::StaticExcess(_));
    let viscous = |p: &Parameter| matches!(p.kind, Kind::Viscous(_) | Kind::DriveViscous(_));
    let text = match (a, b) {
        (a, b) if (mu(a) && constant(b)) || (mu(b) && constant(a)) => {
            "one payload cannot separate mu from the bearing's own friction: log a second payload \
             of at least half the mass that the joint carries"
        }
        (a, b) if mu(a) && mu(b) => {
            "the loads of these joints rise and fall together: log another payload or a motion in another part \
             of the workspace, or tie their coefficients"
        }
        (a, b) if excess(a) || excess(b) => "log slow motions and more reversals",
        (a, b) if (constant(a) || mu(a)) && viscous(b) || (constant(b) || mu(b)) && viscous(a) => {
            "log slow and fast motions"
        }
        (a, b) if [a, b].iter().any(|p| matches!(p.kind, Kind::TorqueConstant(_))) => {
            "log a heavier payload of known mass, or keep a known inertia fixed with `hold`: \
             either determines the ratio of torque to current"
        }
        (a, b) if a.body().is_some() && b.body().is_some() => {
            "only their combination acts on the efforts, or these motions do not separate them"
        }
        _ => {
            "log a motion that moves their joints differently, or keep one of the parameters \
             fixed with `hold`"
        }
    };
    text.to_owned()
}

/// Largest number of parameters and combinations that a caution on errors due to the filter names.
const BIASED: usize = 6;

/// Stores the errors of parameters and combinations due to the filter. Those whose error exceeds
/// their standard deviation no longer count as identified; the function returns a caution that
/// names them, or `None` if all errors are smaller.
pub(super) fn judge_filter(
    (named, combinations): (&mut [Named], &mut [Combined]),
    structure: &BaseParameters,
    biases: &[f64],
) -> Option<String> {
    let mut found: Vec<(String, f64)> = Vec::new();
    let mut judge = |name: &str, verdict: &mut Verdict, bias: f64, sigma: f64| {
        if *verdict == Verdict::Identified && bias.abs() > sigma {
            *verdict = Verdict::FitsOnly;
            found.push((format!("{name} by {bias:.3e} (sigma {sigma:.1e})"), bias.abs() / sigma));
        }
    };
    for (p, &bias) in named.iter_mut().zip(biases) {
        p.filter_bias = if p.verdict == Verdict::Held { 0.0 } else { bias };
        judge(&p.name, &mut p.verdict, p.filter_bias, p.sigma);
    }
    for (c, shared) in combinations.iter_mut().zip(structure.shared()) {
        c.filter_bias = shared.value(biases);
        judge(&c.name, &mut c.verdict, c.filter_bias, c.sigma);
    }
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let texts: Vec<&str> = found.iter().take(BIASED).map(|(text, _)| text.as_str()).collect();
    let more = match found.len().saturating_sub(BIASED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!texts.is_empty()).then(|| {
        format!(
            "the filter removes part of the motion, which changes {}{more}: give a higher cut-off \
             frequency with --filter, or log slower motions",
            texts.join(", ")
        )
    })
}

/// Decides the verdict on the fit, and adds the reasons to `cautions`. `wrong` is true if the
/// efforts have a wrong sign.
pub(super) fn fit_verdict(
    (named, combinations, predictions): (&[Named], &[Combined], &[Prediction]),
    (estimate, left_out): (&Estimate, LeftOut),
    residuals: &Residuals<'_>,
    wrong: bool,
    cautions: &mut Vec<String>,
) -> FitVerdict {
    let mean = |p: &Prediction| {
        let all: Vec<f64> = p.error_percent.iter().filter_map(|(_, e)| *e).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    let fits: Vec<&Prediction> = predictions.iter().filter(|p| p.used_for_fit).collect();
    let errors: Vec<f64> = fits.iter().filter_map(|p| mean(p)).collect();
    let error = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    let mut verdict = FitVerdict::Identified;
    if left_out.plain > 1.3 * left_out.ratio {
        cautions.push(format!(
            "plain least squares is refused: in cross-validation, without the prior, the squared \
             residuals of left-out blocks of the logs are {:.1} times those of the fit ({:.1} \
             times with the prior of {} equivalent samples)",
            left_out.plain,
            left_out.ratio,
            number(estimate.strength)
        ));
    }
    if left_out.ratio > 2.0 {
        cautions.push(format!(
            "in cross-validation, the squared residuals of left-out blocks of the logs are {:.1} \
             times those of the fit: the fit may not hold for other motions",
            left_out.ratio
        ));
        verdict = FitVerdict::FitsOnly;
    }
    for (index, name) in residuals.actuators.iter().enumerate() {
        let Some(noise) = residuals.noise.map(|noise| noise[index]) else { break };
        let residual = estimate.noise[index];
        let mut references = residuals.reference[index].iter().zip(LACKING);
        if residual > 3.0 * noise && references.any(|(size, part)| residual > part * size) {
            cautions.push(format!(
                "{name}: residuals are {:.1} times the noise of the effort: the model lacks an effect, such as \
                 compliance, backlash or another law of friction",
                residual / noise.max(1e-300)
            ));
            verdict = FitVerdict::FitsOnly;
        }
    }
    for p in predictions.iter().filter(|p| !p.used_for_fit) {
        let Some(own) = mean(p) else { continue };
        if own > 1.5 * error && own > 3.0 {
            cautions.push(format!(
                "{}: the error is {:.1} %, but {error:.1} % in the fitted logs: the fit does not hold for this log",
                p.log, own
            ));
            verdict = FitVerdict::FitsOnly;
        }
    }
    let identified = named.iter().filter(|p| p.verdict == Verdict::Identified).count()
        + combinations.iter().filter(|c| c.verdict == Verdict::Identified).count();
    if identified == 0 {
        verdict = FitVerdict::NotExcited;
    }
    // Finds the actuator that the model reproduces worst. Efforts that are mostly noise do not
    // count as errors of the model.
    let is_noise =
        |k: usize, residual: f64| residuals.noise.is_some_and(|noise| residual < 3.0 * noise[k]);
    let each = fits.iter().flat_map(|p| p.error_percent.iter().zip(&p.residual).enumerate());
    let each = each.filter_map(|(k, ((name, error), residual))| {
        Some((name, (*error)?, is_noise(k, *residual)))
    });
    let bad = each.filter(|(_, error, _)| error.is_nan() || *error > 70.0);
    let (noisy, bad): (Vec<_>, Vec<_>) = bad.partition(|(.., is_noise)| *is_noise);
    for (name, error, _) in noisy {
        cautions.push(format!(
            "the efforts of {name} are mostly noise: the error is {error:.0} % of their root mean square, and residuals \
             are less than three times the noise"
        ));
    }
    if let Some((name, error, _)) = bad.iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
        cautions.push(format!(
            "the model does not reproduce the efforts of {name}: the error is {error:.0} % of their root mean square"
        ));
    }
    if !bad.is_empty() || wrong {
        verdict = FitVerdict::Failed;
    }
    verdict
}
