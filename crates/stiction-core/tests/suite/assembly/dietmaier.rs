//! The hexapod with forty real postures of P. Dietmaier, "The Stewart-Gough platform of general
//! geometry can have 40 real postures", Advances in Robot Kinematics (1998). Each posture is found
//! from hints with few digits.

use super::postures::{Posture, joint};
use super::{Hint, found};
use crate::common::{along, v};
use stiction_core::joint::JointType::*;
use stiction_core::random::Random;
use stiction_core::spatial::{Mat3, Pose};

/// Positions of the balls on the base and on the platform, and lengths of the legs.
const BASE: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.107915, 0.0, 0.0],
    [0.549094, 0.756063, 0.0],
    [0.735077, -0.223935, 0.525991],
    [0.514188, -0.526063, -0.368418],
    [0.590473, 0.094733, -0.205018],
];
const PLATFORM: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [0.542805, 0.0, 0.0],
    [0.956919, -0.528915, 0.0],
    [0.665885, -0.353482, 1.402538],
    [0.478359, 1.158742, 0.107672],
    [-0.137087, -0.235121, 0.353913],
];
const LENGTHS: [f64; 6] = [1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071];

/// Position and rotation vector of the platform in all postures, computed by Newton's method from
/// random poses in an independent program.
#[rustfmt::skip]
const POSTURES: [[f64; 6]; 40] = [
    [0.442199, -0.713494, -0.543494, -1.888078, -0.873410, -0.575125],
    [0.443038, -0.558622, -0.701185, -1.688118, -0.903338, -0.778434],
    [0.458734, -0.373481, -0.806272, -1.490372, -0.914865, -0.972863],
    [0.477891, -0.781099, -0.401876, -1.794448, -0.559937, 0.403554],
    [0.484612, -0.873935, -0.037278, -2.370291, -0.705139, -0.072755],
    [0.485481, -0.200818, -0.850870, -1.318352, -0.914450, -1.138556],
    [0.489122, 0.696230, -0.525379, 1.790004, -0.655194, 0.436200],
    [0.521848, 0.810720, 0.265345, 2.420680, -0.961856, 0.086140],
    [0.534003, 0.006174, -0.845460, -1.106894, -0.903826, -1.337134],
    [0.535060, -0.749596, -0.389637, -1.820881, -1.312286, -0.817281],
    [0.539848, 0.678840, 0.497734, 2.605228, -0.670764, -0.189607],
    [0.585911, 0.161498, -0.794120, -0.926857, -0.889038, -1.499338],
    [0.636112, 0.771452, 0.014956, 1.596366, -0.021367, -1.313333],
    [0.667532, 0.738317, -0.096379, -1.839666, 2.230235, -1.000562],
    [0.679796, 0.348061, -0.645547, -0.629444, -0.860391, -1.742659],
    [0.689418, 0.593656, -0.415060, -1.338162, 1.525088, -1.309137],
    [0.707963, 0.685868, -0.168443, -1.534537, 2.114453, -1.135596],
    [0.719131, 0.633883, -0.284681, -1.349771, 1.858510, -1.252656],
    [0.781100, 0.068798, -0.620604, 0.914522, -1.885432, 1.315721],
    [0.803268, -0.296007, 0.516856, -1.865558, -1.390570, 0.448041],
    [0.825080, -0.318926, 0.466400, 1.877634, -0.678168, -2.357565],
    [0.832285, -0.282752, 0.476816, -1.659425, 1.013522, 2.289392],
    [0.854376, -0.294203, 0.428352, -1.313147, 1.196874, 2.158683],
    [0.855766, -0.334679, 0.394532, 1.738897, -0.281893, -2.303344],
    [0.863326, 0.005644, -0.504616, 0.843879, 0.324985, 1.393262],
    [0.870078, -0.451122, -0.198631, 2.047757, -0.186377, 2.265911],
    [0.891375, -0.079827, -0.446182, 0.343322, -2.060529, 1.390002],
    [0.903174, -0.418445, 0.095812, -0.331284, 1.355103, 1.912994],
    [0.917778, -0.111176, 0.381213, -1.347525, -1.378797, 0.867114],
    [0.955868, -0.046996, -0.290013, 0.146828, 0.435327, 1.553371],
    [0.958098, -0.284039, -0.037012, -1.904199, 0.066917, -2.460830],
    [0.968094, 0.236773, -0.082048, 1.384037, -0.262474, 1.606618],
    [0.989132, 0.116671, 0.089471, -0.781848, -0.483441, 1.327801],
    [0.991613, -0.127016, 0.023867, -1.625875, -0.069857, -2.412819],
    [0.993577, 0.079665, -0.080359, -0.406024, 0.035304, 1.497615],
    [0.993726, 0.111786, 0.003613, -0.608754, -0.215559, 1.420877],
    [0.995368, -0.051199, 0.081376, -0.409332, -2.559280, 1.416376],
    [0.998523, 0.031196, 0.044477, 0.310491, 2.513855, -1.595263],
    [0.998901, -0.041564, -0.021652, 0.599373, 1.835587, -1.768092],
    [0.999628, 0.026176, -0.007724, 0.366280, 2.192514, -1.668170],
];

/// Creates a posture with SPS legs (if `balls`) or UPS legs.
fn posture([x, y, z, a, b, c]: [f64; 6], balls: bool, random: &mut Random) -> Posture {
    let turn = v(a, b, c);
    let platform = Pose { position: v(x, y, z), rotation: Mat3::rotation(turn, turn.norm()) };
    let mut posture = Posture::new("hexapod", vec![platform]);
    for leg in 0..6 {
        let (foot, tip) = (BASE[leg].into(), platform.apply(PLATFORM[leg].into()));
        let axis = (tip - foot).direction().unwrap();
        assert!(((tip - foot).norm() - LENGTHS[leg]).abs() < 3e-6, "{leg}");
        let first = posture.poses.len();
        posture.poses.extend([along(foot, axis), along(tip, axis)]);
        let lower = if balls { Spherical } else { Universal };
        // The first axis of a universal joint is perpendicular to the leg.
        let across =
            Mat3::about_axis(1, (1.0, 0.0)) * Mat3::about_axis(2, random.number().sin_cos());
        let frame = Pose { rotation: along(foot, axis).rotation * across, position: foot };
        joint(&mut posture, lower, (0, first), frame, false, random);
        joint(&mut posture, Prismatic, (first, first + 1), along(tip, axis), true, random);
        joint(&mut posture, Spherical, (first + 1, 1), Pose::at(tip), false, random);
        posture.turned[3 * leg + 1] = vec![LENGTHS[leg]];
        if balls {
            let [w, x, y, z] = [(); 4].map(|()| random.number());
            let size = (w * w + x * x + y * y + z * z).sqrt();
            posture.turned[3 * leg] = [w, x, y, z].map(|part| part / size).to_vec();
        }
    }
    posture
}

#[test]
fn all_forty_postures_are_found() {
    let mut lost = Vec::new();
    let only: Option<usize> = std::env::var("ONE").ok().map(|x| x.parse().unwrap());
    for (index, pose) in POSTURES.into_iter().enumerate() {
        if only.is_some_and(|i| i != index) {
            continue;
        }
        for balls in [false, true] {
            for hint in [Hint::Homes, Hint::Platform, Hint::Starts] {
                let mut random = Random::new(index as u64);
                let posture = posture(pose, balls, &mut random);
                match found(&posture, hint, &mut random) {
                    // The table has six digits.
                    Ok((error, _)) if error < 1e-3 => {}
                    other => {
                        println!("{index} {hint:?} {balls}: {other:.3?}");
                        lost.push((index, balls, hint));
                    }
                }
            }
        }
    }
    assert!(lost.is_empty(), "{} of 240: {lost:?}", lost.len());
}
