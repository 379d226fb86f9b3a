//! Colours of pictures for light and dark backgrounds.
//!
//! Colours are literal values, because programs other than browsers do not support CSS variables;
//! such programs use the light colours.

/// Colours of branches (legs) on a light background. The colours are distinguishable on paper, on
/// screen and with most colour vision deficiencies (after Okabe and Ito), and none resembles the
/// yellow of actuated joints.
pub const BRANCHES: [&str; 7] =
    ["#0072b2", "#c1440e", "#00835f", "#b0478c", "#7a6000", "#2c8fc9", "#666666"];
/// Colours of branches (legs) on a dark background, in the order of [`BRANCHES`].
pub const BRANCHES_ON_DARK: [&str; 7] =
    ["#5ab4e8", "#f08a5d", "#3fc79d", "#e29ac7", "#c9b458", "#93d0f3", "#b0b0b0"];

/// Number of colours of branches.
pub(super) const COLOURS: usize = BRANCHES.len();

/// Background of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Transparent background; light or dark colours according to the reader's preference.
    Inline,
    /// White background, like a sheet of paper.
    Paper,
}

/// Style sheet (CSS) of a picture.
pub(super) fn style(surface: Surface) -> String {
    let mut css = String::from(
        ".mechanism{font-family:Helvetica,Arial,sans-serif;font-size:14px}\
         .mechanism line,.mechanism polyline{fill:none;stroke-linecap:round;stroke-linejoin:round}\
         .mechanism .bone{stroke-width:6}\
         .mechanism .tube{stroke-width:9}\
         .mechanism .stem{stroke-width:4.5}\
         .mechanism .bone-halo{stroke-width:9}\
         .mechanism .tube-halo{stroke-width:12}\
         .mechanism .stem-halo{stroke-width:7.5}\
         .mechanism .axis{stroke-width:1;stroke-dasharray:6 3 1.5 3;stroke-linecap:butt}\
         .mechanism .rod{stroke-width:3}\
         .mechanism .detail{stroke-width:1.1}\
         .mechanism .leader,.mechanism .hatch{stroke-width:1}\
         .mechanism .rail{stroke-width:2}\
         .mechanism .trail{stroke-width:1.6;stroke-opacity:.65}\
         .mechanism .bar{stroke-width:2;stroke-linecap:butt}\
         .mechanism .free{fill:none;stroke-dasharray:2.5 2.5}\
         .mechanism .hub,.mechanism .plate{stroke-width:2;stroke-linejoin:round}\
         .mechanism .hub{fill-opacity:.5}\
         .mechanism .plate{fill-opacity:.35;stroke-width:1}\
         .mechanism .joint path,.mechanism .joint polygon,.mechanism .joint circle{stroke-width:1.3;\
         stroke-linejoin:round}\
         .mechanism .joint .pin,.mechanism .joint .glint{stroke:none}\
         .mechanism .name{font-weight:bold}\
         .mechanism .quiet{font-size:13px}",
    );
    css += &colours(&TONES);
    if surface == Surface::Inline {
        css += "@media screen and (prefers-color-scheme:dark){";
        css += &colours(&TONES_ON_DARK);
        css += "}";
    }
    css
}

/// Returns pairs of a name and a colour for the parts of a picture; the style sheet of a page uses
/// the names. `is_dark` selects the colours for a dark background.
pub(crate) fn tones(is_dark: bool) -> [(&'static str, &'static str); 7] {
    let tones = if is_dark { &TONES_ON_DARK } else { &TONES };
    [
        ("side", tones.side),
        ("drive", tones.drive),
        ("driveside", tones.drive_side),
        ("hub", tones.hub),
        ("hubedge", tones.hub_edge),
        ("plate", tones.plate),
        ("mark", tones.soft),
    ]
}

const TONES: Tones = Tones {
    ink: "#222222",
    soft: "#6f6f6f",
    paper: "#ffffff",
    side: "#d9dde2",
    drive: "#ffd21f",
    drive_side: "#e0a800",
    hub: "#9fb0c3",
    hub_edge: "#44576b",
    plate: "#bcbcbc",
    branches: &BRANCHES,
};

const TONES_ON_DARK: Tones = Tones {
    ink: "#e8e8e8",
    soft: "#a5a5a5",
    paper: "#1c1f24",
    side: "#3d444d",
    drive: "#d9a400",
    drive_side: "#9a7400",
    hub: "#55677c",
    hub_edge: "#a9bccf",
    plate: "#5c5c5c",
    branches: &BRANCHES_ON_DARK,
};

struct Tones {
    ink: &'static str,
    soft: &'static str,
    paper: &'static str,
    side: &'static str,
    drive: &'static str,
    drive_side: &'static str,
    hub: &'static str,
    hub_edge: &'static str,
    plate: &'static str,
    branches: &'static [&'static str; COLOURS],
}

fn colours(tones: &Tones) -> String {
    let Tones { ink, soft, paper, side, drive, drive_side, hub, hub_edge, plate, branches } = tones;
    let mut css = format!(
        ".mechanism text{{fill:{ink};stroke:{paper};stroke-width:3;stroke-linejoin:round;\
         paint-order:stroke}}\
         .mechanism .quiet{{fill:{soft}}}\
         .mechanism .sheet{{fill:{paper}}}\
         .mechanism .axis,.mechanism .leader,.mechanism .hatch{{stroke:{soft}}}\
         .mechanism .halo{{stroke:{paper};fill:none}}\
         .mechanism .rod,.mechanism .detail,.mechanism .bar,.mechanism .free{{stroke:{ink}}}\
         .mechanism .rail{{stroke:{soft}}}\
         .mechanism .trail{{stroke:{hub_edge}}}\
         .mechanism .hub{{fill:{hub};stroke:{hub_edge}}}\
         .mechanism .plate{{fill:{plate};stroke:{soft}}}\
         .mechanism .joint path,.mechanism .joint polygon,.mechanism .joint circle{{stroke:{ink}}}\
         .mechanism .joint-face{{fill:{paper}}}\
         .mechanism .joint-side{{fill:{side}}}\
         .mechanism .drive-face{{fill:{drive}}}\
         .mechanism .drive-side{{fill:{drive_side}}}\
         .mechanism .pin,.mechanism .weld,.mechanism .com{{fill:{ink}}}\
         .mechanism .glint{{fill:{side}}}"
    );
    for (k, colour) in branches.iter().enumerate() {
        css += &format!(".mechanism .b{k}{{stroke:{colour}}}.mechanism .t{k}{{fill:{colour}}}");
    }
    css
}
