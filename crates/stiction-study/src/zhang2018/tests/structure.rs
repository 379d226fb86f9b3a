use crate::zhang2018::study;
#[test]
fn probe() {
    let t = std::time::Instant::now();
    let report = study(|what, k, of| { eprintln!("{k}/{of} {what} {:?}", t.elapsed()); true }).unwrap();
    eprintln!("{:?}", t.elapsed());
    std::fs::write("/tmp/report.txt", format!("{report:#?}")).unwrap();
}
