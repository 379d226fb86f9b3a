#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    stiction_fuzz::trials::texts::robot_file(&String::from_utf8_lossy(bytes));
});
