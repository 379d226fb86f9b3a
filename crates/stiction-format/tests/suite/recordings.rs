//! Quality checks of recordings: clean recordings cause no warning, defects are reported. Dialects
//! of CSV.

use std::fmt::Write as _;
use stiction_format::{Contents, Diagnostics, ModelFile, Motion, Source, read};

const SLIDER: &str = "\
gravity = [0, 0, 0]
[bodies.link]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[joints.A]
type = \"P\"
from = \"ground\"
to = \"link\"
axis = \"z\"
actuated = true
";

fn slider() -> ModelFile {
    read(&Source::new("slider.toml", SLIDER), &|_| Err("no files".into())).unwrap()
}

fn motion(text: &str) -> Result<Motion, Diagnostics> {
    let files = |_: &str| Ok(Contents::from(text));
    slider().parse_motion(&Source::new("--motion", "log.csv"), &files)
}

/// Pseudorandom numbers (xorshift).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// Approximately normal random number of unit variance.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// Samples of a motion: time, s, then position, m, and its derivatives.
type Sample = [f64; 4];

/// A clean motion: sines, steps of the acceleration, point-to-point moves with dwells, chirps, or
/// steps of the jerk, each with at least ten samples per period or eight per step.
fn clean(random: &mut Random, rate: f64, count: usize) -> Vec<Sample> {
    let times = (0..count).map(|k| k as f64 / rate);
    let end = count as f64 / rate;
    match random.below(5) {
        0 => {
            let sine = |random: &mut Random| {
                let frequency = random.log_between(0.3 / end, rate / 10.0);
                let amplitude =
                    random.log_between(1e-3, 1.0) / (1.0 + (frequency * end / 5.0).powi(2));
                (
                    amplitude,
                    frequency * std::f64::consts::TAU,
                    random.between(0.0, std::f64::consts::TAU),
                )
            };
            let sines: Vec<_> = (0..=random.below(4)).map(|_| sine(random)).collect();
            let sum = |t: f64, order: i32| -> f64 {
                let term = |&(a, w, p): &(f64, f64, f64)| {
                    a * w.powi(order)
                        * (w * t + p + f64::from(order) * 0.5 * std::f64::consts::PI).sin()
                };
                sines.iter().map(term).sum()
            };
            times.map(|t| [t, sum(t, 0), sum(t, 1), sum(t, 2)]).collect()
        }
        1 => {
            let length = random.log_between(20.0, 400.0) / rate;
            let size = random.log_between(0.01, 100.0);
            let (mut begin, mut y, mut v, mut a) = (0.0, random.between(-1.0, 1.0), 0.0, size);
            let mut next = length * random.between(0.5, 1.5);
            let step = |t: f64| {
                while t >= next {
                    let d = next - begin;
                    y += v * d + 0.5 * a * d * d;
                    v += a * d;
                    let is_zero = random.unit() < 0.3;
                    let new = -f64::signum(v) * random.unit() + 0.3 * random.between(-1.0, 1.0);
                    a = if is_zero { 0.0 } else { size * new };
                    begin = next;
                    next += length * random.between(0.5, 1.5);
                }
                let d = t - begin;
                [t, y + v * d + 0.5 * a * d * d, v + a * d, a]
            };
            times.map(step).collect()
        }
        2 => {
            let length = random.log_between(30.0, 1000.0) / rate;
            let (mut begin, mut d) = (0.0, length);
            let mut from = random.between(-1.0, 1.0);
            let mut to = from;
            let step = |t: f64| {
                while t >= begin + d {
                    (begin, from) = (begin + d, to);
                    d = length * random.between(0.5, 1.5);
                    if random.unit() < 0.7 {
                        to += random.between(-0.3, 0.3);
                    }
                }
                let (u, h) = ((t - begin) / d, to - from);
                let rest = 1.0 - u;
                [
                    t,
                    from + h * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u),
                    h / d * 30.0 * u * u * rest * rest,
                    h / d / d * 60.0 * u * rest * (1.0 - 2.0 * u),
                ]
            };
            times.map(step).collect()
        }
        3 => {
            let amplitude = random.log_between(1e-4, 0.1);
            let chirp = std::f64::consts::PI * rate / random.between(10.0, 50.0) / end;
            let at = |t: f64| {
                let (phase, w) = (chirp * t * t, 2.0 * chirp * t);
                let (sin, cos) = phase.sin_cos();
                let a = amplitude;
                [t, a * sin, a * w * cos, a * (2.0 * chirp * cos - w * w * sin)]
            };
            times.map(at).collect()
        }
        _ => {
            let length = random.log_between(25.0, 400.0) / rate;
            let size = random.log_between(0.1, 1000.0);
            let (mut begin, mut y, mut v, mut a, mut jerk) = (0.0, 0.3, 0.0, 0.0, size);
            let mut next = length;
            let step = |t: f64| {
                while t >= next {
                    let d = next - begin;
                    y += v * d + 0.5 * a * d * d + jerk * d * d * d / 6.0;
                    v += a * d + 0.5 * jerk * d * d;
                    a += jerk * d;
                    jerk = -f64::signum(a) * random.unit() * size;
                    begin = next;
                    next += length * random.between(0.5, 1.5);
                }
                let d = t - begin;
                [
                    t,
                    y + v * d + 0.5 * a * d * d + jerk * d * d * d / 6.0,
                    v + a * d + 0.5 * jerk * d * d,
                    a + jerk * d,
                ]
            };
            times.map(step).collect()
        }
    }
}

/// Text of a recording with `orders` columns beside the time, its numbers with `digits` significant
/// digits.
fn file(samples: &[Sample], orders: usize, digits: usize) -> String {
    let header = ["time [s]", "A [m]", "d(A) [m/s]", "dd(A) [m/s^2]"];
    let mut text = header[..=orders].join(",") + "\n";
    for sample in samples {
        let _ = write!(text, "{}", sample[0]);
        for number in &sample[1..=orders] {
            let _ = write!(text, ",{number:.0$e}", digits - 1);
        }
        text.push('\n');
    }
    text
}

fn cases() -> u64 {
    std::env::var("STICTION_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(150)
}

fn sampling(random: &mut Random) -> (f64, usize) {
    let rates = [100.0, 200.0, 250.0, 500.0, 1000.0, 2000.0, 5000.0, 8000.0, 10000.0];
    (rates[random.below(rates.len())], 300 + random.below(1500))
}

/// A program that writes the shortest form of each number writes `1` for a position at rest; its
/// other numbers show that it writes full precision.
#[test]
fn digits_that_a_program_leaves_out_are_known() {
    let mut text = "time [s],A [m]\n".to_owned();
    for k in 0..400 {
        // At rest for half of the time, followed by a smooth start.
        let s = (f64::from(k) - 200.0).max(0.0) / 200.0;
        let _ =
            writeln!(text, "{},{}", 0.01 * f64::from(k), 1.0 + 0.3 * s.powi(5) * (3.0 - 2.0 * s));
    }
    let found = motion(&text).unwrap();
    assert!(found.notes[0].contains("peak acceleration"), "{}", found.notes[0]);
    assert!(!found.notes[0].contains("uncertain"), "{}", found.notes[0]);
    assert!(found.warnings.is_empty(), "{}", found.warnings);
}

/// A constant coordinate has no suspicious accelerations, whatever the number of digits.
#[test]
fn a_constant_coordinate_causes_no_alarm() {
    let mut text = "time [s],A [m]\n".to_owned();
    for k in 0..300 {
        let _ = writeln!(text, "{},0.38", 0.005 * f64::from(k));
    }
    let found = motion(&text).unwrap();
    assert!(found.warnings.is_empty(), "{}", found.warnings);
}

/// A motion that begins among the last samples, or ends among the first ones, is no jump, although
/// its acceleration exceeds the slow motion before by far.
#[test]
fn a_motion_at_an_end_causes_no_alarm() {
    let value = |k: i32, moving: f64| {
        let s = (f64::from(k) - moving).max(0.0);
        1e-7 * (0.02 * f64::from(k)).sin() + 1e-4 * s * s * s
    };
    for moving in [393.3, 394.4, 395.5, 396.6] {
        for reversed in [false, true] {
            let mut text = "time [s],A [m]\n".to_owned();
            for k in 0..400 {
                let from = if reversed { 399 - k } else { k };
                let _ = writeln!(text, "{},{}", 0.01 * f64::from(k), value(from, moving));
            }
            let found = motion(&text).unwrap();
            assert!(found.warnings.is_empty(), "{moving}: {}", found.warnings);
        }
    }
}

/// At ten samples per period, where predictions from neighbours are inaccurate, small errors of
/// positions, rates and accelerations are found.
#[test]
fn defects_at_few_samples_per_period_are_named() {
    type Defect = fn(&mut [Sample]);
    let omega = std::f64::consts::TAU / 10.0;
    let clean = |random: &mut Random| -> Vec<Sample> {
        let phase = random.between(-0.5, 0.5);
        let at = |k: u32| {
            let (sin, cos) = (omega * f64::from(k) + phase).sin_cos();
            [f64::from(k), sin, omega * cos, -omega * omega * sin]
        };
        (0..300).map(at).collect()
    };
    let defects: [(usize, Defect); 5] = [
        (1, |samples| samples[100][1] += 0.02),
        (1, |samples| samples[100..].iter_mut().for_each(|s| s[1] += 0.03)),
        (1, |samples| {
            (samples[100][1], samples[102][1]) = (samples[102][1], samples[100][1]);
        }),
        (2, |samples| samples[100][2] += 0.05),
        (2, |samples| samples.iter_mut().for_each(|s| s[2] *= 1.03)),
    ];
    for (seed, &(orders, spoil)) in (0..8).flat_map(|s| defects.iter().map(move |d| (s, d))) {
        let mut samples = clean(&mut Random::new(seed));
        let found = motion(&file(&samples, orders, 17)).unwrap();
        assert!(found.warnings.is_empty(), "{}", found.warnings);
        spoil(&mut samples);
        let report = match motion(&file(&samples, orders, 17)) {
            Ok(motion) => motion.warnings.to_string(),
            Err(errors) => errors.to_string(),
        };
        assert!(report.contains("[recording]"), "{orders} columns, seed {seed}");
    }
}

#[test]
fn clean_recordings_cause_no_alarm() {
    let mut alarms = Vec::new();
    for seed in 0..cases() {
        let random = &mut Random::new(seed + 1);
        let (rate, count) = sampling(random);
        let samples = clean(random, rate, count);
        let (orders, digits) = (1 + random.below(3), 7 + random.below(11));
        let found = motion(&file(&samples, orders, digits)).unwrap();
        if !found.warnings.is_empty() {
            alarms.push(format!("seed {seed}: {}", found.warnings));
        }
        assert_eq!(found.notes.len(), 1);
        assert!(found.notes[0].contains("peak acceleration"), "{}", found.notes[0]);
    }
    assert!(alarms.is_empty(), "{} alarms\n{}", alarms.len(), alarms.concat());
}

/// Function that adds a defect to a recording. The numbers are the largest speed, the largest
/// acceleration and the time step of the recording.
type Spoil = fn(&mut Vec<Sample>, &mut Random, [f64; 3]);

/// Defects of recordings.
const SPOILS: [(&str, Spoil); 19] = [
    ("noise", |samples, random, [_, a, h]| {
        let sigma = random.log_between(0.02, 1.0) * a * h * h / 4.0;
        samples.iter_mut().for_each(|s| s[1] += sigma * random.normal());
    }),
    ("spike", |samples, random, [_, a, h]| {
        let at = 20 + random.below(samples.len() - 40);
        samples[at][1] += random.log_between(0.2, 10.0) * a * h * h / 3.0;
    }),
    ("jump", |samples, random, [_, a, h]| {
        let at = 20 + random.below(samples.len() - 40);
        let jump = random.log_between(0.2, 10.0) * a * h * h;
        samples[at..].iter_mut().for_each(|s| s[1] += jump);
    }),
    ("rates scaled", |samples, random, _| {
        let factor = 1.0 + random.log_between(0.03, 1000.0);
        samples.iter_mut().for_each(|s| s[2] *= factor);
    }),
    ("rates of another sign", |samples, _, _| samples.iter_mut().for_each(|s| s[2] = -s[2])),
    ("rates constant", |samples, _, [v, ..]| samples.iter_mut().for_each(|s| s[2] = v)),
    ("spike of the rate", |samples, random, [v, ..]| {
        let at = 20 + random.below(samples.len() - 40);
        samples[at][2] += random.log_between(0.05, 2.0) * v;
    }),
    ("jitter of the time", |samples, random, [.., h]| {
        let size = random.log_between(0.03, 0.3) * h;
        samples.iter_mut().for_each(|s| s[0] += size * random.between(-1.0, 1.0));
    }),
    ("noise for a while", |samples, random, [_, a, h]| {
        let sigma = random.log_between(0.2, 1.0) * a * h * h / 3.0;
        let (begin, count) = (20 + random.below(samples.len() / 2), samples.len() / 10);
        samples[begin..begin + count].iter_mut().for_each(|s| s[1] += sigma * random.normal());
    }),
    ("a lost sample", |samples, random, [.., h]| {
        samples.remove(20 + random.below(samples.len() - 40));
        samples.iter_mut().enumerate().for_each(|(k, s)| s[0] = k as f64 * h);
    }),
    ("a repeated sample", |samples, random, _| {
        let at = 20 + random.below(samples.len() - 40);
        samples[at][1] = samples[at - 1][1];
    }),
    ("another unit from some sample on", |samples, random, _| {
        let at = 20 + random.below(samples.len() - 40);
        samples[at..].iter_mut().for_each(|s| s[1] *= 1000.0);
    }),
    ("rates and positions swapped", |samples, _, _| samples.iter_mut().for_each(|s| s.swap(1, 2))),
    ("times that contradict the rates", |samples, random, _| {
        let factor = 1.0 + random.log_between(0.03, 1000.0);
        samples.iter_mut().for_each(|s| s[0] *= factor);
    }),
    ("exchanged values", |samples, random, _| {
        let at = 20 + random.below(samples.len() - 40);
        let other = at + 1 + random.below(3);
        (samples[at][1], samples[other][1]) = (samples[other][1], samples[at][1]);
    }),
    ("held values", |samples, random, _| {
        let length = 2 + random.below(3);
        for k in 0..samples.len() {
            samples[k][1] = samples[k - k % length][1];
        }
    }),
    ("a spike near an end", |samples, random, [_, a, h]| {
        let (at, last) = (random.below(3), samples.len() - 1);
        let at = if random.unit() < 0.5 { at } else { last - at };
        samples[at][1] += random.log_between(5.0, 1000.0) * a * h * h;
    }),
    ("accelerations scaled", |samples, random, _| {
        let factor = 1.0 + random.log_between(0.3, 1000.0);
        samples.iter_mut().for_each(|s| s[3] *= factor);
    }),
    ("few digits", |samples, _, [_, a, h]| {
        let unit = 10f64.powf((a * h * h).log10().ceil());
        samples.iter_mut().for_each(|s| s[1] = (s[1] / unit).round() * unit);
    }),
];

/// Peak and root mean square of accelerations by second differences.
fn accelerations(samples: &[Sample]) -> [f64; 2] {
    let second = |three: &[Sample]| {
        let slope = |a: &Sample, b: &Sample| (b[1] - a[1]) / (b[0] - a[0]);
        let change = slope(&three[1], &three[2]) - slope(&three[0], &three[1]);
        2.0 * change / (three[2][0] - three[0][0])
    };
    let all: Vec<f64> = samples.windows(3).map(second).collect();
    let squares: f64 = all.iter().map(|a| a * a).sum();
    [all.iter().fold(0.0, |most, a| most.max(a.abs())), (squares / all.len() as f64).sqrt()]
}

/// Adds all defects to recordings of a seed and returns those that are not reported.
fn missed(seed: u64) -> Vec<String> {
    let mut missed = Vec::new();
    for (index, (name, spoil)) in SPOILS.iter().enumerate() {
        let random = &mut Random::new(1000 * seed + index as u64 + 7);
        let (rate, count) = sampling(random);
        let mut samples = clean(random, rate, count);
        let peak = |order: usize| samples.iter().map(|s| s[order].abs()).fold(0.0, f64::max);
        let peaks = [peak(2), peak(3), 1.0 / rate];
        // Defects have no effect on a recording that hardly moves.
        if peaks[1] == 0.0 {
            continue;
        }
        let before = accelerations(&samples);
        spoil(&mut samples, random, peaks);
        let after = accelerations(&samples);
        let of_rates = name.contains("rate");
        let of_accelerations = name.contains("accelerations");
        let differs = |k: usize| (after[k] - before[k]).abs() > 0.05 * before[k];
        if !(of_rates || of_accelerations || differs(0) || differs(1)) {
            continue;
        }
        let orders = match (of_rates, of_accelerations) {
            (_, true) => 3,
            (true, _) => 2,
            _ => 1,
        };
        let report = match motion(&file(&samples, orders, 17)) {
            Ok(motion) => motion.warnings.to_string(),
            Err(errors) => errors.to_string(),
        };
        if report.is_empty() {
            missed.push(format!("{name}, seed {seed}: {before:?} became {after:?}"));
            continue;
        }
        assert!(report.contains("[recording]"), "{report}");
        assert!(report.contains("help:"), "{report}");
    }
    missed
}

/// Checks that every defect which changes the peak or the root mean square of the acceleration by
/// more than 5 % is reported, and that wrong rates are reported.
#[test]
fn spoilt_recordings_are_named() {
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get() as u64);
    let missed: Vec<String> = std::thread::scope(|scope| {
        let part = |first| (first..cases()).step_by(threads as usize).flat_map(missed).collect();
        let spawn = |first| scope.spawn(move || -> Vec<String> { part(first) });
        let parts: Vec<_> = (0..threads).map(spawn).collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    });
    // Some errors cannot be found, such as values so coarse that the coordinate is constant. Others
    // are missed: jumps within three samples of a step of the acceleration, short noise at ten
    // samples per period, and errors of a motion that consists of the last five samples.
    let most = 3 + cases() as usize * SPOILS.len() / 1500;
    assert!(missed.len() <= most, "{}", missed.join("\n"));
}

/// The same numbers in all dialects give the same motion.
#[test]
fn dialects_of_csv() {
    let plain = "time [s],A [mm]\n0,1.5\n0.5,2.25\n1,1.5\n";
    let expected = motion(plain).unwrap();
    for text in [
        plain.replace(',', ";").replace('.', ","),
        plain.replace(',', "\t").replace('.', ","),
        plain.replace(',', "\t"),
        plain.replace(',', ";"),
        plain.replace('\n', "\r"),
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        format!("sep=;\n{}", plain.replace(',', ";")),
        "\"time [s]\",\"A [mm]\"\n\"0\",\"1,5\"\n\"0,5\",\"2,25\"\n\"1\",\"1,5\"\n".to_owned(),
        plain.replace('\n', ",\n"),
    ] {
        let found = motion(&text).unwrap_or_else(|errors| panic!("{text}\n{errors}"));
        for t in [0.0, 0.3, 0.5, 0.9, 1.0] {
            let at = |motion: &Motion| motion.at(t).next().unwrap();
            assert_eq!(at(&found), at(&expected), "{text}");
        }
    }
}

/// A stated rate or duration that contradicts the time column of a file is reported.
#[test]
fn a_time_column_that_contradicts_what_is_stated() {
    // 1001 samples at 1 kHz, with times in milliseconds under a header in seconds.
    let rows = |step: f64| {
        let row = |k: i32| format!("{},{}\n", f64::from(k) * step, 0.1 * f64::from(k * k) * 1e-6);
        "time [s],A [m]\n".to_owned() + &(0..=1000).map(row).collect::<String>()
    };
    let read = |step: f64, stated: &str| {
        let text = format!("{SLIDER}[motions.log]\nfile = \"log.csv\"\n{stated}\n");
        let files = |_: &str| Ok(Contents::from(rows(step)));
        stiction_format::read(&Source::new("slider.toml", text), &files).map(|_| ())
    };
    for stated in ["rate = \"1000 Hz\"", "rate = 1005", "duration = 1", "duration = \"1001 ms\""] {
        read(1e-3, stated).unwrap_or_else(|errors| panic!("{stated}: {errors}"));
        let errors = read(1.0, stated).unwrap_err().to_string();
        assert!(errors.contains("the time column contradicts"), "{errors}");
        assert!(errors.contains("unit of the time column"), "{errors}");
    }
    for stated in ["rate = 1020", "duration = \"0.9 s\"", "duration = 0", "rate = -1000"] {
        let errors = read(1e-3, stated).unwrap_err().to_string();
        assert!(errors.contains("the time column contradicts"), "{errors}");
    }
}

/// Files whose numbers are ambiguous are refused with a remedy.
#[test]
fn ambiguous_files_are_refused() {
    for (text, reason, remedy) in [
        ("time [s],A [m]\n0,1,5\n0,5,2,5\n", "4 columns", "semicolons"),
        ("time [s];A [m]\n0;1.5\n0,5;2.5\n", "another decimal mark", "one decimal mark"),
        ("time [s];A [m]\n0;1.234,5\n1;2\n", "thousands separators", "without thousands"),
        ("time [s],A [m]\n0,\"1,234\"\n1,2\n", "thousands separators", "without thousands"),
        ("time [s] A [m]\n0 1\n1 2\n", "separated by blanks", "commas, semicolons or tabs"),
        ("time [s],A [m]\n0,\"1\n1,2\n", "is not a number", "close the quote"),
    ] {
        let errors = motion(text).unwrap_err().to_string();
        assert!(errors.contains(reason) && errors.contains(remedy), "{errors}");
    }
}

/// Rates that clearly contradict the positions are refused, with the size of the difference and a
/// remedy.
#[test]
fn rates_that_contradict_positions() {
    let mut text = "time [s],A [m],d(A) [m/s]\n".to_owned();
    for k in 0..50 {
        let t = f64::from(k) * 0.01;
        let _ = writeln!(text, "{t},{},1000", 0.1 * (3.0 * t).sin());
    }
    let errors = motion(&text).unwrap_err().to_string();
    insta::assert_snapshot!(errors);
}

/// Checks that an impossible rate in a recording of three samples, at whose ends there are no
/// neighbours for an integral, causes a caution, and plausible rates none.
#[test]
fn an_impossible_rate_among_few_samples_is_named() {
    let said = |rates: [f64; 3]| {
        let [a, b, c] = rates;
        let rows = format!("0,1,{a}\n0.1,1.6,{b}\n0.2,2.2,{c}\n");
        motion(&format!("time,A,d(A)\n{rows}")).unwrap().cautions().collect::<Vec<_>>()
    };
    for wrong in [[0.0, -150.0, 10.0], [-150.0, 6.0, 6.0], [6.0, 6.0, 150.0]] {
        let said = said(wrong);
        assert!(said.iter().any(|one| one.contains("`d(A)` contradicts `A`")), "{said:?}");
    }
    for plausible in [[0.0, 12.0, 0.0], [6.0, 6.0, 6.0], [0.0, 8.0, 8.0]] {
        assert_eq!(said(plausible), [] as [String; 0]);
    }
}

#[test]
fn gaps_of_a_recording_are_named() {
    let rows = |moves: f64| -> String {
        let time = |k: i32| 0.02 * f64::from(k) + if k < 15 { 0.0 } else { 3.0 };
        let place = |k: i32| moves * f64::from(k) + f64::from(k).min(14.0) * (1.0 - moves);
        (0..30).map(|k| format!("{:.2},{}\n", time(k), place(k))).collect()
    };
    let text = format!("time,A\n{}", rows(1.0));
    let said: Vec<String> = motion(&text).unwrap().cautions().collect();
    let gap = said.iter().find(|one| one.contains("samples are missing"));
    assert!(gap.is_some_and(|gap| gap.contains("from t = 0.28 to 3.3 s")), "{said:?}");
    // A logger that waits while nothing moves leaves no gap.
    let text = format!("time,A\n{}", rows(0.0));
    assert!(motion(&text).unwrap().cautions().all(|one| !one.contains("missing")));
}
