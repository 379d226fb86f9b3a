use crate::zhang2018::study;
#[test]
fn probe() {
    let t = std::time::Instant::now();
    let report = study(|what, k, of| {
        eprintln!("{k}/{of} {what} {:?}", t.elapsed());
        true
    })
    .unwrap();
    eprintln!("{:?}", t.elapsed());
    std::fs::write("/tmp/report.txt", format!("{report:#?}")).unwrap();
}

#[test]
fn probe4() {
    use crate::zhang2018::robot::Robot;
    use crate::zhang2018::simulation::fold;
    let r = Robot::printed();
    for t in [0.0, 0.1, 0.25, 0.5] {
        for d in [1e-6, -1e-6, 1e-5, -1e-5] {
            for turn in [0.004f64, -0.004, 0.02, -0.02] {
                let p = fold(&r, t, d, turn);
                let h = Robot::printed_motion(t).pose;
                println!(
                    "{t} {d} {turn} {:?}",
                    p.map(|p| [
                        (p[0] - h[0]) * 1e3,
                        (p[1] - h[1]) * 1e3,
                        (p[2] - h[2]).to_degrees()
                    ])
                );
            }
        }
    }
}
