use super::pendulum;
use stiction::Error;

#[test]
fn a_stream_that_is_dropped_stops_its_computation() {
    let robot = pendulum();
    // Ten million samples would take minutes.
    let request =
        robot.inverse().motion("pivot = 1 rad*sin(t); duration = 2 s").unwrap().step(2e-7);
    let before = std::time::Instant::now();
    drop(request.samples().unwrap());
    let forward = robot.forward().at("pivot", 1.0).unwrap().until(1e5).step(1e-3);
    let three: Result<Vec<_>, Error> = forward.samples().unwrap().take(3).collect();
    assert_eq!(three.unwrap().len(), 3);
    assert!(before.elapsed().as_secs() < 30);
}

#[test]
fn a_receiver_that_fails_ends_the_run_with_its_own_error() {
    let mut count = 0;
    let error = pendulum()
        .inverse()
        .each(|_| {
            count += 1;
            if count < 5 { Ok(()) } else { Err(Error::input("the disk is full")) }
        })
        .unwrap_err();
    assert_eq!(error.to_string(), "the disk is full");
    assert_eq!(count, 5);
}
