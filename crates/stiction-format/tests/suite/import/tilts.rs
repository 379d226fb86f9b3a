//! Ranges of the tilt of ball joints, from extension elements of MJCF files.

use super::mujoco::notes;
use super::tree::{convert, model};

/// A body on a ball, with the extension elements of the ball.
fn ball(elements: &[(&str, &str)]) -> String {
    let text = |(kind, data): &(&str, &str)| {
        format!("<text name='urn:stiction:1/{kind}/b' data='{data}'/>\n")
    };
    let texts: String = elements.iter().map(text).collect();
    format!(
        "<mujoco><worldbody><body name='a'><joint name='b' type='ball'/><geom type='box' size='.1 .2 .3'/></body>\
         </worldbody><custom>\n{texts}</custom></mujoco>"
    )
}

#[test]
fn tilts_need_axes_that_a_model_can_express() {
    const RANGE: (&str, &str) = ("range", "tilt = [0, 0.5]");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Frame J is turned about its z axis, or about x, so that its z axis is -y of the ground.
    let about_z = format!("{half} 0 0 {half} 1 0 0 0");
    let about_x = format!("{half} {half} 0 0 1 0 0 0");
    let upside_down = "0 1 0 0 1 0 0 0".to_owned();
    let no_axes = "the file does not contain the axes from which it is measured";
    let other = "it is measured from an axis of the first body other than z";
    for (axes, line, lost) in [
        (None, 2, Some(no_axes)),
        (Some(about_x), 1, Some(other)),
        (Some(upside_down), 1, Some(other)),
        (Some(about_z), 0, None),
    ] {
        let axes: Vec<(&str, &str)> = axes.iter().map(|axes| ("axes", axes.as_str())).collect();
        let imported = convert("r.xml", &ball(&[&[RANGE][..], &axes].concat()));
        let said = notes(&imported);
        let ranges = model(&imported).mechanism.joints()[0].ranges.len();
        match lost {
            Some(why) => {
                let start =
                    format!("r.xml:{line}: the range of the tilt of joint `b` is left out: {why}");
                assert!(said.contains(&start) && ranges == 0, "{axes:?} {ranges}: {said}");
            }
            None => assert!(!said.contains("tilt") && ranges == 1, "{axes:?} {ranges}: {said}"),
        }
    }
}
