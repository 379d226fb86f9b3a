use super::friction::*;
use super::lagrangian::*;
use super::reactions::*;
use super::robot::*;
use super::*;

#[test]
fn probe() {
    let robot = Robot::regular();
    let n = 2000;
    let home = Motion { pose: [0.060, 0.500, 65.0_f64.to_radians()], rate: [0.0; 3], acceleration: [0.0; 3] };
    let h = displacements(&robot, &home);
    let mut mean=[[0.0;3];3]; for k in 0..n { let d=displacements(&robot,&Robot::regular_motion(k as f64/n as f64)); for a in 0..3 { for b in 0..3 { mean[a][b]+=d[a][b]/n as f64; }}}
    let hp = |x:f64,z:f64,th:f64| displacements(&robot, &Motion{pose:[x,z,th.to_radians()],rate:[0.0;3],acceleration:[0.0;3]});
    let (ha,hb,hc,hd)=(hp(0.06,0.5,90.0),hp(0.0,0.505,90.0),hp(0.06,0.5,60.0),hp(0.06,0.53,65.0));
    let t0 = displacements(&robot, &Robot::regular_motion(0.0));
    let methods = [Method::Converged, Method::OnePass, Method::Literal(h), Method::Literal(mean),Method::Literal(ha),Method::Literal(hb),Method::Literal(hc),Method::Literal(hd),Method::Literal(t0), Method::PrismaticOnly, Method::WithoutRadius];
    let at = |k: usize| Robot::regular_motion((k as f64 + 0.0) / n as f64);
    let conv: Vec<_> = (0..n).map(|k| driving_forces_with_friction(&robot, &at(k), NO_LOAD, Method::Converged).unwrap()).collect();
    for m in methods {
        let rs: Vec<_> = (0..n).map(|k| driving_forces_with_friction(&robot, &at(k), NO_LOAD, m).unwrap()).collect();
        let work: f64 = rs.iter().map(|r| r.power_of_change()).sum::<f64>() / n as f64;
        let pct: Vec<f64> = (0..3).map(|l| { let a: f64 = rs.iter().map(|r| r.change()[l].powi(2)).sum(); let b: f64 = rs.iter().map(|r| r.ideal[l].powi(2)).sum(); (a/b).sqrt()*100.0 }).collect();
        let err: Vec<f64> = (0..3).map(|l| { let a: f64 = rs.iter().zip(&conv).map(|(r,c)| (r.change()[l]-c.change()[l]).powi(2)).sum(); let b: f64 = conv.iter().map(|r| r.change()[l].powi(2)).sum(); (a/b).sqrt()*100.0 }).collect();
        println!("{m:?}: {pct:?} err {err:?} work {work} passes {}", rs.iter().map(|r| r.passes).max().unwrap());
    }
    // wrong signs
    let m = Robot::regular_motion(0.3);
    println!("{:?} {:?}", ideal(&robot, &m, NO_LOAD), driving_forces_with_friction(&robot, &m, NO_LOAD, Method::Converged).map(|r| (r.ideal, r.drives)));
    for p in [Printed::ALL, Printed{platform:true,..Printed::NONE}, Printed{rods:true,..Printed::NONE}, Printed{bases:true,..Printed::NONE}] {
        let mut worst = [0.0f64;3]; let mut wf = [0.0f64;3]; let mut wt=[0.0f64;3];
        for k in 0..n { let m = at(k); let a = driving_forces(&robot, p, &m, NO_LOAD).unwrap(); let b = ideal(&robot,&m,NO_LOAD).unwrap();
            let m2 = Robot::printed_motion((k as f64)/n as f64); let pr=Robot::printed(); let fa = generalised_force(&pr,p,&m2); let fb = generalised_force(&pr,Printed::NONE,&m2);
            for i in 0..3 { worst[i] = worst[i].max((a[i]-b[i]).abs()); wf[i]=wf[i].max((fa[i]-fb[i]).abs()); wt[i]=wt[i].max(fb[i].abs()); } }
        println!("{p:?} twin tau {worst:?}; (29) F {wf:?} of {wt:?}");
    }
    for (r, name) in [(Robot::printed(), "printed"), (Robot::regular(), "regular")] {
        for form in [Form::Literal, Form::Printed, Form::Corrected] {
            let m = if name=="printed" {Robot::printed_motion(0.1)} else {Robot::regular_motion(0.1)};
            let s = System::new(&r, &m, NO_LOAD, form);
            let svd = stiction::linalg::Svd::new(&s.matrix);
            println!("{name} {form:?} rank {} ", svd.rank(1e-10));
        }
        let mut worst = [0.0f64; 3]; let mut size=[0.0f64;3];
        for k in 0..n { let m = if name=="printed" {Robot::printed_motion(k as f64/n as f64)} else {Robot::regular_motion(k as f64/n as f64)};
            // F_S,t from row of (23) y
            let get = |form| { let s = System::new(&r,&m,NO_LOAD,form); [0,1,2].map(|l| s.right[12*l+4]/s.matrix[(12*l+4, 14*l+11)]) };
            let a = get(Form::Printed); let b = get(Form::Corrected);
            for l in 0..3 { worst[l]=worst[l].max((a[l]-b[l]).abs()); size[l]=size[l].max(b[l].abs()); } }
        println!("F_St error {worst:?} of {size:?}");
    }
}
