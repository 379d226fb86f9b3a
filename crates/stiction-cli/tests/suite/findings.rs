//! Earlier findings of fuzzing: runs every file below `fuzz/findings` through the test of its
//! target.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time limit, far above the time of a single finding even in a slow build on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

fn findings(target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/findings").join(target);
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

#[test]
fn earlier_findings_stay_fixed() {
    let mut failed = Vec::new();
    let mut count = 0;
    for (target, trial) in crate::trials::TRIALS {
        for path in findings(target) {
            count += 1;
            let bytes = fs::read(&path).unwrap();
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let begun = Instant::now();
            let outcome = std::panic::catch_unwind(|| trial(&text));
            if outcome.is_err() || begun.elapsed() > PATIENCE {
                failed.push(format!("{} ({:?})", path.display(), begun.elapsed()));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(count > 0, "the findings are not where they should be");
}

/// Self-test: an intact checkpoint is resumed.
#[test]
fn an_intact_checkpoint_is_resumed() {
    let text = crate::trials::checkpoint::whole();
    assert!(text.contains("\"simulation\""), "{text}");
    crate::trials::checkpoint::checkpoint(&text);
}
