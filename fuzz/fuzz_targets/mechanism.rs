#![no_main]

//! Mechanisms that are made up: bytes are choices, see `making`.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = stiction_fuzz::making::mechanism(bytes);
    stiction_fuzz::making::keep(&text);
    stiction_fuzz::trials::runs::mechanism(&text);
});
