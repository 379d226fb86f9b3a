//! HTML pages of checks in a browser. The pages load nothing, run no script except the viewer, and
//! show all content, wide or narrow, light or dark. Screenshots are written to `target/browser`.

use crate::chromium::look_at_with_script;
use crate::common::{default_job, model};
use stiction_core::dynamics::FrictionMode;
use stiction_draw::viewer::SCRIPT;
use stiction_run::check::{draw_page, examine};

fn check_page(name: &str) -> String {
    let model = model(name);
    let job = default_job(&model, FrictionMode::Off);
    let findings = examine(&job, |_, _, _| true).unwrap();
    draw_page(&job, &findings, None).unwrap().html
}

#[test]
fn pages_of_checks() {
    for name in ["zhang2018", "3rps"] {
        look_at_with_script(&format!("check-{name}"), &check_page(name), SCRIPT);
    }
}
