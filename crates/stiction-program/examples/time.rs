use stiction::dynamics::*;
use stiction_model::*;
use stiction_program::InverseProgram;
fn main() {
    for name in std::env::args().skip(1) {
        let text = gallery::get(&name).unwrap();
        let model = read(&Source::new("x", text), &|_| Err("".into())).unwrap();
        let motion = model.motion(model.default_motion.as_deref().unwrap()).unwrap();
        let load = model.load(model.default_load.as_deref().unwrap()).unwrap();
        let coords: Vec<_> = motion.coordinates.iter().map(|(c, _)| *c).collect();
        let course: Vec<Vec<_>> = (0..10).map(|k| motion.at(0.1 * (k as f64 + 0.37) * motion.duration).collect()).collect();
        let mut solver = InverseDynamics::new(model.mechanism.clone(), &model.homes, &coords, &course[0], Settings::default()).unwrap();
        let loads: Vec<_> = load.at(0.1).collect();
        let t = std::time::Instant::now();
        let Some(p) = InverseProgram::record(&solver, &course, &loads) else { println!("{name}: none"); continue };
        println!("{name}: recorded in {:?}, ops {:?}, machine {}, lanes {}", t.elapsed(), p.operations(), p.is_machine_code(), p.lanes());
        for lanes in [1, p.lanes()] {
            let mut memories: Vec<_> = (0..8).map(|_| p.memory(lanes)).collect();
            for (k, m) in memories.iter_mut().enumerate() { for lane in 0..lanes { let tg = &course[(k + lane) % 10]; solver.move_to(tg).unwrap(); p.set(m, lane, solver.assembly().state(), tg, &loads); } }
            let mut settled = [false; 8];
            let (mut best0, mut best1) = (f64::MAX, f64::MAX);
            for _ in 0..300 {
                let t = std::time::Instant::now();
                for _ in 0..20 { for m in &mut memories { p.run_frictionless(m, &mut settled); assert!(settled[..lanes].iter().all(|s| *s)); } }
                best0 = best0.min(t.elapsed().as_nanos() as f64 / 160.0 / lanes as f64);
                let t = std::time::Instant::now();
                for _ in 0..20 { for m in &mut memories { p.run(m, &mut settled); assert!(settled[..lanes].iter().all(|s| *s)); } }
                best1 = best1.min(t.elapsed().as_nanos() as f64 / 160.0 / lanes as f64);
            }
            println!("  lanes {lanes}: begin {best0:.1} ns, all with friction {best1:.1} ns per state");
        }
    }
}
